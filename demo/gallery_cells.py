# SPDX-License-Identifier: Apache-2.0
"""Single cells of refined lattices: Figures 2, 3 and 6 of MacCracken & Joy 1996."""

from dataclasses import replace

import numpy as np

from gallery_parts import (AMBER, BLUE, DARK, GREEN, PALE_ORANGE, RED, STONE, Figure, Look, extent,
                           panels)
from geometry_files import LatticeFile, edges_of
from images import column, legend
from picture import GHOST, Drawing, View


def vertices_of(faces):
    return sorted({v for face in faces for v in face})


def valences(faces):
    """Returns the number of edges of a cell that meet in each of its vertices."""
    count = {}
    for edge in edges_of(faces):
        for v in edge:
            count[v] = count.get(v, 0) + 1
    return count


def is_type(faces, n):
    """True for a type-n cell: it has 2n faces, all with four sides (section 2.2)."""
    return len(faces) == 2 * n and all(len(face) == 4 for face in faces)


def look_along(axis, height, points, tilt, turned=0.0):
    """Returns a view from the side of an axis that points up, slightly from above: the view in which
    the points are farthest apart from each other, or one that is turned from it."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    side = np.cross(axis, (0, 0, 1) if abs(axis[2]) < 0.9 else (0, 1, 0))
    side /= np.linalg.norm(side)

    def direction(turn):
        return np.cos(turn) * side + np.sin(turn) * np.cross(axis, side) + tilt * axis

    def clearance(turn):
        flat = points @ View.axes(direction(turn), axis)[:2].T
        gaps = np.linalg.norm(flat[:, None] - flat, axis=2)
        return gaps[np.triu_indices(len(points), 1)].min()

    best = max(np.linspace(0, 2 * np.pi, 361), key=clearance)
    return Look(tuple(direction(best + turned)), tuple(axis), height, occlusion=False, margin=0.08)


def draw_types(program):
    solids, cells = [], []
    for n, solid in ((3, "tetrahedron"), (4, "octahedron"), (5, "icosahedron")):
        program.run(f"shape {solid} -o {solid}.vtu")
        program.run(f"refine {solid}.vtu -n 1 -o {solid}-1.vtu")
        base = LatticeFile(program.file(f"{solid}.vtu"))
        lattice = LatticeFile(program.file(f"{solid}-1.vtu"))
        # Vertex points come first, so the cell of vertex 0 contains vertex 0.
        cell = next(faces for faces in lattice.cells if 0 in vertices_of(faces))
        assert is_type(cell, n)
        own = lattice.points[vertices_of(cell)]
        look = look_along(base.points[0] - base.points.mean(axis=0), 250, own, tilt=0.5)
        line = 0.0034 * extent(base.points, look)
        whole = Drawing().add_edges(base.points, base.edges, GHOST, line)
        solids.append(panels([add_cell(whole, lattice.points, cell, n, line)],
                             [f"{solid.capitalize()}, refined once"], look, width=330))
        look = replace(look, height=270)
        line = 0.0045 * extent(own, look)
        cells.append(panels([add_cell(Drawing(), lattice.points, cell, n, line)],
                            [f"Type-{n} cell"], look, points=[own], width=330))
    rows = [np.concatenate(images, axis=1) for images in (solids, cells)]
    entries = [(RED, "the two vertices of valence n", "point"),
               (BLUE, "the 2n vertices of valence 3", "point"),
               (PALE_ORANGE, "the cell", "area"), (GHOST, "the solid", "line")]
    return column([*rows, legend(entries, rows[0].shape[1])], gap=6)


def add_cell(drawing, points, cell, n, line):
    drawing.add_faces(points, cell, PALE_ORANGE, 0.45)
    drawing.add_edges(points, sorted(edges_of(cell)), DARK, line)
    ends = {v for v, valence in valences(cell).items() if valence == n}
    if n == 3:
        # All eight have valence 3. The two required ones are the vertex and the cell point.
        ends = {min(ends), max(ends)}
    rest = [v for v in vertices_of(cell) if v not in ends]
    assert (len(ends), len(rest)) == (2, 2 * n)  # as the caption and the legend say
    drawing.add_points(points[rest], BLUE, 3.2 * line)
    return drawing.add_points(points[sorted(ends)], RED, 4.4 * line)


def draw_repeated(program):
    look = Look((0.45, -1, 0.38), height=300, occlusion=False)
    program.run("shape octahedron -o octahedron.vtu")
    base = LatticeFile(program.file("octahedron.vtu"))
    line = 0.0030 * extent(base.points, look)
    drawings, captions = [], []
    for level in (1, 2, 3, 4):
        program.run(f"refine octahedron.vtu -n {level} -o octahedron-{level}.vtu")
        lattice = LatticeFile(program.file(f"octahedron-{level}.vtu"))
        special = [faces for faces in lattice.cells if is_type(faces, 4)]
        drawing = Drawing().add_faces(lattice.points, [f for cell in special for f in cell], AMBER)
        if len(special) < len(lattice.cells):
            drawing.add_edges(base.points, base.edges, GHOST, line)
        edges = sorted(edges_of([f for cell in special for f in cell]))
        drawing.add_edges(lattice.points, edges, DARK, line * (1, 0.9, 0.7, 0.5)[level - 1])
        drawings.append(drawing)
        assert len(special) == 6 * 2**(level - 1)  # each has two children of its type, as the caption says
        captions.append(f"Level {level}: {len(special)} of {len(lattice.cells):,} cells")
    picture = panels(drawings, captions, look, gap=40)
    entries = [(AMBER, "cells of type 4", "area"), (GHOST, "the lattice", "line")]
    return column([picture, legend(entries, picture.shape[1])], gap=4)


def tetrahedra_of(faces):
    """Returns the bases of the 4n tetrahedra of a type-n cell (embed/cell_place.h). Each face is cut
    from its first to its third vertex. The loop of a face starts at the child of lowest dimension,
    a vertex point or an edge point, which has the smallest number; a file may rotate the loop."""
    bases = []
    for face in faces:
        at = face.index(min(face))
        a, b, c, d = face[at:] + face[:at]
        bases += [(a, b, c), (a, c, d)]
    return bases


def draw_partition(program):
    program.run("shape octahedron -o octahedron.vtu")
    program.run("refine octahedron.vtu -n 1 -o octahedron-1.vtu")
    lattice = LatticeFile(program.file("octahedron-1.vtu"))
    top = int(lattice.points[:6, 2].argmax())
    cell = next(faces for faces in lattice.cells if top in vertices_of(faces))
    points, own = lattice.points, sorted(edges_of(cell))
    bases = tetrahedra_of(cell)
    seen = points[vertices_of(cell)]
    middle, apex = seen.mean(axis=0), len(points)
    joined = np.concatenate([points, [middle]])
    new = sorted({(v, apex) for v in vertices_of(cell)} | (edges_of(map(list, bases)) - set(own)))
    look = look_along((0, 0, 1), 340, seen, tilt=0.7, turned=0.22)
    line = 0.0034 * extent(seen, look)
    plain = Drawing().add_faces(points, cell, STONE, 0.5).add_edges(points, own, GREEN, 1.3 * line)
    plain.add_points(seen, GREEN, 2.2 * line)
    cut = Drawing().add_faces(points, cell, STONE, 0.3)
    cut.add_edges(joined, own, GREEN, 1.3 * line).add_edges(joined, new, BLUE, line)
    cut.add_points([middle], BLUE, 5 * line)
    apart = Drawing()
    for base in bases:
        # Thicker, since the picture of the separated parts is scaled down.
        add_apart(apart, joined, (*base, apex), set(own), 1.5 * line)
    shown = ((plain, "A type-4 cell", [seen]), (cut, f"Cut into {len(bases)} tetrahedra", [seen]),
             (apart, f"The {len(bases)} taken apart", apart.points))
    picture = np.concatenate([panels([drawing], [caption], look, points=window)
                              for drawing, caption, window in shown], axis=1)
    entries = [(GREEN, "edges of the cell", "line"), (BLUE, "edges of the partition", "line"),
               (BLUE, "average of the vertices", "point"), (STONE, "faces", "area")]
    return column([picture, legend(entries, picture.shape[1])], gap=4)


def add_apart(drawing, points, corners, own, line, apart=1.5):
    """Adds a tetrahedron, moved away from the others."""
    a, b, c, apex = corners
    own_points = points[list(corners)]
    moved = own_points + apart * (own_points.mean(axis=0) - points[apex])
    drawing.add_faces(moved, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], STONE)
    for i, j in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)):
        pair = (min(corners[i], corners[j]), max(corners[i], corners[j]))
        drawing.add_edges(moved, [(i, j)], GREEN if pair in own else BLUE, line)


FIGURES = [
    Figure(
        "cell-types", "Type-3, type-4 and type-5 cells", "MacCracken & Joy 1996, Figure 2",
        "A vertex where n edges of a cell meet becomes a type-n cell in the next level. It has "
        "2n four-sided faces, two vertices of valence n (red: the old vertex and the new cell "
        "point) and 2n vertices of valence 3 (blue). Above: in the refined solid. Below: the "
        "cell alone. The paper prints 2n − 2 for the blue vertices, which is a misprint.",
        draw_types),
    Figure(
        "type-4", "Type-4 cells, level by level", "MacCracken & Joy 1996, Figure 3",
        "An octahedron refined four times. Each type-4 cell leaves two of its kind, along the "
        "lines from the middle to the six corners. So their number doubles with each level, "
        "while the number of all cells grows eightfold: soon nearly all are hexahedra.",
        draw_repeated),
    Figure(
        "partition", "A type-4 cell as tetrahedra", "MacCracken & Joy 1996, Figure 6",
        "To place a point in a type-n cell, the cell is cut into 4n tetrahedra around the "
        "average of its vertices, two for each face. Edges of the cell are green and edges of "
        "the tetrahedra blue, as in the paper. Each face is cut from its vertex or edge point to "
        "its face or cell point, so that the two cells at a face cut it in the same way.",
        draw_partition),
]
