# SPDX-License-Identifier: Apache-2.0
"""The settings of a bound object, which the .blend file saves."""

import bpy

from . import lattice_object


def _rebind_is_needed(self, context):
    """Settings that change the binding hold from the next update on."""
    from . import binding, following
    object = self.id_data
    if binding.is_bound(object):
        following.update(object, context.evaluated_depsgraph_get())


def _mask_is_needed(self, context):
    from . import binding
    binding.set_masks(self.id_data)
    _rebind_is_needed(self, context)


class EspalierSettings(bpy.types.PropertyGroup):
    lattice: bpy.props.PointerProperty(
        type=bpy.types.Object, name="Lattice", description="The lattice that this object follows",
        poll=lambda self, object: lattice_object.is_lattice(object))
    level: bpy.props.IntProperty(
        name="Level", description="How many times the lattice is refined", min=1, max=8, default=3,
        update=_rebind_is_needed)
    use_limit: bpy.props.BoolProperty(
        name="Limit", description="Bind to the limit of refinement instead of a level",
        update=_rebind_is_needed)
    outside: bpy.props.EnumProperty(
        name="Outside", description="What happens to points outside the lattice", update=_rebind_is_needed,
        items=(("keep", "Stay", "They stay where they are"),
               ("nearest", "Follow", "They follow the nearest cell, unless they are too far away")))
    vertex_group: bpy.props.StringProperty(
        name="Vertex Group", description="The weights of this group say how far each point follows; without a "
        "group, all points follow fully", update=_mask_is_needed)
    falloff: bpy.props.FloatProperty(
        name="Falloff", description="If above 0, points outside the lattice follow it with a weight that falls "
        "smoothly to 0 at this distance, in the coordinates of the object", min=0, subtype="DISTANCE",
        update=_rebind_is_needed)
    rules: bpy.props.EnumProperty(
        name="Rules", description="The rules of refinement", update=_rebind_is_needed,
        items=(("siggraph96", "SIGGRAPH 96", "MacCracken and Joy 1996"),
               ("cse96", "CSE 96", "Joy and MacCracken 1996"),
               ("mlca", "MLCA", "Bajaj, Schaefer, Warren and Xu 2002")))
    is_live: bpy.props.BoolProperty(
        name="Follow", description="Follow the lattice in the viewport and in renders", default=True)
    # Names of the data that the add-on has made. It removes these data, and no others.
    key: bpy.props.StringProperty(options={"HIDDEN"})  # the shape key that follows
    has_made_basis: bpy.props.BoolProperty(options={"HIDDEN"})
    baked_keys: bpy.props.CollectionProperty(type=bpy.types.PropertyGroup, options={"HIDDEN"})
    cache_modifier: bpy.props.StringProperty(options={"HIDDEN"})


def register():
    bpy.utils.register_class(EspalierSettings)
    bpy.types.Object.espalier = bpy.props.PointerProperty(type=EspalierSettings)


def unregister():
    del bpy.types.Object.espalier
    bpy.utils.unregister_class(EspalierSettings)
