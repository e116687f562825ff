# SPDX-License-Identifier: Apache-2.0
"""Operators that bind objects to lattices."""

import bpy

from . import binding, evaluation, following, lattice_object
from .lattice_object import LatticeError
from .op_base import EspalierOperator, bound_selection, report_bound, selected_meshes


class Bind(EspalierOperator, bpy.types.Operator):
    """Bind the selected objects to the active lattice as it is now"""

    bl_idname = "espalier.bind"
    bl_label = "Bind"

    def run(self, context):
        lattice = context.view_layer.objects.active
        objects = selected_meshes(context)
        if not lattice_object.is_lattice(lattice) or not objects:
            raise LatticeError("select the objects to bind, and last the lattice")
        for object in objects:
            lattice_object.check_local(object)
        self.give_own_meshes(objects)
        depsgraph = context.evaluated_depsgraph_get()
        bounds = [binding.bind(object, lattice, depsgraph) for object in objects]
        evaluation.keep(context.scene)
        report_bound(self, bounds, f"{len(objects)} objects bound to {lattice.name}")


class Rebind(EspalierOperator, bpy.types.Operator):
    """Bind again: the lattice as it is now becomes the rest of the selected bound objects"""

    bl_idname = "espalier.rebind"
    bl_label = "Rebind"

    def run(self, context):
        objects = bound_selection(context)
        for object in objects:
            binding.check_lattice(object)
        self.give_own_meshes(objects)
        bounds = [binding.bind(object, object.espalier.lattice, context.evaluated_depsgraph_get())
                  for object in objects]
        evaluation.keep(context.scene)
        report_bound(self, bounds, f"{len(objects)} objects bound again")


class Unbind(EspalierOperator, bpy.types.Operator):
    """Unbind the selected objects, which return to their shape at rest"""

    bl_idname = "espalier.unbind"
    bl_label = "Unbind"

    def run(self, context):
        objects = bound_selection(context)
        self.give_own_meshes(objects)
        for object in objects:
            binding.unbind(object)
        evaluation.keep(context.scene)
        self.report({"INFO"}, f"{len(objects)} objects unbound")


class FollowAgain(EspalierOperator, bpy.types.Operator):
    """Remove what was baked, and follow the lattice again"""

    bl_idname = "espalier.follow_again"
    bl_label = "Follow Again"

    def run(self, context):
        objects = bound_selection(context)
        self.give_own_meshes(objects)
        for object in objects:
            binding.remove_baked(object)
            object.espalier.is_live = True
            following.update(object, context.evaluated_depsgraph_get())
        told = [binding.problems[o.name_full] for o in objects if o.name_full in binding.problems]
        if told:
            raise LatticeError("; ".join(told))
        self.report({"INFO"}, f"{len(objects)} objects follow their lattice")


class MarkOutside(EspalierOperator, bpy.types.Operator):
    """Make a vertex group of the points outside the lattice"""

    bl_idname = "espalier.mark_outside"
    bl_label = "Points Outside"

    def run(self, context):
        counts = {o.name: binding.mark_outside(o) for o in bound_selection(context)}
        self.report({"WARNING" if any(counts.values()) else "INFO"},
                    ", ".join(f"{name}: {count} points outside" for name, count in counts.items()))
