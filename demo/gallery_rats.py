# SPDX-License-Identifier: Apache-2.0
"""RATS splines beside Catmull-Clark: Savva & Clapworthy."""

from dataclasses import replace

import numpy as np

from gallery_parts import (AMBER, BLUE, DARK, GREEN, PALE_SKY, RED, Figure, Look, Mesh, extent,
                           panels, render)
from gallery_patch import grid, sides
from geometry_files import edges_of
from images import blank, column, disc, legend, put_ink, put_text, row, text_mask
from picture import GHOST, Drawing

HEIGHTS = ((0.1, 0.2, 0.1, -0.1, 0.1, 0.4), (0.1, 0.5, 0.8, 0.6, 0.3, 0.4),
           (-0.1, 0.7, 1.4, 1.1, 0.4, 0.1), (0.0, 0.4, 0.9, 0.7, 0.1, -0.1),
           (0.4, 0.2, 0.1, 0.0, -0.1, 0.2))
LOOK = Look((0.42, -1, 1.3), height=300, occlusion=False, margin=0.05)
CATMULL_CLARK = "--boundary open "
RATS = "--rules rats "


def net_in(program):
    return program.write(grid(6, 5, lambda x, y: HEIGHTS[y][x]), "net.obj")


def refined(program, name, options, level):
    tag = "rats" if options == RATS else "catmull-clark"
    output = f"{name}-{tag}-{level}.obj"
    program.run(f"refine {name}.obj {options}-n {level} -o {output}")
    return Mesh.read(program.file(output))


def draw_points(program):
    net = net_in(program)
    line = 0.0030 * extent(net.points, LOOK)
    old = Drawing().add_edges(net.points, net.edges, DARK, line)
    drawings = [old.add_points(net.points, DARK, 3.6 * line)]
    captions = ["The old points: {} × {}".format(*sides(net))]
    for options, title, fewer in ((RATS, "RATS", 1), (CATMULL_CLARK, "Catmull-Clark", 3)):
        mesh = refined(program, "net", options, 1)
        assert sides(mesh) == tuple(2 * n - fewer for n in sides(net))  # as the caption says
        captions.append("{}: {} × {} new points".format(title, *sides(mesh)))
        drawing = Drawing().add_edges(net.points, net.edges, GHOST, 0.8 * line)
        drawing.add_edges(mesh.points, mesh.edges, BLUE, 0.7 * line)
        drawings.append(drawing.add_points(mesh.points, BLUE, 3.4 * line))
    picture = panels(drawings, captions, LOOK, gap=30)
    entries = [(DARK, "old point", "point"), (DARK, "old net", "line"),
               (GHOST, "old net, behind the new one", "line"), (BLUE, "new point", "point"),
               (BLUE, "new net", "line")]
    return column([picture, legend(entries, picture.shape[1])], gap=4)


