# SPDX-License-Identifier: Apache-2.0
"""The demo's disk and block, quad meshes with patterns that make the deformation visible."""

import numpy as np

import scenes
from quad_mesh import QuadMesh

SECTORS = 160


def weld(patches):
    """Returns one mesh of several grids of points (rows × columns × 3, each with an array of the
    material names of its quads). Points that coincide become one vertex."""
    points, quads, material, start = [], [], [], 0
    for grid, names in patches:
        rows, columns = grid.shape[:2]
        number = start + np.arange(rows * columns).reshape(rows, columns)
        loops = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]],
                         axis=-1)
        points.append(grid.reshape(-1, 3))
        quads.append(loops.reshape(-1, 4))
        material.append(names.ravel())
        start += rows * columns
    points = np.concatenate(points)
    _, first, number = np.unique(np.round(points, 7), axis=0, return_index=True,
                                 return_inverse=True)
    # Vertices keep the order in which they first appear.
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return QuadMesh(points[first[order]], rank[number][np.concatenate(quads)],
                    np.concatenate(material))


def disk_profile():
    """Returns radius and height along half the disk's section, from the middle patch of the top to
    the middle of the rim, and the number of rows on the flat part."""
    half, fillet = scenes.DISK_HEIGHT / 2, 0.75 * scenes.DISK_HEIGHT / 2
    flat = np.linspace(0.2, scenes.DISK_RADIUS - fillet, 36)
    angle = np.linspace(0, np.pi / 2, 13)[1:]
    upright = np.linspace(half - fillet, 0, 4)[1:]
    radius = np.concatenate([flat, scenes.DISK_RADIUS - fillet + fillet * np.sin(angle),
                             np.full(3, scenes.DISK_RADIUS)])
    height = np.concatenate([np.full(36, half), half - fillet + fillet * np.cos(angle), upright])
    return radius, height


def disk_middle(radius):
    """Returns a grid of points in the plane (rows × columns × 2) whose border is a circle with equal
    angles, and whose quads near the middle are nearly squares."""
    side = np.linspace(-1, 1, SECTORS // 4 + 1)
    x, y = np.meshgrid(side, side, indexing="ij")
    reach = np.maximum(np.abs(x), np.abs(y))
    # Squares around the middle become circles: equal steps along a side become equal angles.
    safe = np.maximum(reach, 1e-12)
    turn = np.select([x == reach, y == reach, -x == reach],
                     [y / safe, 2 - x / safe, 4 - y / safe], 6 + x / safe) * (np.pi / 4)
    circle = reach[..., None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    square = np.stack([x, y], axis=-1) * 0.8
    share = (reach**2)[..., None]
    return radius * ((1 - share) * square + share * circle)


def make_disk():
    """Returns a thick round disk around the z axis, painted as a dartboard."""
    radius, height = disk_profile()
    radius = np.concatenate([radius, radius[-2::-1]])
    height = np.concatenate([height, -height[-2::-1]])
    angle = np.arange(SECTORS + 1) % SECTORS * (2 * np.pi / SECTORS)
    ring = np.stack([np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle)),
                     np.repeat(height[:, None], SECTORS + 1, axis=1)], axis=-1)
    band = np.searchsorted([0.44, 0.70, 0.93], (radius[:-1] + radius[1:]) / 2)
    odd = (band[:, None] + np.arange(SECTORS)[None, :] // (SECTORS // 20)) % 2
    middle = disk_middle(radius[0])
    top = np.concatenate([middle, np.full((*middle.shape[:2], 1), height[0])], axis=-1)
    paint = np.full((SECTORS // 4, SECTORS // 4), "accent")
    return weld([(ring, np.where(odd == 1, "dark", "light")), (top, paint),
                 (top[:, ::-1] * [1, 1, -1], paint)])


def make_block():
    """Returns a rounded block, painted like a solid checkerboard of cubes."""
    size, fillet, squares, fine = scenes.BLOCK_SIZE, 0.12, 6, 7
    short = squares * fine
    cells = np.round(size / size.min() * short).astype(int)
    patches = []
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            u = np.linspace(-0.5, 0.5, cells[b] + 1) * size[b]
            v = np.linspace(-0.5, 0.5, cells[c] + 1) * size[c]
            grid = np.empty((len(u), len(v), 3))
            grid[..., axis] = sign * size[axis] / 2
            grid[..., b], grid[..., c] = np.meshgrid(u, v, indexing="ij")
            odd = (np.arange(cells[b])[:, None] // fine + np.arange(cells[c])[None, :] // fine
                   + (sign > 0)) % 2
            names = np.where(odd == 1, "dark", "light")
            if sign < 0:
                grid, names = grid[:, ::-1], names[:, ::-1]
            patches.append((round_box(grid, size / 2, fillet), names))
    return weld(patches)


def round_box(points, half, fillet):
    """Moves points of a box's surface onto the box with rounded edges, with equal angles where the
    box is rounded, so that quads have similar sizes."""
    core = np.clip(points, -(half - fillet), half - fillet)
    beyond = np.tan((points - core) / fillet * (np.pi / 4))
    length = np.linalg.norm(beyond, axis=-1, keepdims=True)
    return core + beyond / np.maximum(length, 1e-12) * fillet
