# SPDX-License-Identifier: Apache-2.0
"""Measures of a shape with their derivatives, for the constraints of an optimiser.

Each measure takes points, an array (N, 3): of a deformed model, or the vertices of a lattice. It returns
m values, an array (m,), and their derivatives G, a StencilTable (m, 3 N), whose column 3 i + c is
coordinate c of point i:

    constraints = espalier.constraints
    volume, by_points = constraints.volume(binding.deform(pose), triangles)
    by_vertices = constraints.by_vertices(by_points, binding).csr()      # (1, 3 V)
    by_variables = constraints.by_variables(by_points, espalier.jacobian(binding, design.matrix()))
"""

from ._core._constraints import *

__all__ = [
    "area",
    "by_variables",
    "by_vertices",
    "crossings",
    "curvatures",
    "distances",
    "planarity",
    "thicknesses",
    "volume",
]
