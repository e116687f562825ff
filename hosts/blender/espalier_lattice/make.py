# SPDX-License-Identifier: Apache-2.0
"""Makes lattices around objects."""

import bpy
import numpy as np

KINDS = (
    ("BOX", "Box", "A box of cells around the selected objects"),
    ("CAGE", "Cage", "The cells of a box that the selected objects pass through, and the cells around these"),
    ("CYLINDER", "Cylinder", "Cells in sectors and layers, along z"),
    ("TORUS", "Torus", ""),
    ("STAR", "Star", ""),
    ("BARBELL", "Barbell", ""),
    ("ARM", "Arm", ""),
    ("TETRAHEDRON", "Tetrahedron", ""),
    ("CUBE", "Cube", ""),
    ("OCTAHEDRON", "Octahedron", ""),
    ("DODECAHEDRON", "Dodecahedron", ""),
    ("ICOSAHEDRON", "Icosahedron", ""),
    ("PRISM", "Prism", ""),
    ("PYRAMID", "Pyramid", ""),
    ("BIPYRAMID", "Bipyramid", ""),
)


def points_of(objects, depsgraph):
    """Returns the points of mesh objects in the coordinates of the world: array (N, 3)."""
    parts = []
    for object in objects:
        mesh = object.evaluated_get(depsgraph).data
        points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        mesh.vertices.foreach_get("co", points)
        matrix = np.array(object.matrix_world)
        parts.append(points.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])
    return np.concatenate(parts) if parts else np.zeros((0, 3))


def around(espalier, kind, points, cells, margin):
    """Returns a lattice of a kind around points; around a cube of side 2 if there are none.

    cells: number of cells along the longest side of a box or a cage"""
    if len(points) == 0:
        points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    if kind == "BOX":
        return espalier.shapes.around(points, cells=cells, margin=margin)
    if kind == "CAGE":
        return cage(espalier, points, cells, margin)
    ready = getattr(espalier.shapes, kind.lower())()
    return fitted(espalier, ready, points, margin)


def fitted(espalier, lattice, points, margin):
    """Scales a ready lattice to the smallest tried size that has all points inside its second level. If no
    size has, as for points in the hole of a torus, its box has the size of the points."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = (low + high) / 2, np.maximum(high - low, 1e-9 * max(1.0, np.abs(points).max()))
    own_low, own_high = lattice.positions.min(axis=0), lattice.positions.max(axis=0)
    sample = points[:: max(1, len(points) // 2000)]
    sizes = [lattice.with_positions((lattice.positions - (own_low + own_high) / 2) * (
        1.25 ** k * (1 + 2 * margin) * size / (own_high - own_low)) + middle) for k in range(12)]
    for moved in sizes:
        statuses = np.asarray(espalier.bind(moved, sample, 2).statuses)
        if (statuses == int(espalier.PointStatus.INSIDE)).all():
            return moved
    return sizes[0]


def cage(espalier, points, cells, margin):
    """Keeps the cells of a box that hold points, and adds rings of cells around these until all points are
    inside the second level, which is smaller than the cells."""
    box = espalier.shapes.around(points, cells=cells, margin=margin)
    corners = box.positions[box.hexahedra]
    low, high = corners.min(axis=1), corners.max(axis=1)
    size = np.array(sorted(map(tuple, np.unique(np.round(high - low, 12), axis=0))))[0]
    first = low.min(axis=0)
    place = np.round((low - first) / size).astype(int)
    count = place.max(axis=0) + 1
    number = -np.ones(count, dtype=int)
    number[tuple(place.T)] = np.arange(len(place))
    at = np.clip(((points - first) / size).astype(int), 0, count - 1)
    chosen = np.zeros(count, dtype=bool)
    chosen[tuple(at.T)] = True
    sample = points[:: max(1, len(points) // 20000)]
    while True:
        ring = np.zeros_like(chosen)
        padded = np.pad(chosen, 1)
        for x in range(3):
            for y in range(3):
                for z in range(3):
                    ring |= padded[x:x + count[0], y:y + count[1], z:z + count[2]]
        chosen = ring
        kept = number[chosen]
        hexahedra = box.hexahedra[np.sort(kept)]
        used, inverse = np.unique(hexahedra, return_inverse=True)
        lattice = espalier.Lattice(box.positions[used], inverse.reshape(hexahedra.shape))
        statuses = np.asarray(espalier.bind(lattice, sample, 2).statuses)
        if chosen.all() or (statuses == int(espalier.PointStatus.INSIDE)).all():
            return lattice
