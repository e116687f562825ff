# SPDX-License-Identifier: Apache-2.0
"""Objects that follow a lattice.

A bound object has a shape key of the add-on, named "Espalier" if that is free, whose points are computed
whenever the lattice moves: by a handler, in the viewport and in renders. Points x of the object become x + D
(q' - q): q are the vertices of the lattice in the coordinates of the object when it was bound, and q' they
are now. So the object follows if the lattice moves against it, and stays as it is if both move together.

q and the settings are saved in the .blend file. D is computed again when the file is opened and the lattice
moves for the first time: the same lattice and points give the same D, bit for bit. The file also has hashes of
x and of the cells and creases of the lattice, so that changes after binding are told, not taken.
"""

import hashlib

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import engine, lattice_object
from .lattice_object import LatticeError

KEY = "Espalier"
REST = "espalier_rest"
POINTS = "espalier_points"
TOPOLOGY = "espalier_topology"
OUTSIDE_GROUP = "Espalier outside"


class Bound:
    """The binding of one object, which is not saved."""

    def __init__(self, object):
        espalier = engine.load()
        settings = object.espalier
        lattice_mesh = settings.lattice
        self.source = source_of(object)
        self.rest = np.array(object[REST], dtype=np.float64).reshape(-1, 3)
        self.points = rest_points(object)
        self.seen = mesh_points(object)  # the points of the mesh when they were last known to be the rest
        lattice = lattice_object.lattice_of(lattice_mesh, espalier, self.rest)
        refiner = espalier.Refiner(lattice, rules=settings.rules)
        self.refiner = refiner
        to = {"limit": True} if settings.use_limit else {"level": settings.level}
        outside = {"falloff": settings.falloff} if settings.falloff > 0 else {"outside": settings.outside}
        self.binding = espalier.bind(refiner, self.points, **to, **outside)
        self.moved = np.empty_like(self.points)
        self.written = None  # the coordinates that the shape key has, unless undo has changed them

    def deform(self, pose):
        """Returns the points for a pose of the lattice in the coordinates of the object: array (N, 3)."""
        return self.binding.deform(pose, self.moved)


_bound = {}  # by the name of the object; bound_of() checks that it is still the binding of this object
_is_updating = False
problems = {}  # name of an object: why it does not follow its lattice


def is_bound(object):
    return (object is not None and object.type == "MESH" and object.espalier.lattice is not None
            and REST in object)


def bound_objects(scene=None, lattice=None):
    objects = scene.objects if scene is not None else bpy.data.objects
    return [o for o in objects if is_bound(o) and lattice in (None, o.espalier.lattice)]


def mesh_points(object):
    """Returns the points of the mesh itself, which Blender keeps equal to the points at rest: flat array of
    float32. This takes a tenth of the time of rest_points()."""
    points = np.empty(3 * len(object.data.vertices), dtype=np.float32)
    object.data.vertices.foreach_get("co", points)
    return points


def points_text(points):
    """Returns the number of points at rest, and a hash of them."""
    return f"{len(points)} {hashlib.sha256(points.tobytes()).hexdigest()[:24]}"


def check_unchanged(object):
    """Raises a LatticeError if the points at rest, the cells or the creases are not the same as at binding."""
    before = object.get(POINTS, "no").split()[0]
    found = _bound.get(object.name_full)
    count = len(object.data.vertices)
    lattice = object.espalier.lattice
    change = ""
    if lattice.mode != "EDIT":  # Edits of cells and creases are in the mesh when edit mode ends.
        change = lattice_object.topology_change(lattice, object[TOPOLOGY])
    if str(count) != before:
        change = f"{object.name} has {count} points; it had {before} when it was bound"
    elif found is None or not np.array_equal(found.seen, mesh_points(object)):
        if points_text(rest_points(object)) != object[POINTS]:
            change = f"the points of {object.name} have moved since binding"
        elif found is not None:
            found.seen = mesh_points(object)
    if change:
        raise LatticeError(f"{object.name}: {change}; rebind")


def rest_points(object):
    """Returns the points of a bound object at rest: array (N, 3)."""
    mesh = object.data
    source = mesh.shape_keys.key_blocks[0].data if mesh.shape_keys else mesh.vertices
    points = np.empty(3 * len(source), dtype=np.float32)
    source.foreach_get("co", points)
    return points.reshape(-1, 3).astype(np.float64)


def in_object(object, lattice, positions, depsgraph):
    """Converts positions from the coordinates of the lattice to those of the object."""
    matrix = (object.evaluated_get(depsgraph).matrix_world.inverted()
              @ lattice.evaluated_get(depsgraph).matrix_world)
    matrix = np.array(matrix)
    return positions @ matrix[:3, :3].T + matrix[:3, 3]


