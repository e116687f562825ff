# SPDX-License-Identifier: Apache-2.0
"""Lattices as Blender objects.

The mesh of a lattice has its vertices in their order, and each face once, interior ones too. The cells are
in the property `espalier_cells` of the mesh, as topology.pack() writes them, by the ids of the vertices,
which are in the attribute `espalier_id`. All of this is saved in the .blend file, and copied with the mesh.
"""

import hashlib

import bpy
import numpy as np

from . import topology

CELLS = "espalier_cells"
IDS = "espalier_id"


class LatticeError(Exception):
    """A lattice object cannot be used. The message says why, and what to do."""


class NotEvaluated(LatticeError):
    """The depsgraph does not contain the lattice."""


def is_lattice(object):
    return object is not None and object.type == "MESH" and CELLS in object.data


def check_local(object):
    """Raises a LatticeError if an object or its mesh is linked from a library, because Blender does not let such data
    be changed."""
    for each in (object, object.data):
        if each is not None and each.library is not None:
            raise LatticeError(f"{each.name} is linked from {each.library.filepath}, so that it cannot be changed; choose "
                               "Object, Relations, Make Local, All first")


def attribute_of(mesh, name, type, domain):
    """Returns the attribute of a mesh with a name, a type and a domain, which is made if there is none."""
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.data_type != type or attribute.domain != domain):
        mesh.attributes.remove(attribute)
        attribute = None
    attribute = attribute or mesh.attributes.new(name, type, domain)
    if attribute is None:  # Blender prints why.
        raise LatticeError(f"{mesh.name}: Blender cannot make the attribute {name}; rename what has this name, such as "
                           "a vertex group")
    return attribute


def vertex_ids(mesh):
    """Returns the ids of the vertices of a lattice's mesh, 0 for vertices without one: list of V numbers."""
    attribute = mesh.attributes.get(IDS)
    ids = np.zeros(len(mesh.vertices), dtype=np.int32)
    if attribute is not None and attribute.domain == "POINT":
        if len(attribute.data) != len(ids):  # Blender hides attributes in edit mode.
            raise LatticeError(f"{mesh.name}: leave the edit mode of the lattice")
        attribute.data.foreach_get("value", ids)
    return ids.tolist()


def set_vertex_ids(mesh, ids):
    """Gives the vertices of a mesh their ids: V numbers above 0, all different."""
    attribute = attribute_of(mesh, IDS, "INT", "POINT")
    attribute.data.foreach_set("value", np.asarray(ids, dtype=np.int32))


def base_positions(mesh):
    """Returns the positions of the vertices of a mesh: array (V, 3)."""
    positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3).astype(np.float64)


def creases(mesh):
    """Returns the crease of each edge, from 0 to 1: array (E,)."""
    values = np.zeros(len(mesh.edges), dtype=np.float32)
    attribute = mesh.attributes.get("crease_edge")  # Since Blender 4.0.
    if attribute is not None:
        attribute.data.foreach_get("value", values)
    elif bpy.app.version < (4, 0, 0):
        mesh.edges.foreach_get("crease", values)
    return values


def set_creases(mesh, values):
    values = np.asarray(values, dtype=np.float32)
    if bpy.app.version < (4, 0, 0):
        mesh.edges.foreach_set("crease", values)
        return
    attribute = attribute_of(mesh, "crease_edge", "FLOAT", "EDGE")
    attribute.data.foreach_set("value", values)


def sharpness_of_crease(crease):
    """A crease of 1 is infinitely sharp; below, Blender subdivides by a sharpness of ten times the crease."""
    return float("inf") if crease >= 1 else 10 * float(crease)


def crease_of_sharpness(sharpness):
    return min(1.0, sharpness / 10)


def mesh_of(lattice, name):
    """Makes a mesh of a lattice of Espalier."""
    mesh = bpy.data.meshes.new(name)
    cells = [[list(map(int, loop)) for loop in cell] for cell in lattice.cells]
    faces = topology.all_faces(cells)
    mesh.from_pydata([tuple(p) for p in lattice.positions], [], faces)
    mesh.update()
    ids = list(range(1, len(mesh.vertices) + 1))
    set_vertex_ids(mesh, ids)
    mesh[CELLS] = topology.pack([[[v + 1 for v in loop] for loop in cell] for cell in cells])
    if lattice.edge_sharpness:
        number = {frozenset(edge.vertices): i for i, edge in enumerate(mesh.edges)}
        values = np.zeros(len(mesh.edges))
        for edge, sharpness in lattice.edge_sharpness.items():
            values[number[frozenset(edge)]] = crease_of_sharpness(sharpness)
        set_creases(mesh, values)
    return mesh


def object_of(lattice, name, collection):
    """Makes a lattice object."""
    object = bpy.data.objects.new(name, mesh_of(lattice, name))
    draw_edges(object)
    collection.objects.link(object)
    return object


def draw_edges(object):
    """Lets the viewport draw the edges of a lattice, and renders nothing of it; see evaluation.py."""
    object.display_type = "WIRE"
    object.show_all_edges = True
    object.hide_render = True


