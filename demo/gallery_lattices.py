# SPDX-License-Identifier: Apache-2.0
"""Whole lattices and the regions that they define: Figures 1, 4 and 5 of MacCracken & Joy 1996."""

from dataclasses import replace

from gallery_parts import BLUE, DARK, PALE_SKY, Figure, Look, extent, panels
from geometry_files import LatticeFile, boundary_of, edges_of
from images import column, legend
from picture import GHOST, STRATA, Drawing, LatticeStyle

LOOK = Look(direction=(0.62, -1, 0.55), height=300)
#: With occlusion, the translucent lattice would cast shadows on the region inside.
FLAT_LOOK = replace(LOOK, occlusion=False)
SHAPES = (("box", "--cells 4 3 3 --max 4 3 3"),
          ("cylinder", "--sectors 8 --rings 2 --layers 3 --radius 1.7 --to 0 0 3"))
LEGEND = [(STRATA[0], "corner", "point"), (STRATA[1], "sharp", "line"),
          (STRATA[2], "boundary", "line"), (STRATA[3], "inside", "line")]


def bases(program):
    """The name, the lattice and the thickness of lines of each shape."""
    for name, options in SHAPES:
        program.run(f"shape {name} {options} -o {name}.vtu")
        base = LatticeFile(program.file(f"{name}.vtu"))
        yield name, base, 0.0030 * extent(base.points, LOOK)


def levels_of(program, name, levels, options=""):
    """Returns levels of an existing lattice as LatticeFile, without level 0."""
    found = []
    for level in levels:
        tag = "-open" if options else ""
        output = f"{name}{tag}-{level}.vtu"
        program.run(f"refine {name}.vtu {options}-n {level} -o {output}")
        found.append(LatticeFile(program.file(output)))
    return found


def cut_away(lattice):
    """Returns the cells without the upper front right eighth, as seen by LOOK."""
    low, high = lattice.points.min(axis=0), lattice.points.max(axis=0)
    right, front, top = (low + high) / 2
    kept = []
    for faces in lattice.cells:
        x, y, z = lattice.points[sorted({v for face in faces for v in face})].mean(axis=0)
        if not (x > right and y < front and z > top):
            kept.append(faces)
    return kept


def draw_cut(lattice, line):
    """Draws the outside of the lattice after an eighth is removed, in the colours of the strata."""
    shown = boundary_of(cut_away(lattice))
    drawing = Drawing().add_faces(lattice.points, shown, (0.98, 0.97, 0.95))
    visible = edges_of(shown)
    for stratum, colour in enumerate(STRATA):
        edges = [edge for edge in lattice.edges[lattice.edge_strata == stratum]
                 if tuple(edge) in visible]
        drawing.add_edges(lattice.points, edges, colour, line * (1.7 if stratum == 1 else 1))
    corners = [v for v in {v for face in shown for v in face} if lattice.point_strata[v] == 0]
    return drawing.add_points(lattice.points[corners], STRATA[0], 4.2 * line)


def draw_strata(program):
    rows = []
    for name, base, line in bases(program):
        style = LatticeStyle(tube=1.3 * line, ball=3.4 * line, colours=STRATA)
        drawings = [Drawing().add_lattice(base, style)]
        drawings += [draw_cut(level, line) for level in levels_of(program, name, (1, 2))]
        captions = [f"{name.capitalize()} lattice", "Level 1, an eighth taken out",
                    "Level 2, an eighth taken out"]
        rows.append(panels(drawings, captions, LOOK, gap=40, width=330))
    return column([*rows, legend(LEGEND, rows[0].shape[1])], gap=8)


def draw_open(program):
    rows = []
    for name, base, line in bases(program):
        drawings = [Drawing().add_lattice(base, LatticeStyle(
            tube=1.3 * line, ball=3.4 * line, colours=(DARK,) * 4))]
        for level, lattice in enumerate(levels_of(program, name, (1, 2, 3), "--boundary open ")):
            drawing = Drawing().add_edges(base.points, base.edges[base.edge_strata < 3], GHOST,
                                          0.6 * line)
            drawing.add_faces(lattice.points, lattice.boundary, PALE_SKY)
            outer = sorted(edges_of(lattice.boundary))
            drawings.append(drawing.add_edges(lattice.points, outer, BLUE,
                                              line * (1, 0.8, 0.55)[level]))
        captions = [f"{name.capitalize()} lattice", "Level 1", "Level 2", "Level 3"]
        rows.append(panels(drawings, captions, FLAT_LOOK, gap=30, width=330))
    entries = [(GHOST, "boundary of the lattice", "line"),
               (PALE_SKY, "what is left without boundary control", "area"),
               (BLUE, "edges of its cells", "line")]
    return column([*rows, legend(entries, rows[0].shape[1])], gap=8)


FIGURES = [
    Figure(
        "strata", "Lattices and their strata",
        "MacCracken & Joy 1996, Figure 5",
        "A box and a cylinder, and their first two levels. Colours are the paper's: corners "
        "yellow, sharp edges red, other boundary edges green, inner edges blue. An eighth of the "
        "cells is left out of the refined lattices to show the inside. The box keeps its shape. "
        "The cylinder becomes round along its length and stays flat at its ends.",
        draw_strata),
    Figure(
        "open", "Without boundary control",
        "MacCracken & Joy 1996, Figures 1 and 4",
        "The same two lattices, refined as if all cells were inside (`--boundary open`). Each "
        "level loses the outermost layer of the level before, and the region shrinks away from "
        "the lattice. Therefore boundary control is the default.",
        draw_open),
]
