# SPDX-License-Identifier: Apache-2.0
"""Uniform cubic B-spline curves by refinement: section 2 of CSE-96-1 (Joy & MacCracken)."""

import numpy as np

from gallery_parts import BLUE, DARK, GREEN, RED, Figure, Look, Mesh, centred, extent, render
from images import blank, caption_strip, column, legend, put_text
from picture import GHOST, Drawing

LOOK = Look((0, 0, 1), up=(0, 1, 0), height=190, occlusion=False, margin=0.07)
POLYGON = ((0.0, 0.3), (0.9, 2.2), (2.2, 2.4), (2.7, 0.2), (4.2, 0.0), (4.9, 1.9))
RING = ((0.6, 0.1), (0.0, 1.5), (1.9, 2.5), (3.2, 1.3), (4.9, 2.1), (4.2, 0.0))
#: Name, title, options, file and points.
CURVES = (
    ("open", "Open", "--boundary open ", "polygon", POLYGON),
    ("ends", "With its ends", "", "polygon", POLYGON),
    ("closed", "Closed", "", "ring", RING),
)
LEVELS = (1, 2, 4)
LABEL, WIDTH = 130, 350  # widths of the columns, in pixels


def steps_of(line):
    """Pairs of neighbours along a line."""
    return list(zip(line, line[1:]))


def draw_curves(program):
    rows = []
    for name, title, options, file, polygon in CURVES:
        line = [*range(len(polygon)), *([0] if file == "ring" else [])]
        base = Mesh(np.array([(x, y, 0) for x, y in polygon]), [line])
        program.write(base, f"{file}.obj", "l")
        meshes = [base]
        for level in LEVELS:
            program.run(f"refine {file}.obj {options}-n {level} -o {name}-{level}.obj")
            meshes.append(Mesh.read(program.file(f"{name}-{level}.obj")))
        rows.append(draw_row(title, base, meshes))
    head = np.concatenate([blank(LABEL, 44)] + [
        caption_strip(words, WIDTH, 44, 17)
        for words in ("Control polygon", "Once", "Twice", "Four times")], axis=1)
    entries = [(DARK, "control point", "point"), (DARK, "polygon of the column", "line"),
               (GHOST, "control polygon behind it", "line"), (RED, "vertex point", "point"),
               (GREEN, "edge point", "point"), (BLUE, "the curve, near enough", "line")]
    return column([head, *rows, legend(entries, head.shape[1])], gap=14)


def draw_row(title, base, meshes):
    line = 0.0042 * extent(base.points, LOOK)
    drawings = []
    for number, mesh in enumerate(meshes):
        steps = steps_of(mesh.loops[0])
        last = number == len(meshes) - 1
        drawing = Drawing()
        if number > 0:
            drawing.add_edges(base.points, steps_of(base.loops[0]), GHOST, line)
        drawing.add_edges(mesh.points, steps, BLUE if last else DARK, line * (1.6 if last else 1.2))
        if number == 0:
            drawing.add_points(mesh.points, DARK, 4.5 * line)
        elif not last:
            add_kinds(drawing, mesh, line * (5, 4)[number - 1])
        drawings.append(drawing)
    images, _ = render(drawings, LOOK, points=[base.points])
    label = blank(LABEL, images[0].shape[0])
    put_text(label, title, LABEL - 14, label.shape[0] / 2, 17, anchor=(1, 0.5))
    return np.concatenate([label, *(centred(image, WIDTH) for image in images)], axis=1)


def add_kinds(drawing, mesh, radius):
    """Marks vertex points and edge points, which alternate along the line. Vertex points have the
    lower numbers."""
    loop = mesh.loops[0][:-1] if mesh.loops[0][0] == mesh.loops[0][-1] else mesh.loops[0]
    even, odd = loop[::2], loop[1::2]
    vertices, edges = (even, odd) if min(even) < min(odd) else (odd, even)
    drawing.add_points(mesh.points[vertices], RED, radius)
    drawing.add_points(mesh.points[edges], GREEN, radius)


FIGURES = [
    Figure(
        "curves", "Curves", "Joy & MacCracken, CSE-96-1, section 2",
        "A control polygon and its refinements in three versions. Open, as in the report: the "
        "first and the last vertex have no vertex point, and the curve shrinks. With its ends kept: "
        "the program's default. Closed: without ends. An edge point is the midpoint of its edge. A "
        "vertex point is half the vertex plus a quarter of each neighbouring edge point.",
        draw_curves),
]
