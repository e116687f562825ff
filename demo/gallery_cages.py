# SPDX-License-Identifier: Apache-2.0
"""Cages of models, by `shape cage`, and a deformation that a box cannot do."""

import numpy as np

import cage_models
from gallery_parts import AMBER, Figure, Look, Mesh, extent, panels
from geometry_files import LatticeFile
from images import column
from picture import LATTICE, Drawing, LatticeStyle

FRONT = Look((0.35, 0.15, 1), up=(0, 1, 0), height=420, margin=0.02)
TURNED = Look((0.6, -1, 0.55), height=250, margin=0.02)
#: A selection of the vertices around one finger of the hand, and what it does.
BEND = "--select box 0.45 1.1 -0.5 2 2 0.5 --center 0.6 1.1 0 --rotate x 60"
MODELS = ("mug", "octopus", "chain", "fins")


def draw_in(mesh, lattice, line):
    """A model in its lattice."""
    style = LatticeStyle(tube=line, ball=2.2 * line, colours=(LATTICE,) * 4)
    return Drawing().add_faces(mesh.points, mesh.loops, AMBER, smooth=True).add_lattice(lattice,
                                                                                        style)


def write_model(program, name):
    """Writes a model of cage_models.py, and returns it as the program reads it."""
    cage_models.write_obj(program.file(f"{name}.obj"), cage_models.MODELS[name]())
    program.note(f"{name}.obj: written by demo/cage_models.py")
    return Mesh.read(program.file(f"{name}.obj"))


def moved_points(model, deformed):
    """Returns the number of points whose coordinates differ in any bit."""
    return int(np.any(model.points != deformed.points, axis=1).sum())


def draw_finger(program):
    model = write_model(program, "hand")
    drawings, captions = [], []
    for name, shape in (("cage", "cage hand.obj --vertices 300 --keep-apart"),
                        ("box", "around hand.obj --cells 8")):
        program.run(f"shape {shape} -o {name}.vtu")
        program.run(f"pose {name}.vtu {BEND} -o {name}-posed.vtu")
        program.run(f"deform hand.obj --rest {name}.vtu --to {name}-posed.vtu -o {name}-hand.obj")
        rest, posed = (LatticeFile(program.file(f"{name}{end}.vtu")) for end in ("", "-posed"))
        line = 0.0022 * extent(rest.points, FRONT)
        deformed = Mesh.read(program.file(f"{name}-hand.obj"))
        if name == "cage":
            drawings.append(draw_in(model, rest, line))
            captions.append(f"A cage of {len(rest.points)} vertices")
        drawings.append(draw_in(deformed, posed, line))
        captions.append(f"The {name}, posed: {moved_points(model, deformed):,} of "
                        f"{len(model.points):,} points move")
        program.numbers[name] = f"{moved_points(model, deformed):,}"
    return panels(drawings, captions, FRONT, gap=40, width=420)


def draw_models(program):
    rows = []
    for name in MODELS:
        model = write_model(program, name)
        drawings, captions = [], []
        for vertices in (60, 200, 500):
            program.run(f"shape cage {name}.obj --vertices {vertices} -o {name}-{vertices}.vtu")
            lattice = LatticeFile(program.file(f"{name}-{vertices}.vtu"))
            drawings.append(draw_in(model, lattice, 0.0028 * extent(lattice.points, TURNED)))
            captions.append(f"{len(lattice.points)} vertices")
        rows.append(panels(drawings, captions, TURNED, gap=10, width=450))
    return column(rows, gap=10)


FIGURES = [
    Figure(
        "finger", "A finger bends",
        "shape cage",
        "The cells of a cage follow the fingers, so that each finger has vertices of its own. The "
        "same pose of a box of about as many vertices takes the neighbours along: {box} points "
        "move. With the cage, the {cage} points of the finger move, and no other coordinate "
        "changes by a bit.",
        draw_finger),
    Figure(
        "cages", "Cages",
        "shape cage",
        "A mug, an octopus, three linked rings and a body with thin plates, in cages of about 60, "
        "200 and 500 vertices.",
        draw_models),
]
