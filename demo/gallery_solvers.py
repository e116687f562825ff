# SPDX-License-Identifier: Apache-2.0
"""Draws results of the examples: an optimised section, an elastic lattice, a fit over two ranks."""

import math
import pathlib
import re

import numpy as np
from vtk.util import numpy_support

from chart import line_chart
from gallery_parts import AMBER, BLUE, DARK, PALE_SKY, Figure, Look, Mesh, extent, panels, render
from geometry_files import LatticeFile, surface, with_normals
from images import captioned, column, legend, row
from parametric import make_block
from picture import GHOST, LATTICE, Drawing

# The section and its lattice are in a plane, and are drawn in it.
FLAT = Look((0, 0, 1), up=(0, 1, 0), height=190, occlusion=False, margin=0.03)
BENT = Look((0.42, -1, 0.42), height=290, occlusion=False, margin=0.02)

SHAPE = "--end-segments 12 --bar-segments 4 --layers 2"
HELD, WEIGHT, FINE = -1.75, 1.75e-4, 3
TURNED = Look((0.50, -1, 0.45), height=300, occlusion=False, margin=0.02)
TWIST = 1.9  # radians from end to end
RANKS = ((BLUE, "rank 0"), (AMBER, "rank 1"))
#: Settings of Open MPI as in the tests: it runs as root, as in containers, with more ranks than cores.
OPEN_MPI = dict(re.findall(r"^ *(OMPI_\w+)=(\w+)", (
    pathlib.Path(__file__).resolve().parents[1] / "cmake/MpiTests.cmake").read_text("utf-8"), re.M))
GRADIENT = ((0.90, 0.93, 0.95), (0.60, 0.80, 0.90), BLUE)  # from no displacement to the largest one


def draw_aerofoil(program):
    printed = program.run_any("aerofoil.py --program espalier --work .")
    program.note("it writes section.obj, and runs espalier shape, stencils and deform")
    program.note("if python3 is not Debian's: /usr/bin/python3 examples/aerofoil.py ...")
    for line in printed.splitlines()[:2]:
        program.numbers[line.split()[0]] = f"{float(re.search('lift ([0-9.]+)', line)[1]):.2f}"
    program.numbers["iterations"] = re.search("([0-9]+) iterations", printed)[1]
    program.run("refine rest.ovm -n 0 -o rest.vtu")
    program.run("refine pose.ovm -n 0 -o pose.vtu")
    rest, pose = (LatticeFile(program.file(f"{name}.vtu")) for name in ("rest", "pose"))
    first, last = (Mesh.read(program.file(f"{name}.obj")) for name in ("section", "optimised"))
    line = 0.0075 * extent(rest.points, FLAT)
    drawings = []
    for lattice, section, ghost in ((rest, first, []), (pose, last, first.edges)):
        front = lattice.points[:, 2] > 0.09  # the other side is behind
        drawing = Drawing().add_edges(first.points, ghost, GHOST, line)
        drawing.add_faces(section.points, [list(range(len(section.points)))], PALE_SKY)
        drawing.add_edges(section.points, section.edges, DARK, line)
        drawing.add_edges(lattice.points, lattice.edges[front[lattice.edges].all(axis=1)], LATTICE,
                          0.8 * line)
        drawings.append(drawing.add_points(lattice.points[front], LATTICE, 2.4 * line))
    images, _ = render(drawings, FLAT)
    captions = ("NACA 0012 in its lattice", "Optimised, with NACA 0012 in grey")
    sections = column([captioned(image, caption, 17)
                       for image, caption in zip(images, captions)])
    x, before, wanted, after = np.loadtxt(program.file("pressures.txt")).T
    looks = ((before, GHOST, 2), (wanted, AMBER, 7), (after, BLUE, 2))
    curves = [(np.stack([x, y], axis=1), colour, thickness) for y, colour, thickness in looks]
    chart = line_chart(curves, [0, 0.2, 0.4, 0.6, 0.8, 1], [1, 0.5, 0, -0.5, -1, -1.5],
                       "share of the chord", "pressure coefficient", (560, sections.shape[0]))
    picture = row([sections, chart], gap=24)
    return column([picture, legend([(LATTICE, "lattice", "line"), (PALE_SKY, "section", "area"),
                                    (GHOST, "pressure before", "line"), (AMBER, "wanted", "line"),
                                    (BLUE, "after", "line")], picture.shape[1], size=17)], gap=6)


