# SPDX-License-Identifier: Apache-2.0
"""Shape keys of meshes and their animation."""

import bpy
import numpy as np


def names(object):
    """Returns the names of the shape keys of an object; none if it has no mesh with shape keys."""
    return object.data.shape_keys.key_blocks.keys() if object.data.shape_keys else []


def give_own_action(keys):
    """Gives shape keys a copy of their animation if other shape keys have the same animation."""
    data = keys.animation_data
    if data and data.action and data.action.users - data.action.use_fake_user > 1:
        data.action = data.action.copy()


def curves(keys):
    """Returns the collection of the animation curves of shape keys; an empty list if there are none."""
    data = keys.animation_data
    if not data or not data.action:
        return []
    if not hasattr(data, "action_slot"):
        return data.action.fcurves
    # Since Blender 4.4, several data can share an action, and each has a slot of it.
    bags = [strip.channelbag(data.action_slot) for layer in data.action.layers for strip in layer.strips]
    return next((bag.fcurves for bag in bags if bag), [])


def curves_of_key(keys, name):
    """Returns the animation curves of one shape key."""
    path = f'key_blocks["{bpy.utils.escape_identifier(name)}"].'
    return [curve for curve in curves(keys) if curve.data_path.startswith(path)]


def add_pose(object, name, positions):
    """Adds a shape key with positions, makes it active and shows it alone, since Blender adds up the shape keys above 0.
    Returns the shape key, and the names of the shape keys that are set to 0."""
    if object.data.shape_keys is None:
        object.shape_key_add(name="Basis", from_mix=False)
    others = [key for key in object.data.shape_keys.key_blocks[1:] if key.value != 0]
    for key in others:
        key.value = 0
    added = object.shape_key_add(name=name, from_mix=False)
    added.data.foreach_set("co", np.asarray(positions, dtype=np.float32).ravel())
    added.value = 1
    object.active_shape_key_index = len(object.data.shape_keys.key_blocks) - 1
    object.data.update()
    return added, [key.name for key in others]


def remove(object, name):
    """Removes a shape key and its animation. Does nothing if the shape key is gone."""
    if name not in names(object):
        return
    keys = object.data.shape_keys
    give_own_action(keys)
    for curve in curves_of_key(keys, name):
        curves(keys).remove(curve)
    data = keys.animation_data
    if data and data.action and not curves(keys) and not data.drivers and not data.nla_tracks:
        keys.animation_data_clear()
    object.shape_key_remove(keys.key_blocks[name])
