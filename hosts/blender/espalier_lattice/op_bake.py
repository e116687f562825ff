# SPDX-License-Identifier: Apache-2.0
"""Operators that bake the motion of bound objects, so that they play without the add-on."""

import struct

import bpy
import numpy as np
from bpy_extras.io_utils import ExportHelper

from . import binding, lattice_object, shape_keys
from .lattice_object import LatticeError
from .op_base import EspalierOperator, bound_selection


def frames_of(operator, context):
    scene = context.scene
    first, last = operator.first, operator.last
    if operator.use_scene_range:
        first, last = scene.frame_start, scene.frame_end
    if last < first:
        raise LatticeError(f"the last frame, {last}, is before the first, {first}")
    return range(first, last + 1, operator.step)


def bake(context, objects, frames, take):
    """Calls take(object, frame, points) for each object in each frame. Returns to the current frame. The motion
    that was baked before is removed first."""
    scene = context.scene
    for object in objects:
        binding.remove_baked(object)
    before = scene.frame_current
    try:
        for frame in frames:
            scene.frame_set(frame)
            depsgraph = context.evaluated_depsgraph_get()
            for object in objects:
                take(object, frame, binding.posed_points(object, depsgraph))
    except Exception:
        for object in objects:
            binding.remove_baked(object)
        raise
    finally:
        scene.frame_set(before)
    for object in objects:
        object.espalier.is_live = False
        key = binding.following_key(object)
        if key is not None:
            key.value = 0


class BakeBase(EspalierOperator):
    use_scene_range: bpy.props.BoolProperty(name="Scene Range", default=True,
                                            description="Bake from the first to the last frame of the scene")
    first: bpy.props.IntProperty(name="First Frame", default=1,
                                 description="The first frame to bake, if Scene Range is off")
    last: bpy.props.IntProperty(name="Last Frame", default=250,
                                description="The last frame to bake, if Scene Range is off")
    step: bpy.props.IntProperty(name="Step", min=1, default=1)

    def draw(self, context):
        column = self.layout.column()
        column.prop(self, "use_scene_range")
        frames = column.column(align=True)
        frames.enabled = not self.use_scene_range
        frames.prop(self, "first")
        frames.prop(self, "last")
        column.prop(self, "step")


class BakeShapeKeys(BakeBase, bpy.types.Operator):
    """Make a shape key of each frame, with an animation that plays them, instead of following the lattice"""

    bl_idname = "espalier.bake_shape_keys"
    bl_label = "Bake to Shape Keys"

    def run(self, context):
        objects = bound_selection(context)
        frames = frames_of(self, context)
        self.give_own_meshes(objects)

        def take(object, frame, points):
            key = object.shape_key_add(name=f"{binding.KEY} {frame}", from_mix=False)
            object.espalier.baked_keys.add().name = key.name
            key.vertex_group = object.espalier.vertex_group
            key.data.foreach_set("co", points.astype(np.float32).ravel())
            for other, value in ((frame - self.step, 0.0), (frame, 1.0), (frame + self.step, 0.0)):
                if other in frames or other == frame:
                    key.value = value
                    key.keyframe_insert("value", frame=other)
            for curve in shape_keys.curves_of_key(object.data.shape_keys, key.name):
                for point in curve.keyframe_points:
                    point.interpolation = "LINEAR"

        bake(context, objects, frames, take)
        context.scene.frame_set(context.scene.frame_current)
        self.report({"INFO"}, f"{len(frames)} shape keys for each of {len(objects)} objects")


class BakePointCache(BakeBase, ExportHelper, bpy.types.Operator):
    """Write the points of the active object in each frame to a point cache (.pc2), and play it"""

    bl_idname = "espalier.bake_point_cache"
    bl_label = "Bake to Point Cache"

    filename_ext = ".pc2"
    filter_glob: bpy.props.StringProperty(default="*.pc2", options={"HIDDEN"})

    def run(self, context):
        object = context.view_layer.objects.active
        if not binding.is_bound(object):
            raise LatticeError("select a bound object")
        lattice_object.check_local(object)
        frames = frames_of(self, context)
        self.give_own_meshes([object])
        with open(self.filepath, "wb") as file:
            # The header of the format: version, points, first frame, frames per sample, samples.
            file.write(struct.pack("<12siiffi", b"POINTCACHE2", 1, len(object.data.vertices),
                                   float(frames[0]), float(self.step), len(frames)))
            bake(context, [object], frames,
                 lambda _, frame, points: file.write(points.astype("<f4").tobytes()))
        modifier = object.modifiers.new(binding.KEY, "MESH_CACHE")
        object.espalier.cache_modifier = modifier.name
        binding.set_masks(object)
        modifier.cache_format = "PC2"
        modifier.filepath = self.filepath
        modifier.frame_start = frames[0]
        modifier.frame_scale = 1 / self.step
        self.report({"INFO"}, f"{self.filepath}: {len(frames)} frames of {len(object.data.vertices)} points")