def draw_elastic(program):
    program.run(f"shape barbell {SHAPE} --end-radius 0.62 --bar-length 2.3 --bar-half-width 0.2 "
                "--height 0.3 -o slim.vtu")
    program.run(f"refine slim.vtu -n {FINE} -o slim-{FINE}.vtu")
    slim = LatticeFile(program.file(f"slim-{FINE}.vtu"))
    used, inverse = np.unique(np.concatenate(slim.boundary), return_inverse=True)
    mesh = Mesh(slim.points[used], inverse.reshape(-1, 4).tolist())
    mesh.write(program.file("model.obj"))
    program.note(f"model.obj: the boundary of slim-{FINE}.vtu, {len(used)} points, written by the "
                 "script")
    program.run(f"shape barbell {SHAPE} --end-radius 0.75 --bar-length 2.2 --bar-half-width 0.3 "
                "--height 0.4 -o rest.vtu")
    program.run_any(f"elastic_lattice model.obj rest.vtu {HELD} {WEIGHT:g} sagged.obj pose.vtu")
    rest, pose = (LatticeFile(program.file(f"{name}.vtu")) for name in ("rest", "pose"))
    sagged = Mesh.read(program.file("sagged.obj"))
    moved = np.linalg.norm(sagged.points - mesh.points, axis=1)
    free = mesh.points[:, 0] > -HELD
    program.numbers["growth"] = rounded_up(100 * stretch(mesh.points[free], sagged.points[free]))
    program.numbers["weight"] = f"{WEIGHT:g}"
    program.numbers["length"] = f"{np.ptp(mesh.points[:, 0]):.2g}"
    line = 0.0035 * extent(rest.points, BENT)
    held = rest.points[rest.points[:, 0] <= HELD]
    drawings = []
    for shape, lattice, share in ((mesh, rest, 0 * moved), (sagged, pose, moved / moved.max())):
        drawing = Drawing().add_model(painted(shape, shade(share)))
        drawing.add_edges(lattice.points, lattice.edges[lattice.edge_strata < 3], LATTICE, line)
        drawings.append(drawing.add_points(held, DARK, 3.5 * line))
    picture = panels(drawings, ["At rest", "Under its weight"], BENT, gap=32)
    scale = [(colour, f"{words}{share * moved.max():.2g}", "area") for words, colour, share in
             zip(("displaced by ", "", ""), GRADIENT, (0, 0.5, 1))]
    return column([picture, legend([(LATTICE, "lattice", "line"), (DARK, "held", "point"), *scale],
                                   picture.shape[1], size=17)], gap=4)


def stretch(rest, moved):
    """Returns the largest relative elongation by the affine map that is closest to a movement."""
    affine, *_ = np.linalg.lstsq(np.column_stack([rest, np.ones(len(rest))]), moved, rcond=None)
    return np.linalg.svd(affine[:3], compute_uv=False)[0] - 1


def rounded_up(value, digits=2):
    """Returns the value with `digits` digits, rounded up."""
    unit = 10.0**(math.floor(math.log10(value)) + 1 - digits)
    return f"{math.ceil(value / unit) * unit:.{digits}g}"


def shade(share):
    """Returns colours from the first of GRADIENT (share 0) to the last (share 1)."""
    stops = np.linspace(0, 1, len(GRADIENT))
    return np.stack([np.interp(share, stops, channel) for channel in zip(*GRADIENT)], axis=1)


def painted(mesh, colours):
    """Converts a mesh to VTK, with a colour at each point."""
    data = surface(mesh.points, mesh.loops)
    data.GetPointData().SetScalars(numpy_support.numpy_to_vtk((colours * 255).astype(np.uint8),
                                                              deep=1))
    return with_normals(data)


