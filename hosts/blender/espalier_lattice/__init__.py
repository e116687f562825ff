# SPDX-License-Identifier: Apache-2.0
"""Lattices of any polyhedral cells for Blender."""

bl_info = {
    "name": "Espalier lattice",
    "author": "The Espalier developers",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Add > Espalier lattice; sidebar of the 3D view",
    "description": "Deforms objects by lattices of any polyhedral cells",
    "category": "Rigging",
}

from . import following, operators, panel, settings  # noqa: E402


def register():
    settings.register()
    operators.register()
    panel.register()
    following.register()


def unregister():
    following.unregister()
    panel.unregister()
    operators.unregister()
    settings.unregister()