def make_lattice(object, cells, espalier):
    """Makes a mesh object a lattice. cells: loops of vertices. Raises a LatticeError, and leaves the object as it was, if
    they make no lattice."""
    mesh = object.data
    set_vertex_ids(mesh, list(range(1, len(mesh.vertices) + 1)))
    mesh[CELLS] = topology.pack([[[v + 1 for v in loop] for loop in cell] for cell in cells])
    try:
        lattice_of(object, espalier)
    except LatticeError:
        del mesh[CELLS]
        mesh.attributes.remove(mesh.attributes[IDS])
        raise
    draw_edges(object)


def sync(object):
    """Brings the cells up to date with the edited mesh. Adds faces that extruding has removed. Returns the
    topology.Sync. The object must not be in edit mode."""
    mesh = object.data
    packed, ids = list(mesh[CELLS]), vertex_ids(mesh)
    result = topology.Sync(topology.unpack(packed), ids, [list(p.vertices) for p in mesh.polygons],
                           [tuple(e.vertices) for e in mesh.edges])
    if result.new_faces:
        _add_faces(mesh, result.new_faces)
    if result.ids != ids:
        set_vertex_ids(mesh, result.ids)
    now = topology.pack([[[result.ids[v] for v in loop] for loop in cell] for cell in result.cells])
    if now != packed:
        mesh[CELLS] = now
    return result


def _add_faces(mesh, loops):
    import bmesh
    editable = bmesh.new()
    editable.from_mesh(mesh)
    editable.verts.ensure_lookup_table()
    for loop in loops:
        editable.faces.new([editable.verts[v] for v in loop])
    editable.to_mesh(mesh)
    editable.free()
    mesh.update()


def lattice_of(object, espalier, positions=None, use_creases=True):
    """Returns the lattice of Espalier that an object is.

    positions: array (V, 3) in place of the positions of its mesh. Raises a LatticeError if the mesh was
    edited so that no cell is left, or has vertices without a cell."""
    mesh = object.data
    vertex_of = {number: vertex for vertex, number in enumerate(vertex_ids(mesh))}
    try:
        cells = [[[vertex_of[number] for number in loop] for loop in cell]
                 for cell in topology.unpack(mesh[CELLS])]
    except KeyError:
        raise LatticeError(f"{object.name}: vertices of cells were deleted; run Update Cells") from None
    if not cells:
        raise LatticeError(f"{object.name}: there is no cell left")
    used = {v for cell in cells for loop in cell for v in loop}
    if len(used) != len(mesh.vertices):
        unused = sorted(set(range(len(mesh.vertices))) - used)
        raise LatticeError(f"{object.name}: {len(unused)} vertices belong to no cell, the first one vertex "
                           f"{unused[0]}; run Update Cells, or delete them")
    sharp = {}
    if use_creases:
        values = creases(mesh)
        for i in np.nonzero(values > 0)[0]:
            sharp[tuple(mesh.edges[int(i)].vertices)] = sharpness_of_crease(values[i])
    if positions is None:
        positions = base_positions(mesh)
    try:
        lattice = espalier.Lattice(positions, cells)
        if sharp:
            edges = {frozenset(map(int, edge)) for edge in lattice.edges}
            sharp = {edge: value for edge, value in sharp.items() if frozenset(edge) in edges}
            lattice = lattice.with_marks(edge_sharpness=sharp)
        return lattice
    except ValueError as error:
        raise LatticeError(f"{object.name}: {error}") from None


def topology_text(object):
    """Returns three words: the number of vertices, a hash of the cells and a hash of the creases."""
    if not is_lattice(object):
        raise LatticeError(f"{object.name} is no lattice any more")
    mesh = object.data
    cells = hashlib.sha256(np.asarray(mesh[CELLS], dtype=np.int64).tobytes())
    cells.update(np.asarray(vertex_ids(mesh), dtype=np.int64).tobytes())
    sharp = hashlib.sha256(creases(mesh).tobytes())
    return f"{len(mesh.vertices)} {cells.hexdigest()[:24]} {sharp.hexdigest()[:24]}"


def topology_change(object, before):
    """Returns what has changed since topology_text() was `before`, as a sentence; "" if nothing has."""
    now = topology_text(object)
    if now == before:
        return ""
    if now.split()[:2] == before.split()[:2]:
        return f"the creases of {object.name} have changed"
    return f"the cells of {object.name} have changed"


def posed_positions(object, depsgraph):
    """Returns the positions of a lattice with all its shape keys, modifiers and edits: array (V, 3), in its
    own coordinates. Raises a LatticeError if a modifier changes the number of vertices, and NotEvaluated if
    the depsgraph does not evaluate the lattice."""
    if object.mode == "EDIT":
        import bmesh
        editable = bmesh.from_edit_mesh(object.data)
        positions = np.array([v.co for v in editable.verts], dtype=np.float64).reshape(-1, 3)
    else:
        evaluated = object.evaluated_get(depsgraph)
        if not evaluated.is_evaluated:
            raise NotEvaluated(f"{object.name} is not in this view layer; put it into a collection of the view layer")
        positions = base_positions(evaluated.data)
    if len(positions) != len(object.data.vertices) and object.mode != "EDIT":
        raise LatticeError(f"{object.name}: its modifiers change the number of vertices; remove modifiers "
                           "such as Subdivision Surface from the lattice")
    return positions
