# SPDX-License-Identifier: Apache-2.0
"""Naive surface nets: a smoothed quad mesh of the zero set of a distance field."""

import numpy as np

from quad_mesh import area_vectors

CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]


def sample(field, low, high, spacing, block=4):
    """Samples `field` on a grid: exact near its zero set, with the correct sign elsewhere.

    Whole blocks of the grid that are clearly far from the surface are filled with one value.
    """
    blocks = np.ceil((high - low) / (spacing * block)).astype(int)
    values = np.empty(blocks * block, np.float32)
    index = np.stack(np.meshgrid(*[np.arange(n) for n in blocks], indexing="ij"), -1).reshape(-1, 3)
    middle = low + (index * block + (block - 1) / 2) * spacing
    reach = spacing * block
    coarse = field(middle, 2 * reach)
    # The first three axes count blocks, the others points within a block.
    tiles = values.reshape(blocks[0], block, blocks[1], block, blocks[2], block)
    tiles = tiles.transpose(0, 2, 4, 1, 3, 5)
    tiles[...] = coarse.reshape(*blocks, 1, 1, 1)
    near = index[np.abs(coarse) < 1.3 * reach]
    within = np.stack(np.meshgrid(*[np.arange(block)] * 3, indexing="ij"), -1).reshape(-1, 3)
    points = low + (near[:, None] * block + within) * spacing
    fine = field(points.reshape(-1, 3), 2 * reach)
    tiles[near[:, 0], near[:, 1], near[:, 2]] = fine.reshape(-1, block, block, block)
    return values


def remove_ambiguity(values):
    """Flips the sign of the smallest value at each face of the grid, or diagonal of a cell, where
    the topology of the surface is ambiguous; the net is then a manifold.

    Such values are far below the spacing, and the vertices return to the surface afterwards.
    """
    while True:
        corners = ambiguous_corners(values < 0)
        if not len(corners):
            return values
        smallest = np.abs(values[tuple(corners.transpose(2, 0, 1))]).argmin(axis=1)
        flipped = np.unique(corners[np.arange(len(corners)), smallest], axis=0)
        values[tuple(flipped.T)] *= -1


def ambiguous_corners(inside):
    """Returns grid points (n × 4 × 3): of faces whose opposite corners agree while neighbouring ones
    differ, and of cells (a diagonal, twice) where two opposite corners differ from all others."""
    found = []
    unit = np.eye(3, dtype=int)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        loop = np.array([0 * unit[a], unit[a], unit[a] + unit[b], unit[b]])
        v = [corner_view(inside, corner, loop.max(axis=0)) for corner in loop]
        where = np.argwhere((v[0] == v[2]) & (v[1] == v[3]) & (v[0] != v[1]))
        found.append(where[:, None] + loop)
    count = sum(corner_view(inside, c, (1, 1, 1)).astype(np.int8) for c in CORNERS)
    for start in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)):
        ends = np.array([start, 1 - np.array(start)] * 2)
        both = sum(corner_view(inside, c, (1, 1, 1)).astype(np.int8) for c in ends[:2])
        where = np.argwhere(((count == 2) & (both == 2)) | ((count == 6) & (both == 0)))
        found.append(where[:, None] + ends)
    return np.concatenate(found)


def corner_view(grid, corner, reach):
    """Returns the values at one corner of every cell, for cells of size `reach` on each axis."""
    return grid[tuple(slice(c, n - r + c) for c, r, n in zip(corner, reach, grid.shape))]


def polygonise(values, low, spacing):
    """Vertices (n × 3) and quads (m × 4, anticlockwise from outside) of a grid's zero set."""
    inside = values < 0
    shape = np.array(values.shape) - 1
    count = sum(corner_view(inside, c, (1, 1, 1)).astype(np.int8) for c in CORNERS)
    active = (count > 0) & (count < 8)
    cells = np.argwhere(active)
    number = np.full(shape, -1, np.int64)
    number[active] = np.arange(len(cells))

    total, crossings = np.zeros((len(cells), 3)), np.zeros(len(cells))
    at_corner = {c: values[tuple((cells + c).T)].astype(float) for c in CORNERS}
    for start in CORNERS:
        for axis in range(3):
            if start[axis]:
                continue
            end = tuple(1 if a == axis else s for a, s in enumerate(start))
            a, b = at_corner[start], at_corner[end]
            crossed = (a < 0) != (b < 0)
            t = a[crossed] / (a[crossed] - b[crossed])
            position = cells[crossed] + np.asarray(start, float)
            position[:, axis] += t
            total[crossed] += position
            crossings[crossed] += 1
    points = low + total / crossings[:, None] * spacing

    quads = []
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        ahead = np.roll(inside, -1, axis)
        edges = np.argwhere(inside != ahead)
        edges = edges[(edges < shape).all(axis=1) & (edges[:, b] > 0) & (edges[:, c] > 0)]
        loop = []
        for step_b, step_c in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = edges.copy()
            cell[:, b] -= step_b
            cell[:, c] -= step_c
            loop.append(number[tuple(cell.T)])
        loop = np.stack(loop, axis=1)
        leaving = inside[tuple(edges.T)]
        quads.append(np.where(leaving[:, None], loop, loop[:, ::-1]))
    return points, np.concatenate(quads)


def vertex_normals(points, quads):
    """Unit normals, the diagonals' cross products averaged over the quads of a vertex."""
    total = scatter_mean(quads, area_vectors(points, quads), len(points))
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def scatter_mean(quads, face_values, vertex_count):
    """Returns the mean at each vertex of the values (one row per quad) of the quads around it."""
    owners = quads.ravel()
    valence = np.maximum(np.bincount(owners, minlength=vertex_count), 1)
    return np.stack([np.bincount(owners, np.repeat(column, 4), vertex_count) / valence
                     for column in face_values.T], axis=1)


def even_out(points, quads, solid, rounds):
    """Moves vertices along the surface towards the centres of their quads, and onto the surface.

    The mesh's own normals suffice here, at a fifth of the cost of the gradient.
    """
    for _ in range(rounds):
        normal = vertex_normals(points, quads)
        pull = scatter_mean(quads, points[quads].mean(axis=1), len(points)) - points
        pull -= normal * (pull * normal).sum(axis=1, keepdims=True)
        points = points + 0.8 * pull
        points = points - normal * np.clip(solid.distance(points), -0.003, 0.003)[:, None]
    return points


def project(points, solid, steps):
    """Newton steps along the gradient onto the zero set of the solid's distance."""
    for _ in range(steps):
        gradient = solid.gradient(points)
        squared = np.maximum((gradient**2).sum(axis=1), 1e-3)
        points = points - gradient * (solid.distance(points) / squared)[:, None]
    return points
