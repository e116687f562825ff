# SPDX-License-Identifier: Apache-2.0
"""Ready-made lattices (MacCracken & Joy 1996, section 5), and merging of lattices."""

from ._core._shapes import *

__all__ = [
    "arm",
    "around",
    "barbell",
    "bipyramid",
    "box",
    "cage",
    "collar",
    "cube",
    "cylinder",
    "dodecahedron",
    "icosahedron",
    "merge",
    "octahedron",
    "prism",
    "pyramid",
    "star",
    "tetrahedron",
    "torus",
]
