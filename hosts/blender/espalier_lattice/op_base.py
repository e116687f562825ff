# SPDX-License-Identifier: Apache-2.0
"""The base of all operators of the add-on, and helpers that several operators share."""

import contextlib

import bpy

from . import binding, lattice_object
from .lattice_object import LatticeError

# Errors that a user can cause. RuntimeError is the error of Blender's own operators.
EXPECTED = (LatticeError, ImportError, ValueError, MemoryError, OSError, RuntimeError)


class EspalierOperator:
    """Calls run() in object mode, returns to the mode before, and turns errors into reports."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            with object_mode(context):
                self.run(context)
        except EXPECTED as error:
            is_of_file = isinstance(error, OSError) and error.filename
            self.report({"ERROR"}, f"{error.filename}: {error.strerror}" if is_of_file else str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def give_own_meshes(self, objects):
        """Gives each object a mesh of its own, and reports the objects whose mesh was shared."""
        for object in objects:
            others = binding.give_own_mesh(object)
            if others:
                self.report({"INFO"}, f"{object.name} shared its mesh with {', '.join(others)}; it has a copy of "
                                      "its own now")


@contextlib.contextmanager
def object_mode(context):
    """Leaves edit mode and the other modes, and returns to the mode if the same object is still active."""
    active = context.view_layer.objects.active
    mode = active.mode if active is not None else "OBJECT"
    if mode != "OBJECT":
        if not bpy.ops.object.mode_set.poll():
            raise LatticeError(f"{active.name}: leave its mode, {mode.lower().replace('_', ' ')}, first")
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if mode != "OBJECT" and context.view_layer.objects.active == active and bpy.ops.object.mode_set.poll():
            bpy.ops.object.mode_set(mode=mode)


def select_only(context, object):
    for other in context.selected_objects:
        other.select_set(False)
    object.select_set(True)
    context.view_layer.objects.active = object


def selected_meshes(context):
    """Returns the selected meshes that are no lattices."""
    return [o for o in context.selected_objects if o.type == "MESH" and not lattice_object.is_lattice(o)]


def bound_selection(context):
    """Returns the bound objects that are selected, and the bound objects of selected lattices."""
    selected = list(context.selected_objects)
    objects = [o for o in selected if binding.is_bound(o)]
    for lattice in selected:
        if lattice_object.is_lattice(lattice):
            objects += [o for o in binding.bound_objects(lattice=lattice) if o not in objects]
    if not objects:
        raise LatticeError("select bound objects, or their lattice")
    for object in objects:
        lattice_object.check_local(object)
    return objects


def active_lattice(context, to_change=True):
    """Returns the active object if it is a lattice, which must not be linked from a library if it will change."""
    lattice = context.view_layer.objects.active
    if not lattice_object.is_lattice(lattice):
        raise LatticeError("select a lattice")
    if to_change:
        lattice_object.check_local(lattice)
    return lattice


def report_bound(operator, bounds, start):
    """Reports the number of points outside, as a warning if there are any."""
    outside = sum(bound.count_outside() for bound in bounds)
    points = sum(len(bound.points) for bound in bounds)
    operator.report({"WARNING" if outside else "INFO"}, f"{start}; {outside} of {points} points outside")