def draw_surfaces(program):
    net = net_in(program)
    line = 0.0030 * extent(net.points, LOOK)
    level = 3
    drawings = []
    for options in (RATS, CATMULL_CLARK):
        mesh = refined(program, "net", options, level)
        drawing = Drawing().add_edges(net.points, net.edges, GHOST, 0.8 * line)
        at_border = border_faces(net) if options == RATS else set()
        # The children of a four-sided face are consecutive.
        for part, colour in ((True, AMBER), (False, PALE_SKY)):
            faces = [f for i, f in enumerate(mesh.loops) if (i // 4**level in at_border) == part]
            if faces:
                drawing.add_faces(mesh.points, faces, colour)
        drawings.append(drawing.add_edges(mesh.points, mesh.edges, DARK, 0.42 * line))
    picture = panels(drawings, ["RATS", "Catmull-Clark, without boundary control"],
                     replace(LOOK, height=380), gap=60)
    entries = [(PALE_SKY, "inner patches", "area"), (AMBER, "patches at the border", "area"),
               (DARK, f"edges at level {level}", "line"),
               (GHOST, "the net of the old points", "line")]
    return column([picture, legend(entries, picture.shape[1])], gap=4)


def border_edges(mesh):
    count = {}
    for loop in mesh.loops:
        for edge in edges_of([loop]):
            count[edge] = count.get(edge, 0) + 1
    return {edge for edge, faces in count.items() if faces == 1}


def border_faces(mesh):
    """The faces with a vertex on the border."""
    border = {v for edge in border_edges(mesh) for v in edge}
    return {i for i, loop in enumerate(mesh.loops) if border & set(loop)}


TYPES = (
    ("V alpha", "a corner", (0.60, 0.16, 0.02)), ("V beta", "a vertex on the border", RED),
    ("V gamma", "a vertex inside", (0.97, 0.66, 0.40)),
    ("E alpha", "a border edge at a corner", (0.00, 0.29, 0.20)),
    ("E beta", "another border edge", GREEN),
    ("E gamma", "an inner edge with an end on the border", (0.42, 0.80, 0.66)),
    ("E delta", "another inner edge", (0.74, 0.91, 0.84)),
    ("F alpha", "a face at a corner", (0.00, 0.20, 0.42)),
    ("F beta", "another face with a border edge", (0.10, 0.50, 0.78)),
    ("F gamma", "an inner face", (0.66, 0.83, 0.95)),
)


def rats_types(net, fine):
    """Returns the type, 0 to 9, of each point of `fine`, the first refinement of a rectangular net.

    Vertex points come first, then edge points, then face points, in the order of their parents. The
    parent of an edge point is found from the vertex points next to it."""
    on_border = border_edges(net)
    border = {v for edge in on_border for v in edge}
    faces_of = {}
    for loop in net.loops:
        for v in loop:
            faces_of[v] = faces_of.get(v, 0) + 1
    corners = {v for v, count in faces_of.items() if count == 1}
    old, first_face = len(net.points), len(fine.points) - len(net.loops)
    ends = {}
    for a, b in fine.edges:
        if a < old <= b < first_face:
            ends.setdefault(b, []).append(a)
    types = [0 if v in corners else 1 if v in border else 2 for v in range(old)]
    for edge in range(old, first_face):
        a, b = sorted(ends[edge])
        if (a, b) in on_border:
            types.append(3 if {a, b} & corners else 4)
        else:
            types.append(5 if {a, b} & border else 6)
    for loop in net.loops:
        types.append(7 if set(loop) & corners else 8 if edges_of([loop]) & on_border else 9)
    return types


def draw_types(program):
    net = program.write(grid(5, 5, lambda x, y: 0), "flat.obj")
    fine = refined(program, "flat", RATS, 1)
    program.numbers.update(old="{} × {}".format(*sides(net)), new=len(fine.points))
    look = Look((0, 0, 1), up=(0, 1, 0), height=520, occlusion=False, margin=0.07)
    line = 0.0022 * extent(net.points, look)
    drawing = Drawing().add_edges(net.points, net.edges, GHOST, line)
    (image,), studio = render([drawing], look)
    for point in studio.pixels_of(net.points):
        put_ink(image, cross(13), round(point[0]) - 13, round(point[1]) - 13, (0.45, 0.46, 0.50))
    # In a flat net a new point may coincide with an old one; its cross is still visible.
    for point, kind in zip(studio.pixels_of(fine.points), rats_types(net, fine)):
        put_number(image, *point, kind)
    words = blank(560, image.shape[0])
    for kind, (name, meaning, _) in enumerate(TYPES):
        # More space between vertex points, edge points and face points.
        y = 42 + 44 * kind + 22 * (kind > 2) + 22 * (kind > 6)
        put_number(words, 20, y, kind)
        put_text(words, name, 46, y, 18, anchor=(0, 0.5), bold=True)
        put_text(words, f"of {meaning}", 150, y, 18, anchor=(0, 0.5))
    return row([image, words], gap=30)


def put_number(image, x, y, kind):
    """Draws a disc in the colour of a type, with the type's number in the paper's list."""
    colour = TYPES[kind][2]
    spot, mask = disc(12), text_mask(str(kind + 1), 15, bold=True)
    x, y = round(x), round(y)
    put_ink(image, spot, x - spot.shape[1] // 2, y - spot.shape[0] // 2, colour)
    # Dark digits on light colours, by the weights of red, green and blue in brightness.
    ink = (1, 1, 1) if np.dot(colour, (0.3, 0.59, 0.11)) < 0.55 else DARK
    put_ink(image, mask, x - round(mask.shape[1] / 2), y - round(mask.shape[0] / 2), ink)


def cross(reach):
    """A mask of an X."""
    y, x = np.mgrid[-reach:reach + 1, -reach:reach + 1]
    return np.clip(1.9 - np.minimum(abs(x - y), abs(x + y)) / 2**0.5, 0, 1)


def pentagonal():
    """Returns a saddle: five sides around a pentagon, three faces deep, alternately up and down."""
    points, faces = [], [list(range(5))]
    for ring, radius in enumerate((0.45, 1.0, 1.6, 2.3)):
        for side in range(10 if ring > 1 else 5):
            sides = 10 if ring > 1 else 5
            angle = 2 * np.pi * side / sides
            lift = 0.16 * radius**2 * np.cos(2 * angle)
            points.append((radius * np.cos(angle), radius * np.sin(angle), lift))
    for side in range(5):
        after = (side + 1) % 5
        faces.append([side, 5 + side, 5 + after, after])
        # Where ten points follow five, one edge of each face is split: the face is a pentagon.
        faces.append([5 + side, 10 + 2 * side, 10 + 2 * side + 1, 10 + 2 * after, 5 + after])
    for side in range(10):
        after = (side + 1) % 10
        faces.append([10 + side, 20 + side, 20 + after, 10 + after])
    return Mesh(np.array(points), faces)


def tripod():
    """Returns a cube with square tubes, open at the ends, on three of its faces."""
    number, points, faces = {}, [], []

    def vertex(place):
        if place not in number:
            number[place] = len(points)
            points.append(place)
        return number[place]

    def face(origin, u, v):
        corners = [np.add(origin, s * np.array(u) + t * np.array(v))
                   for s, t in ((0, 0), (1, 0), (1, 1), (0, 1))]
        faces.append([vertex(tuple(c.tolist())) for c in corners])

    axes = np.eye(3, dtype=int)
    for i in range(3):
        u, v, w = axes[i], axes[(i + 1) % 3], axes[(i + 2) % 3]
        face((0, 0, 0), v, u)  # the face of the cube without a tube
        for step in (1, 2):
            start = step * w
            face(start, u, w)
            face(start + u, v, w)
            face(start + u + v, -u, w)
            face(start + v, -v, w)
    return Mesh(np.array(points, float), faces)


def draw_arbitrary(program):
    pictures = []
    for name, title, make, direction in (
            ("saddle", "Pentagons and quadrilaterals", pentagonal, (0.3, -1, 0.85)),
            ("tripod", "Three tubes from a cube", tripod, (1, 0.62, 0.72))):
        control = program.write(make(), f"{name}.obj")
        coarse = refined(program, name, RATS, 2)
        mesh = refined(program, name, RATS, 3)
        look = Look(direction, height=330, margin=0.06)
        line = 0.0032 * extent(control.points, look)
        first = Drawing().add_edges(control.points, control.edges, DARK, line)
        first.add_points(control.points, DARK, 3 * line)
        # Omits the points of types E delta and F gamma, which are means of others, as section 3
        # advises: draws the edges of level 2, at the positions of their points on level 3.
        wires = mesh.points[:len(coarse.points)]
        second = Drawing().add_faces(mesh.points, mesh.loops, PALE_SKY)
        second.add_edges(wires, coarse.edges, BLUE, 0.6 * line)
        pictures.append(panels([first, second], [title, "Its RATS surface"], look, gap=20))
    picture = row(pictures, gap=30)
    entries = [(DARK, "mesh", "line"), (PALE_SKY, "RATS surface", "area"),
               (BLUE, "its edges, without the points of types E delta and F gamma", "line")]
    return column([picture, legend(entries, picture.shape[1])], gap=4)


FIGURES = [
    Figure(
        "rats-points", "Old points and new points", "Savva & Clapworthy, Figures 1 to 3",
        "One step of RATS and one of Catmull-Clark without boundary control, on the same net of "
        "n × m points. RATS makes (2n − 1)(2m − 1) new points, keeps the corners and reaches the "
        "border. Catmull-Clark makes (2n − 3)(2m − 3).",
        draw_points),
    Figure(
        "rats-types", "The ten types of RATS points", "Savva & Clapworthy, Figure 6",
        "A flat net of {old} old points (crosses) and its {new} new ones, numbered as in the "
        "paper's list: V<sub>α</sub> V<sub>β</sub> V<sub>γ</sub>, E<sub>α</sub> E<sub>β</sub> "
        "E<sub>γ</sub> E<sub>δ</sub>, F<sub>α</sub> F<sub>β</sub> F<sub>γ</sub>.",
        draw_types),
    Figure(
        "rats-surfaces", "A RATS surface and a Catmull-Clark surface",
        "Savva & Clapworthy, Figures 4 and 5",
        "Both surfaces of the first net, at level 3. RATS also has patches at the border "
        "(orange), where Catmull-Clark has none. Away from the border the RATS surface is a "
        "Catmull-Clark surface too: the surface of the V<sub>γ</sub> points of its first step. "
        "It is flatter than the Catmull-Clark surface of the old points, although the paper's "
        "conclusion can be read as if both were the same.",
        draw_surfaces),
    Figure(
        "rats-arbitrary", "RATS on meshes of arbitrary topology", "Savva & Clapworthy, Figure 7",
        "Two meshes with borders, and their RATS surfaces at level 3. The lines leave out the "
        "E<sub>δ</sub> and F<sub>γ</sub> points of the last step, which are means of other "
        "points. The paper recommends this for wireframes.",
        draw_arbitrary),
]
