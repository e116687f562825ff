# SPDX-License-Identifier: Apache-2.0
"""Moves the bound objects after their lattices, in the viewport and in renders, by handlers of Blender."""

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import binding, evaluation, lattice_object
from .lattice_object import LatticeError, NotEvaluated

_is_updating = False


def problem_of(object):
    """Returns why an object does not follow its lattice, as a sentence; "" if it does."""
    try:
        binding.check_lattice(object)
    except LatticeError as error:
        return str(error)
    return binding.problems.get(object.name_full, "")


def update(object, depsgraph):
    """Moves the points of a bound object after its lattice. Returns True if they moved. Does nothing if the
    depsgraph does not evaluate the lattice: Blender makes some for a render that have no objects."""
    if not object.espalier.is_live:
        return False
    key = binding.following_key(object)
    try:
        lattice_object.check_local(object)
        if key is None:
            raise LatticeError(f"{object.name}: its shape key {object.espalier.key or binding.KEY} is gone; rebind")
        group = object.espalier.vertex_group
        if group and group not in object.vertex_groups:
            raise LatticeError(f"{object.name}: it has no vertex group {group}, so all points follow fully; choose "
                               "another group, or none")
        bound = binding.bound_of(object)
        points = binding.posed_points(object, depsgraph)
    except NotEvaluated:
        return False
    except (LatticeError, ImportError, ValueError) as error:
        binding.problems[object.name_full] = str(error)
        return False
    binding.problems.pop(object.name_full, None)
    new = points.astype(np.float32).ravel()
    if bound.written is None:
        bound.written = np.empty_like(new)
        key.data.foreach_get("co", bound.written)
    if np.array_equal(bound.written, new):
        return False
    key.data.foreach_set("co", new)
    bound.written = new
    object.data.update_tag()
    return True


def update_all(scene, depsgraph, only=None):
    """Updates the bound objects of a scene: all, or those that are named in `only` or follow a lattice in it."""
    global _is_updating
    if _is_updating:
        return
    _is_updating = True
    try:
        bound = binding.bound_objects(scene)
        if depsgraph.mode == "VIEWPORT":  # A render runs in another thread, where no object may be added.
            evaluation.keep(scene, bound)
        for object in bound:
            lattice = object.espalier.lattice
            if only is None or object.name_full in only or (lattice is not None and lattice.name_full in only):
                update(object, depsgraph)
    finally:
        _is_updating = False


@persistent
def on_frame(scene, depsgraph):
    update_all(scene, depsgraph)


@persistent
def on_depsgraph(scene, depsgraph):
    if _is_updating:
        return
    changed = {u.id.original.name_full for u in depsgraph.updates
               if isinstance(u.id, bpy.types.Object) and (u.is_updated_geometry or u.is_updated_transform)}
    if changed or depsgraph.id_type_updated("SCENE") or depsgraph.id_type_updated("COLLECTION"):
        update_all(scene, depsgraph, changed)


@persistent
def on_load(_=None, __=None):
    binding.forget_all()
    for scene in bpy.data.scenes:
        evaluation.keep(scene)


@persistent
def on_undo(_=None, __=None):
    """Undo may have changed the shape keys."""
    binding.read_keys_again()


HANDLERS = {"frame_change_post": on_frame, "depsgraph_update_post": on_depsgraph, "load_post": on_load,
            "undo_post": on_undo, "redo_post": on_undo}


def register():
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    binding.forget_all()
