# SPDX-License-Identifier: Apache-2.0
"""Makes Blender evaluate lattices in renders, and wherever lattices are hidden.

A lattice is not rendered. Blender evaluates an object that is hidden only if an object that is not hidden depends on
it, and Blender does not know that bound objects depend on their lattice, because a handler moves them. Therefore each
scene with bound objects has an empty, which draws nothing and which depends on all lattices: it has a constraint for
each lattice. The constraints have no influence, but Blender evaluates their targets: the place of the lattice, and its
shape, because a constraint with a vertex group reads the shape. Nothing depends on the empty, so that no cycle can
arise.
"""

import bpy

NAME = "Espalier lattices"
MARK = "espalier_lattices"  # the property by which the empty is found


def keepers(scene):
    return [o for o in scene.objects if MARK in o and o.library is None]


def keep(scene, bound=None):
    """Makes the empty of a scene depend on the lattices of all bound objects of the scene, and removes the empty if
    there are none. Does nothing if this is so."""
    from . import binding
    lattices = []
    for object in binding.bound_objects(scene) if bound is None else bound:
        lattice = object.espalier.lattice
        if lattice is not None and lattice not in lattices:
            lattices.append(lattice)
    empties = keepers(scene)
    for empty in empties if not lattices else empties[1:]:
        scene.collection.objects.unlink(empty) if len(empty.users_scene) > 1 else bpy.data.objects.remove(empty)
    if not lattices:
        return
    empty = empties[0] if empties else add(scene)
    if {constraint.target for constraint in empty.constraints} == set(lattices) and not empty.hide_render:
        return
    empty.hide_render = empty.hide_viewport = False
    for constraint in list(empty.constraints):
        empty.constraints.remove(constraint)
    for lattice in lattices:
        constraint = empty.constraints.new("COPY_LOCATION")
        constraint.name = lattice.name
        constraint.target = lattice
        constraint.subtarget = "shape"  # A vertex group, which need not exist.
        constraint.influence = 0


def add(scene):
    """Adds the empty to a scene, hidden in the viewport, and locks the interface during renders, because the handler
    changes shape keys in the thread of the render. Returns the empty."""
    empty = bpy.data.objects.new(NAME, None)
    empty[MARK] = True
    empty.hide_select = True
    empty.empty_display_size = 0.001
    scene.collection.objects.link(empty)
    for layer in scene.view_layers:
        empty.hide_set(True, view_layer=layer)  # Blender evaluates it nevertheless.
    scene.render.use_lock_interface = True
    return empty
