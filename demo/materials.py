# SPDX-License-Identifier: Apache-2.0
"""Divides a mesh into materials along smooth curves, instead of along the edges of its quads."""

import numpy as np

from quad_mesh import opposites, quad_areas
from surface_nets import even_out, project


def divide(points, quads, solid, fields, spacing):
    """Returns the points, moved along the surface of the solid if they are between two materials,
    and the number of each quad's material.

    fields(points) has one column per material; a point has the material with the lowest value.
    """
    material = without_islands(quads, fields(points[quads].mean(axis=1)).argmin(axis=1))
    points = snap_borders(points, quads, solid, fields, material, 0.4 * spacing)
    return project(mend(points, quads, solid, 0.025 * spacing**2), solid, 2), material


def without_islands(quads, material):
    """Gives a quad the material of its neighbours if three or more of them share another one."""
    neighbours = opposites(quads).reshape(-1, 4) // 4
    for _ in range(3):
        around = np.sort(material[neighbours], axis=1)
        # Three of four sorted values are equal if and only if the middle two equal an outer one.
        same = (around[:, 1] == around[:, 2]) & ((around[:, 0] == around[:, 1])
                                                 | (around[:, 2] == around[:, 3]))
        material = np.where(same, around[:, 1], material)
    return material


def snap_borders(points, quads, solid, fields, material, longest_step, rounds=6):
    """Moves points between two materials onto the curve where the fields are equal, and smooths the
    quads."""
    lowest, highest = np.full(len(points), material.max()), np.zeros(len(points), int)
    np.minimum.at(lowest, quads.ravel(), np.repeat(material, 4))
    np.maximum.at(highest, quads.ravel(), np.repeat(material, 4))
    border = np.flatnonzero(lowest != highest)
    rows = np.arange(len(border))

    def difference(x):
        values = fields(x)
        return values[rows, lowest[border]] - values[rows, highest[border]]

    for _ in range(rounds):
        points = even_out(points, quads, solid, 1)
        x = points[border]
        normal = solid.gradient(x)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
        slope = solid.gradient(x, field=difference)
        slope -= normal * (slope * normal).sum(axis=1, keepdims=True)
        squared = np.maximum((slope**2).sum(axis=1), 1e-2)
        step = -slope * (difference(x) / squared)[:, None]
        length = np.linalg.norm(step, axis=1, keepdims=True)
        step *= np.minimum(1, longest_step / np.maximum(length, 1e-12))
        points[border] = project(x + step, solid, 1)
    return points


def mend(points, quads, solid, least_area, rounds=4):
    """Smooths again where snapping has left a quad with almost no area."""
    for _ in range(rounds):
        vertices = np.unique(quads[quad_areas(points, quads) < least_area])
        points[vertices] = even_out(points, quads, solid, 1)[vertices]
    return points
