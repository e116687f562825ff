# SPDX-License-Identifier: Apache-2.0
"""Lift and induced drag of a half wing, and their gradients by the points of its surface.

The panel method gives the flow around sections of the wing; a lifting line joins them (Prandtl 1918). The wing flies at
unit speed in a fluid of unit density, with its mirror image beyond the plane of symmetry. Forces are coefficients for
an area of 1, of both halves together.
"""

import numpy as np
import scipy.sparse

from panel_method import Flow


def cut(points, triangles, axis, place):
    """Cuts a surface by a plane across an axis, where no point is. Returns the loop of the cut: a list of edges (a, b)
    and the share of the way from a to b."""
    side = points[:, axis] > place
    links = {}
    for triangle in triangles[(side[triangles].sum(axis=1) % 3) > 0]:
        edges = [tuple(sorted(pair)) for pair in zip(triangle, np.roll(triangle, -1)) if side[pair[0]] != side[pair[1]]]
        links.setdefault(edges[0], []).append(edges[1])
        links.setdefault(edges[1], []).append(edges[0])
    loop = [next(iter(links))]
    while True:
        following = [edge for edge in links[loop[-1]] if len(loop) < 2 or edge != loop[-2]]
        if not following or following[0] == loop[0]:
            break
        loop.append(following[0])
    heights = points[:, axis]
    return [(a, b, (place - heights[a]) / (heights[b] - heights[a])) for a, b in loop]


def section_rows(points, triangles, axis, place, panels):
    """Returns the weights of the points of a mesh in the points of a section: a sparse matrix (panels, N). The points of
    the section are anticlockwise from the trailing edge, and denser near both edges."""
    loop = cut(points, triangles, axis, place)
    rows = scipy.sparse.lil_matrix((len(loop), len(points)))
    for n, (a, b, share) in enumerate(loop):
        rows[n, a], rows[n, b] = 1 - share, share
    plane = in_plane(rows @ points, axis)
    turn = (plane.conj() * np.roll(plane, -1)).imag.sum()
    order = np.arange(len(loop)) if turn > 0 else np.arange(len(loop))[::-1]
    order = np.roll(order, -int(np.argmax(plane[order].real)))
    plane, leading = plane[order], int(np.argmin(plane[order].real))
    result = []
    closed = np.append(order, order[0])
    for first, last in ((0, leading), (leading, len(loop))):
        part = closed[first:last + 1]
        places = in_plane(rows.tocsr()[part] @ points, axis)
        along = np.concatenate([[0], np.cumsum(abs(np.diff(places)))])
        wanted = along[-1] * (1 - np.cos(np.pi * np.arange(panels // 2) / (panels // 2))) / 2
        at = np.clip(np.searchsorted(along, wanted, side="right") - 1, 0, len(part) - 2)
        share = scipy.sparse.diags((wanted - along[at]) / (along[at + 1] - along[at]))
        result.append(rows.tocsr()[part[at]] + share @ (rows.tocsr()[part[at + 1]] - rows.tocsr()[part[at]]))
    return scipy.sparse.vstack(result).tocsr()


def in_plane(points, axis):
    """Returns points as complex numbers: x, and the coordinate across x and the span."""
    return points[:, 0] + 1j * points[:, 3 - axis]


def lift_gradient(flow):
    """The gradient of the lift of a section by its points."""
    by_length = -2 * flow.strength * flow.tangent
    return flow.gradient(-2 * flow.length) - by_length + np.roll(by_length, 1)


class Wing:
    """The sections of a half wing, in the middle of strips from the plane of symmetry to the tip.

    axis is the number of the axis of the span: 1 or 2.
    """

    def __init__(self, points, triangles, axis, strips, panels, incidence):
        self.axis, self.incidence, self.panels = axis, incidence, panels
        used = np.unique(triangles)
        root, tip = points[used, axis].min(), points[used, axis].max()
        # Strips are narrower near the tip, where the circulation falls.
        edges = (tip - root) * np.sin(np.pi / 2 * np.linspace(0, 1, strips + 1))
        self.width, self.middle = np.diff(edges), (edges[1:] + edges[:-1]) / 2
        # A point of the mesh in the plane would have no edge that crosses it.
        self.sections = [section_rows(points, triangles, axis, root + place + 1e-7 * tip, panels)
                         for place in self.middle]
        a, b, y = edges[:-1], edges[1:], self.middle[:, None]
        self.downwash = (1 / (y - a) + 1 / (b - y) + 1 / (y + b) - 1 / (y + a)) / (4 * np.pi)

    def evaluate(self, points):
        """Returns lift and induced drag, and their gradients by the points of the mesh: arrays (N, 3). Keeps the circulation
        around the strips."""
        planes = [in_plane(rows @ points, self.axis) for rows in self.sections]
        flows = [Flow(plane, self.incidence) for plane in planes]
        # The lift is a sine of the incidence: its slope is the lift at a right angle to it.
        slopes = [Flow(plane, self.incidence + np.pi / 2) for plane in planes]
        lift, slope = (np.array([flow.lift for flow in each]) for each in (flows, slopes))
        matrix = np.eye(len(planes)) + slope[:, None] * self.downwash / 2
        circulation = np.linalg.solve(matrix, lift / 2)
        self.circulation = circulation
        fall = self.downwash @ circulation
        weights = 4 * self.width
        total, drag = weights @ circulation, weights @ (circulation * fall)
        results = []
        for by_circulation in (weights, weights * fall + self.downwash.T @ (weights * circulation)):
            adjoint = np.linalg.solve(matrix.T, by_circulation) / 2
            gradient = np.zeros(points.shape)
            for k, rows in enumerate(self.sections):
                by_section = adjoint[k] * (lift_gradient(flows[k]) - fall[k] * lift_gradient(slopes[k]))
                gradient[:, 0] += rows.T @ by_section.real
                gradient[:, 3 - self.axis] += rows.T @ by_section.imag
            results.append(gradient)
        return total, drag, results[0], results[1]
