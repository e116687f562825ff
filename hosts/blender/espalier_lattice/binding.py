# SPDX-License-Identifier: Apache-2.0
"""Objects that follow a lattice.

A bound object has a shape key of the add-on, named "Espalier" if that is free, whose points following.py computes
whenever the lattice moves. Points x of the object become x + D (q' - q): q are the vertices of the lattice in the
coordinates of the object when it was bound, and q' are the same vertices now. So the object follows if the lattice
moves against it, and stays as it is if both move together.

q and the settings are saved in the .blend file. D is computed again when the file is opened and the lattice
moves for the first time: the same lattice and points give the same D, bit for bit. The file also has hashes of
x and of the cells and creases of the lattice, so that changes after binding are told, not taken.
"""

import hashlib

import bpy
import numpy as np

from . import engine, lattice_object, shape_keys
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

    def count_outside(self):
        return int((np.asarray(self.binding.statuses) != 0).sum())


_bound = {}  # by the name of the object; bound_of() checks that it is still the binding of this object
problems = {}  # name of an object: why it does not follow its lattice


def is_bound(object):
    """Returns True for a bound object, also if its lattice was deleted."""
    return object is not None and object.type == "MESH" and REST in object


def bound_objects(scene=None, lattice=None):
    objects = scene.objects if scene is not None else bpy.data.objects
    return [o for o in objects if is_bound(o) and lattice in (None, o.espalier.lattice)]


def check_lattice(object):
    """Raises a LatticeError if a bound object has no lattice any more. Blender keeps an object that is deleted from all
    scenes while another object refers to it."""
    lattice = object.espalier.lattice
    if lattice is None or not lattice.users_scene:
        raise LatticeError(f"{object.name}: its lattice{' ' + lattice.name if lattice else ''} was deleted; unbind the "
                           "object, or bind it to another lattice")
    if not lattice_object.is_lattice(lattice):
        raise LatticeError(f"{object.name}: {lattice.name} is no lattice any more; unbind the object, or bind it to "
                           "another lattice")


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
    before = object[POINTS].split()[0]
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
    own = object.evaluated_get(depsgraph).matrix_world
    inverse = own.inverted(None)
    if inverse is None:
        raise LatticeError(f"{object.name}: a scale of the object is 0, so that it is flat; give it another scale")
    matrix = np.array(inverse @ lattice.evaluated_get(depsgraph).matrix_world)
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
            shape_keys.give_own_action(object.data.shape_keys)
        forget(object)
    return others


def source_of(object):
    """Returns all that a Bound depends on, as a value to compare. Undo changes it, and so does a new name."""
    settings = object.espalier
    return (bytes(memoryview(object[REST])), object[POINTS], object[TOPOLOGY], settings.level, settings.use_limit,
            settings.outside, settings.falloff, settings.rules)


def bound_of(object):
    """Returns the Bound of an object, which is made if there is none."""
    if not lattice_object.is_lattice(object.espalier.lattice):
        check_lattice(object)
    check_not_shared(object)
    check_unchanged(object)
    found = _bound.get(object.name_full)
    if found is None or found.source != source_of(object):
        found = _bound[object.name_full] = Bound(object)
    return found


def forget(object):
    _bound.pop(object.name_full, None)
    problems.pop(object.name_full, None)


def forget_all():
    _bound.clear()
    problems.clear()


def read_keys_again():
    """Lets the shape keys be read before they are next written."""
    for bound in _bound.values():
        bound.written = None


def pose_of(object, depsgraph):
    """Returns the positions of the lattice of a bound object now, in the coordinates of the object: array (V, 3)."""
    lattice = object.espalier.lattice
    return in_object(object, lattice, lattice_object.posed_positions(lattice, depsgraph), depsgraph)


def posed_points(object, depsgraph):
    """Returns the points of a bound object after its lattice: array (N, 3)."""
    bound, pose = bound_of(object), pose_of(object, depsgraph)
    if len(pose) != len(bound.rest):
        raise LatticeError(f"{object.name}: {object.espalier.lattice.name} has {len(pose)} vertices; it had "
                           f"{len(bound.rest)} when the object was bound: rebind")
    return bound.deform(pose)


def bind(object, lattice, depsgraph):
    """Binds an object, whose mesh no other object has, to a lattice as it is now. Returns the Bound."""
    check_not_shared(object)
    if object.mode == "EDIT" or lattice.mode == "EDIT":
        raise LatticeError("leave edit mode before binding")
    lattice_object.sync(lattice)
    pose = lattice_object.posed_positions(lattice, depsgraph)
    unbind(object)
    object.espalier.lattice = lattice
    object[REST] = in_object(object, lattice, pose, depsgraph).ravel().tolist()
    object[POINTS] = points_text(rest_points(object))
    object[TOPOLOGY] = lattice_object.topology_text(lattice)
    try:
        bound = bound_of(object)
    except Exception:
        clear_properties(object)
        raise
    if object.data.shape_keys is None:
        object.shape_key_add(name="Basis", from_mix=False)
        object.espalier.has_made_basis = True
    key = object.shape_key_add(name=KEY, from_mix=False)
    key.value = 1
    object.espalier.key = key.name
    set_masks(object)
    return bound


def following_key(object):
    """Returns the shape key that follows the lattice; None if there is none."""
    name = object.espalier.key
    return object.data.shape_keys.key_blocks[name] if name and name in shape_keys.names(object) else None


def set_masks(object):
    """Lets what follows the lattice, and what was baked, have the weights of the vertex group. Blender multiplies
    by them, so that painting shows at once."""
    settings = object.espalier
    keys = {settings.key, *(each.name for each in settings.baked_keys)}
    for name in keys & set(shape_keys.names(object)):
        object.data.shape_keys.key_blocks[name].vertex_group = settings.vertex_group
    modifier = object.modifiers.get(settings.cache_modifier) if settings.cache_modifier else None
    if modifier is not None:
        modifier.vertex_group = settings.vertex_group


def remove_baked(object):
    """Removes the shape keys and the modifier that baking has made. Then the object follows its lattice again,
    if baking has made some."""
    settings = object.espalier
    if not settings.baked_keys and not settings.cache_modifier:
        return
    for name in [each.name for each in settings.baked_keys]:
        shape_keys.remove(object, name)
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
        shape_keys.remove(object, settings.key)
        settings.key = ""
    if settings.has_made_basis and len(shape_keys.names(object)) == 1:
        object.shape_key_remove(object.data.shape_keys.key_blocks[0])
    settings.has_made_basis = False
    group = object.vertex_groups.get(OUTSIDE_GROUP)
    if group is not None:
        object.vertex_groups.remove(group)
    clear_properties(object)


def clear_properties(object):
    """Removes the properties that make an object a bound one."""
    object.espalier.lattice = None
    for name in (REST, POINTS, TOPOLOGY):
        if name in object:
            del object[name]


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
