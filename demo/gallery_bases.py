# SPDX-License-Identifier: Apache-2.0
"""One pose of a box lattice in three bases, and the convergence of subdivision to B-splines."""

import itertools

import numpy as np
import vtk
from vtk.util import numpy_support

from chart import log_chart
from gallery_parts import BLUE, Figure, Look, extent, panels
from geometry_files import LatticeFile, points_of, read_model, vtk_points
from images import column, legend
from parametric import make_block
from picture import LATTICE, Drawing
from quad_mesh import write_materials, write_obj

#: The model fills the region of the B-spline: the box without its outer layer of cells.
CELL = 1.05
CELLS = np.array([5, 3, 3])
HALF = CELLS * CELL / 2
REST = (f"shape box --cells {CELLS[0]} {CELLS[1]} {CELLS[2]} "
        "--min " + " ".join(f"{-x:g}" for x in HALF) + " --max " +
        " ".join(f"{x:g}" for x in HALF) + " -o rest.vtu")
LOOK = Look((0.32, -1, 0.42), height=300, margin=0.05)
LEVEL = 3  # level of the subdivision that is shown next to the other bases
LEVELS = (1, 2, 3, 4, 5, 6)


def write_pose(source, target):
    """Writes the lattice with its two middle layers lifted, as an editor would do it."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(source))
    reader.Update()
    grid = reader.GetOutput()
    points = numpy_support.vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    points[np.abs(points[:, 0]) < CELL, 2] += 1.6
    grid.SetPoints(vtk_points(points))
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(target))
    writer.SetInputData(grid)
    writer.Write()


def make_inputs(program):
    write_materials(program.file("demo.mtl"))
    write_obj(program.file("block.obj"), "block", make_block(), "demo.mtl")
    program.note("block.obj: the block of scripts/demo")
    program.run(REST)
    write_pose(program.file("rest.vtu"), program.file("pose.vtu"))
    program.note("pose.vtu: rest.vtu with its two middle layers lifted by the script")


def draw_bases(program):
    make_inputs(program)
    rest, pose = (LatticeFile(program.file(f"{name}.vtu")) for name in ("rest", "pose"))
    model = read_model(program.file("block.obj"))
    shown = [(model, rest, "At rest")]
    for basis, options, title in (("bezier", "", "Bézier"), ("bspline", "", "B-spline"),
                                  ("subdivision", f"-n {LEVEL} ", "Subdivision")):
        program.run(f"deform block.obj --rest rest.vtu --to pose.vtu --basis {basis} {options}"
                    f"-o {basis}.obj")
        shown.append((read_model(program.file(f"{basis}.obj")), pose, title))
    distance = largest_distance(*(points_of(shape) for shape, _, _ in shown[-2:]))
    program.numbers["distance"] = f"{distance:.1g}"
    line = 0.0026 * extent(pose.points, LOOK)
    drawings = []
    for shape, lattice, _ in shown:
        drawing = Drawing().add_model(shape)
        outer = lattice.edges[lattice.edge_strata < 3]
        drawings.append(drawing.add_edges(lattice.points, outer, LATTICE, line))
    drawings[0].add_edges(*box_edges(HALF - CELL), BLUE, line)
    picture = panels(drawings, [title for _, _, title in shown], LOOK, gap=18)
    entries = [(LATTICE, "lattice: the region of Bézier and of subdivision", "line"),
               (BLUE, "the region of the B-spline", "line")]
    return column([picture, legend(entries, picture.shape[1])], gap=4)


def largest_distance(points, others):
    """Returns the largest distance of points with the same number, in cells of the lattice."""
    return np.linalg.norm(points - others, axis=1).max() / CELL


def box_edges(half):
    """The corners of a box about the origin, and its twelve edges."""
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    pairs = [(i, j) for i, j in itertools.combinations(range(8), 2)
             if np.abs(signs[i] - signs[j]).sum() == 2]
    return signs * half, pairs


def draw_convergence(program):
    make_inputs(program)

    def deformed(options, name):
        program.run(f"deform block.obj --rest rest.vtu --to pose.vtu {options} -o {name}.obj")
        return points_of(read_model(program.file(f"{name}.obj")))

    exact = deformed("--basis bspline", "bspline")
    errors = []
    for level in LEVELS:
        points = deformed(f"--boundary open -n {level}", f"open-{level}")
        errors.append(largest_distance(points, exact))
    picture = log_chart(LEVELS, errors, BLUE, "level", "cells", (640, 360))
    return column([picture, legend([(BLUE, "largest distance from the B-spline", "point")],
                                   picture.shape[1], size=16)])


FIGURES = [
    Figure(
        "bases", "Before lattices of arbitrary topology",
        "MacCracken & Joy 1996, section 1, on Sederberg & Parry and on Griessmair & Purgathofer",
        f"A block in a box lattice of {' × '.join(map(str, CELLS))} cells, whose two middle layers "
        "are lifted. Bézier: each vertex moves the whole block, but none moves it much. B-spline: "
        f"each vertex moves only the points near it. Subdivision, at level {LEVEL}, moves this "
        "block as the B-spline does, to within {distance} of a cell. Its region is the whole box; "
        "the region of the B-spline ends one cell earlier.",
        draw_bases),
    Figure(
        "convergence", "Subdivision becomes the B-spline", "MacCracken & Joy 1996, section 4",
        "The largest distance between the points of the block moved with `--basis bspline` and "
        "with `--boundary open -n`, in cells of the lattice; lower is closer. It falls by a "
        "factor of four with each level. So the approximation that the paper calls arbitrarily "
        "close is of second order.",
        draw_convergence),
]
