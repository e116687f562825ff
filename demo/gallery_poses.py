# SPDX-License-Identifier: Apache-2.0
"""A lattice around a model and poses of it, by `shape around` and `pose`; the operations of Barr 1984."""

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
]