def sharing(object):
    """Returns the names of the other objects that have the mesh of an object."""
    mesh = object.data
    if mesh.users - mesh.use_fake_user < 2:
        return []
    return [o.name for o in bpy.data.objects if o.data == mesh and o != object]


def check_not_shared(object):
    """A shape key belongs to a mesh, so that objects with one mesh cannot follow a lattice each in its way."""
    others = sharing(object)
    if others:
        raise LatticeError(f"{object.name}: it shares its mesh with {', '.join(others)}; run Rebind, which gives "
                           "it a mesh of its own")


def give_own_mesh(object):
    """Gives an object a copy of its mesh if other objects have the same mesh. Returns the names of the others."""
    others = sharing(object)
    if others:
        object.data = object.data.copy()
        if object.data.shape_keys:
            give_own_action(object.data.shape_keys)
        forget(object)
    return others


def give_own_action(keys):
    """Gives shape keys a copy of their animation if other shape keys have the same animation."""
    data = keys.animation_data
    if data and data.action and data.action.users - data.action.use_fake_user > 1:
        data.action = data.action.copy()


def source_of(object):
    """Returns all that a Bound depends on, as a value to compare. Undo changes it, and so does a new name."""
    settings = object.espalier
    return (bytes(memoryview(object[REST])), object[POINTS], object[TOPOLOGY], settings.level, settings.use_limit,
            settings.outside, settings.falloff, settings.rules)


def bound_of(object):
    """Returns the Bound of an object, which is made if there is none."""
    check_not_shared(object)
    check_unchanged(object)
    found = _bound.get(object.name_full)
    if found is None or found.source != source_of(object):
        found = _bound[object.name_full] = Bound(object)
    return found


def forget(object):
    _bound.pop(object.name_full, None)
    problems.pop(object.name_full, None)


def bind(object, lattice, depsgraph):
    """Binds an object, whose mesh no other object has, to a lattice as it is now. Returns the Bound."""
    check_not_shared(object)
    if object.mode == "EDIT" or lattice.mode == "EDIT":
        raise LatticeError("leave edit mode before binding")
    forget(object)
    unbind(object)
    lattice_object.sync(lattice)
    pose = lattice_object.posed_positions(lattice, depsgraph)
    object.espalier.lattice = lattice
    object[REST] = in_object(object, lattice, pose, depsgraph).ravel().tolist()
    object[POINTS] = points_text(rest_points(object))
    object[TOPOLOGY] = lattice_object.topology_text(lattice)
    try:
        bound = bound_of(object)
    except Exception:
        object.espalier.lattice = None
        for name in (REST, POINTS, TOPOLOGY):
            del object[name]
        raise
    if object.data.shape_keys is None:
        object.shape_key_add(name="Basis", from_mix=False)
        object.espalier.has_made_basis = True
    key = object.shape_key_add(name=KEY, from_mix=False)
    key.value = 1
    object.espalier.key = key.name
    set_masks(object)
    return bound


def key_names(object):
    return object.data.shape_keys.key_blocks.keys() if object.data.shape_keys else []


def following_key(object):
    """Returns the shape key that follows the lattice; None if there is none."""
    name = object.espalier.key
    return object.data.shape_keys.key_blocks[name] if name and name in key_names(object) else None


def set_masks(object):
    """Lets what follows the lattice, and what was baked, have the weights of the vertex group. Blender multiplies
    by them, so that painting shows at once."""
    settings = object.espalier
    keys = {settings.key, *(each.name for each in settings.baked_keys)}
    for name in keys & set(key_names(object)):
        object.data.shape_keys.key_blocks[name].vertex_group = settings.vertex_group
    modifier = object.modifiers.get(settings.cache_modifier) if settings.cache_modifier else None
    if modifier is not None:
        modifier.vertex_group = settings.vertex_group


def key_curves(keys, name):
    """Returns the animation curves of a shape key."""
    data = keys.animation_data
    if not data or not data.action:
        return []
    path = f'key_blocks["{bpy.utils.escape_identifier(name)}"].'
    return [curve for curve in data.action.fcurves if curve.data_path.startswith(path)]


def remove_key(object, name):
    """Removes a shape key and its animation. Does nothing if it is gone."""
    if name not in key_names(object):
        return
    keys = object.data.shape_keys
    give_own_action(keys)
    for curve in key_curves(keys, name):
        keys.animation_data.action.fcurves.remove(curve)
    data = keys.animation_data
    if data and data.action and not data.action.fcurves and not data.drivers and not data.nla_tracks:
        keys.animation_data_clear()
    object.shape_key_remove(keys.key_blocks[name])


