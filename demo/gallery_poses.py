# SPDX-License-Identifier: Apache-2.0
"""A lattice around a model and poses of it, by `shape around` and `pose`; the operations of Barr 1984."""

import numpy as np

from figure import make_figure
from gallery_parts import AMBER, Figure, Look, Mesh, extent, panels
from geometry_files import LatticeFile
from images import column
from parametric import make_block
from picture import LATTICE, Drawing, LatticeStyle

UPRIGHT = Look((0.75, 0.25, 1), up=(0, 1, 0), height=430, margin=0.02)
LYING = Look((0.45, -1, 0.5), height=210, margin=0.03)
OPERATIONS = ("--move 0 0 0.8", "--rotate z 40", "--scale 1 1.6 0.6", "--twist x 120",
              "--toward z --bend x 90", "--taper x 0.3",
              "--select end +x --falloff smooth 2.5 --move 0 0 1",
              "--select ball 0 0 0.6 0.7 --falloff smooth 1 --move 0 0 0.8")


def mesh_of(made):
    """Returns the Mesh of a QuadMesh."""
    return Mesh(made.points, [list(map(int, quad)) for quad in made.quads])


def draw_model(mesh, lattice=None, line=0.0):
    drawing = Drawing().add_faces(mesh.points, mesh.loops, AMBER, smooth=True)
    if lattice is not None:
        drawing.add_lattice(lattice, LatticeStyle(tube=line, ball=2.6 * line,
                                                  colours=(LATTICE,) * 4))
    return drawing


def draw_three_commands(program):
    model = program.write(mesh_of(make_figure()), "model.obj")
    program.run("shape around model.obj -o rest.vtu")
    program.run("pose rest.vtu --twist y 90 -o posed.vtu")
    program.run("deform model.obj --rest rest.vtu --to posed.vtu -o twisted.obj")
    rest, posed = (LatticeFile(program.file(f"{name}.vtu")) for name in ("rest", "posed"))
    line = 0.0022 * extent(rest.points, UPRIGHT)
    twisted = Mesh.read(program.file("twisted.obj"))
    return panels([draw_model(model, rest, line), draw_model(twisted, posed, line),
                   draw_model(twisted)],
                  ["The model, and shape around", "pose --twist y 90, and deform",
                   "The deformed model"], UPRIGHT, gap=50)


def draw_operations(program):
    program.write(mesh_of(make_block()), "block.obj")
    program.run("shape around block.obj --cells 6 -o rest.vtu")
    rest = LatticeFile(program.file("rest.vtu"))
    line = 0.006 * extent(rest.points, LYING)
    drawings = []
    for i, operation in enumerate(OPERATIONS):
        program.run(f"pose rest.vtu {operation} -o posed-{i}.vtu")
        program.run(f"deform block.obj --rest rest.vtu --to posed-{i}.vtu -o block-{i}.obj")
        drawings.append(draw_model(Mesh.read(program.file(f"block-{i}.obj")),
                                   LatticeFile(program.file(f"posed-{i}.vtu")), line))
    points = [p for drawing in drawings for p in drawing.points]
    rows = [panels(drawings[first:first + 2], OPERATIONS[first:first + 2], LYING, points=points,
                   gap=30, width=520)
            for first in range(0, len(drawings), 2)]
    return column(rows, gap=10)


def plate(count=120):
    """A square of quadrilaterals whose points have a weight: the red of a colour, which grows along x."""
    along = np.linspace(-2, 2, count + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(along, along, indexing="ij"))
    points = np.stack([x, y, 0 * x], 1)
    at = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], -1).reshape(-1, 4)
    t = np.clip((x + 0.5) / 1, 0, 1)
    return points, quads, t * t * (3 - 2 * t)


def draw_parts(program):
    points, quads, red = plate()
    lines = ["v %.6g %.6g %.6g %.4g 0 0" % (*p, r) for p, r in zip(points, red, strict=True)]
    lines += ["f %d %d %d %d" % tuple(quad) for quad in quads + 1]
    program.note(f"plate.obj: {len(points)} points, written by the script")
    program.file("plate.obj").write_text("\n".join(lines) + "\n")
    program.run("shape box --cells 2 2 1 --min -0.8 -0.8 -0.5 --max 0.8 0.8 0.5 -o rest.vtu")
    program.run("pose rest.vtu --move 0 0 0.9 --rotate z 50 -o posed.vtu")
    posed = LatticeFile(program.file("posed.vtu"))
    drawings, captions = [], ("the default", "--falloff 1", "--falloff 1 --weights red")
    for i, options in enumerate(("--outside keep", *captions[1:])):
        program.run(f"deform plate.obj --rest rest.vtu --to posed.vtu {options} -o plate-{i}.obj")
        drawings.append(draw_model(Mesh.read(program.file(f"plate-{i}.obj")), posed, 0.012))
    return panels(drawings, captions, Look((0.5, -1, 0.75), height=330, margin=0.02), gap=30)


FIGURES = [
    Figure(
        "three-commands", "A model of your own in three commands",
        "Three commands",
        "A box lattice around a model, the lattice twisted by a quarter turn, and the model that "
        "follows it. No coordinate is typed.",
        draw_three_commands),
    Figure(
        "operations", "The operations of espalier pose",
        "Barr 1984",
        "A block in a lattice of 6 cells along its longest side, and its poses. Selections choose "
        "the vertices that move; a falloff lets the movement fade with the distance from them.",
        draw_operations),
    Figure(
        "parts", "A part of a model",
        "A falloff and weights",
        "A lattice around the middle of a plate is lifted and turned. Points outside the lattice stay, and the "
        "faces at its edge are stretched. With a falloff they follow in part, and no edge shows. A weight at each point, here a "
        "colour that grows from the left to the right, says how far it follows.",
        draw_parts),
]