def draw_ranks(program):
    block = make_block()
    order = np.argsort(block.points[:, 0], kind="stable")
    faces = np.argsort(order)[block.quads]
    mesh = program.write(Mesh(block.points[order], faces.tolist()), "block.obj")
    x, y, z = mesh.points.T
    turn = TWIST * x / np.ptp(x)
    wanted = np.stack([x, y * np.cos(turn) - z * np.sin(turn), y * np.sin(turn) + z * np.cos(turn)],
                      axis=1)
    Mesh(wanted, mesh.loops).write(program.file("wanted.obj"))
    program.note("wanted.obj: the same, twisted, written by the script")
    program.run("shape box --cells 6 2 2 --min -1.6 -0.6 -0.6 --max 1.6 0.6 0.6 -o rest.vtu")
    program.note("as root, for example in a container: "
                 "mpirun --allow-run-as-root --oversubscribe ...")
    program.run_any("mpirun -n 2 petsc_fit block.obj rest.vtu wanted.obj fitted.obj pose.vtu",
                    OPEN_MPI)
    fitted = Mesh.read(program.file("fitted.obj"))
    program.numbers["miss"] = rounded_up(np.linalg.norm(fitted.points - wanted, axis=1).max())
    rest, pose = (LatticeFile(program.file(f"{name}.vtu")) for name in ("rest", "pose"))
    # As petsc::evenRange: if the points cannot be split evenly, the first ranks get one more.
    owner = (np.arange(len(x)) >= (len(x) + 1) // 2).astype(int)
    colours = np.array([colour for colour, _ in RANKS])[owner]
    line = 0.0040 * extent(rest.points, TURNED)
    drawings = []
    for shape, lattice in ((mesh, rest), (fitted, pose)):
        drawing = Drawing().add_model(painted(shape, colours))
        drawings.append(drawing.add_edges(lattice.points,
                                          lattice.edges[lattice.edge_strata < 3], LATTICE, line))
    picture = panels(drawings, ["At rest", "Fitted to the twisted block"], TURNED,
                     gap=32)
    entries = [(LATTICE, "lattice", "line"), *((*rank, "area") for rank in RANKS)]
    return column([picture, legend(entries, picture.shape[1], size=17)], gap=4)


FIGURES = [
    Figure(
        "aerofoil", "An aerofoil section gets the pressure that is wanted",
        "examples/aerofoil.py; MacCracken & Joy 1996, section 5",
        "A NACA 0012 section at an incidence of 2°, in a lattice one cell thick. It is deformed "
        "until it has the pressure of NACA 4412. A panel method computes the pressure, and an "
        "adjoint solve the gradient of the error by the points of the section; the transpose of "
        "the deformation matrix, Dᵀ, turns it into a gradient by the lattice vertices. SciPy "
        "moves these vertices up and down, in {iterations} iterations. Both ends of the section "
        "and its area stay the same. The lift coefficient rises from {before} to {after}.",
        draw_aerofoil),
    Figure(
        "elastic", "An elastic lattice carries a model",
        "examples/elastic_lattice.cpp; MacCracken & Joy 1996, section 5",
        "A barbell in a lattice of elastic material; some vertices of the lattice are held. Dᵀ "
        "turns the weight of the model's points into forces on the lattice vertices. Eigen "
        "solves for the displacements, with the cells of level 2 as finite elements. D moves the "
        "points. The barbell is {length} units long; it weighs {weight} of Young's modulus times "
        "the square of the unit. Displacements are in that unit. Elasticity is linear, so parts "
        "that rotate seem to grow: here the free end by {growth} %.",
        draw_elastic),
    Figure(
        "ranks", "A fit over two ranks", "examples/petsc_fit.cpp; MacCracken & Joy 1996, section 5",
        "Each rank (MPI process) binds its own points, drawn in one colour, and holds only their "
        "rows of the deformation matrix D. PETSc's solver LSQR finds how the lattice must move "
        "to carry all points to given places, here on a twisted block. It multiplies by D and "
        "Dᵀ, and the ranks exchange lattice vertices for these products. No point is further "
        "than {miss} from its place.",
        draw_ranks),
]
