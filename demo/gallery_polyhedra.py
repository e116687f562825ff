# SPDX-License-Identifier: Apache-2.0
"""Polyhedra that become smooth: Table 1 of Zaini Azlan & Misro 2021."""

import itertools

import numpy as np

from gallery_parts import DARK, Figure, Look, Mesh, centred, extent, render
from images import blank, caption_strip, column, put_text, row
from picture import Drawing

LEVELS = (0, 1, 2, 3)
WIDTH = 300
GOLDEN = (1 + 5**0.5) / 2


def cube():
    points = np.array(list(itertools.product((-1, 1), repeat=3)), float)
    return Mesh(points, convex_faces(points))


def pyramid():
    return Mesh([(1, 1, -1), (-1, 1, -1), (-1, -1, -1), (1, -1, -1), (0, 0, 1)],
                [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])


def cyclic(*coordinates):
    """The points with these coordinates in cyclic order, and with all signs."""
    found = {tuple(np.roll(np.multiply(coordinates, signs), shift) + 0.0)
             for signs in itertools.product((-1, 1), repeat=3) for shift in range(3)}
    return sorted(found)


def dodecahedron():
    points = np.array(sorted(itertools.product((-1.0, 1.0), repeat=3)) +
                      cyclic(0, 1 / GOLDEN, GOLDEN))
    return Mesh(points, convex_faces(points))


def rhombic_hexecontahedron():
    """Returns a solid of twenty rhombohedra that meet in the middle, one for each face of an
    icosahedron, spanned by the corners a, b, c of the face. Its surface has the three faces at
    a + b + c of each rhombohedron: sixty golden rhombi."""
    corners = np.array(cyclic(0, 1, GOLDEN))
    number, points, faces = {}, [], []

    def vertex(*parts):
        point = corners[list(parts)].sum(axis=0)
        key = tuple(np.round(point, 6))
        if key not in number:
            number[key] = len(points)
            points.append(point)
        return number[key]

    for a, b, c in convex_faces(corners):
        for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
            faces.append([vertex(p, r), vertex(p), vertex(p, q), vertex(p, q, r)])
    return Mesh(points, faces)


def convex_faces(points):
    """Returns the faces of a convex solid around the origin, anticlockwise from outside: the points
    in each plane that has no point beyond it."""
    faces = {}
    for triple in itertools.combinations(range(len(points)), 3):
        a, b, c = points[list(triple)]
        normal = np.cross(b - a, c - a)
        # Points on a line span no plane. All solids here have a size of about 1.
        if np.linalg.norm(normal) < 1e-6:
            continue
        normal *= np.sign(normal @ a) or 1
        height = points @ normal
        if height.max() > normal @ a + 1e-6:
            continue
        members = np.flatnonzero(height > normal @ a - 1e-6)
        middle = points[members].mean(axis=0)
        right = points[members[0]] - middle
        above = np.cross(normal / np.linalg.norm(normal), right)
        angle = np.arctan2((points[members] - middle) @ above, (points[members] - middle) @ right)
        faces[tuple(members)] = [int(v) for v in members[np.argsort(angle)]]
    return list(faces.values())


SOLIDS = (
    ("cube", "Cube", cube, (0.72, 0.87, 0.95)),
    ("pyramid", "Pyramid", pyramid, (0.97, 0.82, 0.58)),
    ("dodecahedron", "Dodecahedron", dodecahedron, (0.70, 0.88, 0.80)),
    ("hexecontahedron", "Rhombic hexecontahedron", rhombic_hexecontahedron, (0.93, 0.78, 0.87)),
)


#: Table 2: coordinates and faces of each iteration.
TABLE = {
    "cube": ((8, 6), (26, 24), (98, 96), (386, 384)),  # the paper prints 284
    "pyramid": ((5, 5), (18, 16), (66, 64), (258, 256)),
    "dodecahedron": ((20, 12), (62, 60), (242, 240), (962, 960)),
    "hexecontahedron": ((62, 60), (242, 240), (962, 960), (3842, 3840)),
}


def draw_table(program):
    columns = [row_labels()]
    for name, title, make, colour in SOLIDS:
        look = Look((0.55, -1, 0.42), height=230, margin=0.06)
        meshes = [program.write(make(), f"{name}.obj")]
        for level in LEVELS[1:]:
            program.run(f"refine {name}.obj -n {level} -o {name}-{level}.obj")
            meshes.append(Mesh.read(program.file(f"{name}-{level}.obj")))
        assert TABLE[name] == tuple((len(mesh.points), len(mesh.loops)) for mesh in meshes)
        window = extent(meshes[0].points, look)
        drawings = []
        for mesh, line in zip(meshes, (0.0042, 0.0034, 0.0026, 0.0017)):
            drawing = Drawing().add_faces(mesh.points, mesh.loops, colour)
            drawings.append(drawing.add_edges(mesh.points, mesh.edges, DARK, line * window))
        images, _ = render(drawings, look, points=[meshes[0].points])
        parts = [caption_strip(title, WIDTH, 44, 18)]
        for image, mesh in zip(images, meshes):
            parts += [centred(image, WIDTH), caption_strip(
                f"{len(mesh.points):,} vertices, {len(mesh.loops):,} faces", WIDTH, 40, 15)]
        columns.append(column(parts))
    return row(columns, gap=6)


def row_labels():
    label = blank(110, 44 + len(LEVELS) * 270)
    for level in LEVELS:
        put_text(label, f"Iteration {level}", 104, 44 + 270 * level + 115, 16, anchor=(1, 0.5))
    return label


FIGURES = [
    Figure(
        "polyhedra", "Four solids become smooth",
        "Zaini Azlan & Misro 2021, Tables 1 and 2",
        "Four polyhedra, refined three times by Catmull-Clark. The numbers of vertices and faces "
        "are counted in the files that the program wrote. They agree with the paper's Table 2, "
        "except for the cube's third iteration: it has 384 faces (284 is a misprint).",
        draw_table),
]
