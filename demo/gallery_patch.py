# SPDX-License-Identifier: Apache-2.0
"""A bicubic patch and its four quarters: Joy's notes on bicubic uniform B-spline refinement."""

from dataclasses import replace

import numpy as np

from gallery_parts import (AMBER, BLUE, DARK, GREEN, PALE_SKY, RED, STONE, Figure, Look, Mesh,
                           extent, render)
from images import captioned, column, legend, put_text, row
from picture import GHOST, Drawing

LOOK = Look((0.4, -1, 1.35), height=400, occlusion=False, margin=0.07)
SMALL = replace(LOOK, height=190, margin=0.05)
HEIGHTS = ((0, 0.3, 0.3, 0.1), (0.3, 1.0, 0.9, 0.4), (0.2, 0.8, 1.1, 0.3), (-0.1, 0.3, 0.2, 0))
KINDS = (("V", "vertex point", RED), ("E", "edge point", GREEN), ("F", "face point", BLUE))


def grid(columns, rows, height):
    """Returns a mesh of columns × rows points, numbered row by row."""
    points = [(x, y, height(x, y)) for y in range(rows) for x in range(columns)]
    first = [y * columns + x for y in range(rows - 1) for x in range(columns - 1)]
    faces = [[v, v + 1, v + columns + 1, v + columns] for v in first]
    return Mesh(np.array(points, float), faces)


def sides(mesh):
    """Returns the number of points along the sides of a rectangular net, the longer side first."""
    # a·b points and (a − 1)(b − 1) faces: a + b is points − faces + 1.
    total, product = len(mesh.points) - len(mesh.loops) + 1, len(mesh.points)
    apart = round((total**2 - 4 * product)**0.5)
    longer, shorter = (total + apart) // 2, (total - apart) // 2
    assert longer * shorter == product
    return longer, shorter


def arranged(mesh):
    """The numbers of the points of a refined square net as rows from −y, each from −x."""
    side = round(len(mesh.points)**0.5)
    rows = np.argsort(mesh.points[:, 1], kind="stable").reshape(side, side)
    return np.array([r[np.argsort(mesh.points[r, 0])] for r in rows])


def draw_patch(program):
    net = program.write(grid(4, 4, lambda x, y: HEIGHTS[y][x]), "net.obj")
    program.run("refine net.obj --boundary open -n 1 -o net-1.obj")
    program.run("refine net.obj --boundary open -n 5 -o net-5.obj")
    fine = Mesh.read(program.file("net-1.obj"))
    surface = Mesh.read(program.file("net-5.obj"))
    line = 0.0030 * extent(net.points, LOOK)
    places = arranged(fine)

    first = Drawing().add_edges(net.points, net.edges, DARK, line)
    first.add_faces(surface.points, surface.loops, PALE_SKY, smooth=True)
    first.add_points(net.points, DARK, 3.2 * line)
    second = Drawing().add_edges(net.points, net.edges, GHOST, 0.8 * line)
    second.add_edges(fine.points, fine.edges, DARK, 0.8 * line)
    kinds = kinds_of(places)
    # As the caption says.
    assert [np.count_nonzero(kinds == kind) for kind in "FEV"] == [9, 12, 4]
    for kind, _, colour in KINDS:
        second.add_points(fine.points[kinds == kind], colour, 5.2 * line)
    (left, right), studio = render([first, second], LOOK, points=[net.points])
    for i, (x, y) in enumerate(studio.pixels_of(net.points)):
        put_text(left, f"P{i // 4},{i % 4}", x + 7, y - 6, 13, anchor=(0, 1), halo=True)
    quarters = draw_quarters(net, fine, places, surface)
    nets = row([captioned(left, "The net of 4 × 4 points, and its patch", 17),
                captioned(right, "The 25 points of its refinement", 17)], gap=24)
    quarters = captioned(quarters, "Four of 4 × 4, a quarter of the patch each", 17)
    # A separate legend: its pale lines are a different net from those in the middle.
    return row([
        with_legends(nets, [[(colour, words, "point") for _, words, colour in KINDS],
                            [(PALE_SKY, "the patch", "area"), (GHOST, "the first net", "line")]]),
        with_legends(quarters, [[(AMBER, "a quarter of the patch", "area"),
                                 (STONE, "the other quarters", "area")],
                                [(DARK, "its 4 × 4 points", "point"),
                                 (GHOST, "the rest of the 25", "line")]])], gap=24)


def with_legends(image, rows):
    return column([image, *(legend(entries, image.shape[1]) for entries in rows)], gap=4)


def kinds_of(places):
    """Returns F, E or V for each point of a refined open net. Rows begin and end with face points."""
    kinds = np.empty(places.size, dtype="U1")
    for row_number, numbers in enumerate(places):
        for column_number, number in enumerate(numbers):
            kinds[number] = "FEV"[row_number % 2 + column_number % 2]
    return kinds


def draw_quarters(net, fine, places, surface):
    """Draws the control points of each quarter of the patch, in four pictures."""
    line = 0.0042 * extent(net.points, SMALL)
    low, high = surface.points[:, :2].min(axis=0), surface.points[:, :2].max(axis=0)
    middle = (low + high) / 2
    drawings = []
    for up, right in ((1, 0), (1, 1), (0, 0), (0, 1)):
        chosen = places[up:up + 4, right:right + 4]
        own = set(chosen.ravel().tolist())
        inner = [e for e in fine.edges if own >= set(e.tolist())]
        outer = [e for e in fine.edges if not own >= set(e.tolist())]
        drawing = Drawing().add_edges(fine.points, outer, GHOST, 0.7 * line)
        drawing.add_edges(fine.points, inner, DARK, line)
        for part, colour in ((True, AMBER), (False, STONE)):
            faces = [f for f in surface.loops
                     if in_quarter(surface.points[f].mean(axis=0), middle, right, up) == part]
            drawing.add_faces(surface.points, faces, colour)
        drawings.append(drawing.add_points(fine.points[chosen.ravel()], DARK, 3 * line))
    images, _ = render(drawings, SMALL, points=[fine.points])
    rows = [row(images[:2], gap=12), row(images[2:], gap=12)]
    gap = LOOK.height - 2 * SMALL.height
    return column(rows, gap=gap)


def in_quarter(point, middle, right, up):
    return bool((point[0] > middle[0]) == bool(right) and (point[1] > middle[1]) == bool(up))


FIGURES = [
    Figure(
        "patch", "A bicubic patch and its quarters",
        "Joy, bicubic uniform B-spline surface refinement",
        "A net of 4 × 4 points defines one patch of a uniform bicubic B-spline. Refined once "
        "without boundary control, it has 25 points: 9 face points, 12 edge points and 4 vertex "
        "points. Each 4 × 4 of these points define a quarter of the patch. All four quarters "
        "share the nine points in the middle.",
        draw_patch),
]
