# SPDX-License-Identifier: Apache-2.0
"""The table of the operators, from which they are registered and the panel draws its buttons."""

import bpy

from .op_add import AddLattice, ExportLattice, ImportLattice, MakeLattice
from .op_bake import BakePointCache, BakeShapeKeys
from .op_bind import Bind, FollowAgain, MarkOutside, Rebind, Unbind
from .op_cells import ExtrudeCell, MarkFolded, UpdateCells

# The buttons of the panel, in groups: by the kind of the active object.
BUTTONS = {
    "other": ((MakeLattice, ImportLattice),),
    "lattice": ((Bind, Rebind, Unbind), (UpdateCells, ExtrudeCell, MarkFolded),
                (ImportLattice, ExportLattice)),
    "bound": ((Rebind, Unbind, MarkOutside), (BakeShapeKeys, BakePointCache, FollowAgain)),
}
# AddLattice has a menu of its kinds.
CLASSES = tuple(dict.fromkeys([AddLattice, *(each for groups in BUTTONS.values() for group in groups
                                             for each in group)]))


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister():
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
