# SPDX-License-Identifier: Apache-2.0
"""Operations that pose a lattice (Barr 1984), and selections of its vertices.

An operation takes positions, an array (N, 3), and returns the new ones:

    pose = espalier.pose
    top = pose.select_end(rest.positions, "+z", falloff="smooth", falloff_radius=2.0)
    posed = pose.twist(rest.positions, "z", np.pi / 2, weights=top)
    model.write("twisted.obj", binding.deform(posed))
"""

from ._core._pose import *

__all__ = [
    "bend",
    "border",
    "displace",
    "grow",
    "mirror",
    "move",
    "rotate",
    "scale",
    "select_ball",
    "select_beyond",
    "select_box",
    "select_end",
    "select_half_space",
    "select_limb",
    "select_near",
    "select_numbers",
    "taper",
    "twist",
    "without_held",
]
