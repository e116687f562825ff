# SPDX-License-Identifier: Apache-2.0
"""The axis of a file that points up. Blender's z axis points up; Blender's importers of glTF and OBJ turn y up to z up."""

import bpy
import numpy as np


class HasUp:
    """The option of operators that read or write a file of a lattice."""

    up: bpy.props.EnumProperty(
        name="Up", default="Z",
        items=(("Z", "Z", "Coordinates as in the file"),
               ("Y", "Y", "The y axis of the file points up, as Blender's importers of glTF and OBJ take it: "
                          "(x, y, z) of the file is (x, -z, y) in Blender")),
        description="The axis of the file that points up")


def from_file(positions, up):
    """Returns positions of a file as positions in Blender: array (V, 3)."""
    x, y, z = np.asarray(positions).T
    return np.stack((x, -z, y), axis=-1) if up == "Y" else np.asarray(positions)


def to_file(positions, up):
    """The inverse of from_file(), which is exact."""
    x, y, z = np.asarray(positions).T
    return np.stack((x, z, -y), axis=-1) if up == "Y" else np.asarray(positions)