def remove_baked(object):
    """Removes the shape keys and the modifier that baking has made. Then the object follows its lattice again,
    if baking has made some."""
    settings = object.espalier
    if not settings.baked_keys and not settings.cache_modifier:
        return
    for name in [each.name for each in settings.baked_keys]:
        remove_key(object, name)
    settings.baked_keys.clear()
    modifier = object.modifiers.get(settings.cache_modifier) if settings.cache_modifier else None
    if modifier is not None:
        object.modifiers.remove(modifier)
    settings.cache_modifier = ""
    settings.is_live = True
    key = following_key(object)
    if key is not None:
        key.value = 1


def unbind(object):
    """Removes a binding and its shape key, so that the object, whose mesh no other object has, has its shape at
    rest."""
    check_not_shared(object)
    forget(object)
    settings = object.espalier
    remove_baked(object)
    if settings.key:
        remove_key(object, settings.key)
        settings.key = ""
    if settings.has_made_basis and len(key_names(object)) == 1:
        object.shape_key_remove(object.data.shape_keys.key_blocks[0])
    settings.has_made_basis = False
    group = object.vertex_groups.get(OUTSIDE_GROUP)
    if group is not None:
        object.vertex_groups.remove(group)
    object.espalier.lattice = None
    for name in (REST, POINTS, TOPOLOGY):
        if name in object:
            del object[name]


def update(object, depsgraph):
    """Moves the points of a bound object after its lattice. Returns True if they moved."""
    if not object.espalier.is_live:
        return False
    lattice = object.espalier.lattice
    key = following_key(object)
    try:
        if key is None:
            raise LatticeError(f"{object.name}: its shape key {object.espalier.key or KEY} is gone; rebind")
        group = object.espalier.vertex_group
        if group and group not in object.vertex_groups:
            raise LatticeError(f"{object.name}: it has no vertex group {group}, so all points follow fully; choose "
                               "another group, or none")
        pose = lattice_object.posed_positions(lattice, depsgraph)
        bound = bound_of(object)
        if len(pose) != len(bound.rest):
            raise LatticeError(f"{object.name}: {lattice.name} has {len(pose)} vertices; it had "
                               f"{len(bound.rest)} when the object was bound: rebind")
        points = bound.deform(in_object(object, lattice, pose, depsgraph))
    except (LatticeError, ImportError, ValueError) as error:
        problems[object.name_full] = str(error)
        return False
    problems.pop(object.name_full, None)
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


def mark_outside(object):
    """Makes a vertex group of the points outside the lattice, or removes it if there are none. Returns their
    number."""
    espalier = engine.load()
    statuses = np.asarray(bound_of(object).binding.statuses)
    outside = np.nonzero(statuses != int(espalier.PointStatus.INSIDE))[0]
    group = object.vertex_groups.get(OUTSIDE_GROUP)
    if group is not None:
        object.vertex_groups.remove(group)
    if len(outside):
        object.vertex_groups.new(name=OUTSIDE_GROUP).add(outside.tolist(), 1.0, "REPLACE")
    return len(outside)


def folded_cells(lattice, rest, level, espalier, pose):
    """Returns the cells of a lattice that a pose turns inside out, ascending. A cell counts if a cell of the
    level in it does."""
    at_rest = lattice_object.lattice_of(lattice, espalier, rest)
    check = espalier.ValidityCheck(at_rest, level)
    return sorted({check.base_cell(int(cell)) for cell in check.check(pose).inverted})


def update_all(scene, depsgraph, only=None):
    """Updates the bound objects of a scene: all, or those of some lattices."""
    global _is_updating
    if _is_updating:
        return
    _is_updating = True
    try:
        for object in bound_objects(scene):
            if only is None or object.espalier.lattice.name_full in only or object.name_full in only:
                update(object, depsgraph)
    finally:
        _is_updating = False


@persistent
def on_frame(scene, depsgraph=None):
    update_all(scene, depsgraph or bpy.context.evaluated_depsgraph_get())


@persistent
def on_depsgraph(scene, depsgraph):
    if _is_updating:
        return
    changed = {u.id.original.name_full for u in depsgraph.updates
               if isinstance(u.id, bpy.types.Object) and (u.is_updated_geometry or u.is_updated_transform)}
    if changed:
        update_all(scene, depsgraph, changed)


@persistent
def on_load(_=None):
    _bound.clear()
    problems.clear()


@persistent
def on_undo(_=None):
    """Undo may have changed the shape keys."""
    for bound in _bound.values():
        bound.written = None


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
    on_load()
