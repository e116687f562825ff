# SPDX-License-Identifier: Apache-2.0
"""Operators that check and edit the cells of a lattice."""

import bpy
import numpy as np

from . import binding, engine, lattice_object
from .lattice_object import LatticeError
from .op_base import EspalierOperator, active_lattice

# The names differ, because a mesh cannot have an attribute with the name of a vertex group.
FOLDED_GROUP = "Espalier folded"
FOLDED_COLOR = "Espalier folded color"


class MarkFolded(EspalierOperator, bpy.types.Operator):
    """Select the faces of the cells that the pose turns inside out, and color them"""

    bl_idname = "espalier.mark_folded"
    bl_label = "Folded Cells"

    level: bpy.props.IntProperty(name="Level", min=1, max=6, default=2,
                                 description="Level whose cells are checked")

    def run(self, context):
        espalier = engine.load()
        lattice = active_lattice(context)
        objects = binding.bound_objects(lattice=lattice)
        if not objects:
            raise LatticeError(f"{lattice.name}: no object is bound to it, so it has no shape at rest; bind one")
        depsgraph = context.evaluated_depsgraph_get()
        rest = binding.bound_of(objects[0]).rest
        pose = binding.pose_of(objects[0], depsgraph)
        folded = binding.folded_cells(lattice, rest, self.level, espalier, pose)
        mark_cells(lattice, folded)
        self.report({"WARNING" if folded else "INFO"}, f"{lattice.name}: {len(folded)} cells folded")


def mark_cells(lattice, cells):
    """Selects the faces of cells, puts their vertices into a group, and colors them red."""
    mesh = lattice.data
    topology = lattice_object.topology
    vertex_of = {number: v for v, number in enumerate(lattice_object.vertex_ids(mesh))}
    stored = topology.unpack(mesh[lattice_object.CELLS])
    keys = {topology.key_of([vertex_of[n] for n in loop]) for cell in cells for loop in stored[cell]}
    vertices = sorted(set().union(*keys)) if keys else []
    is_marked = [topology.key_of(p.vertices) in keys for p in mesh.polygons]
    mesh.vertices.foreach_set("select", [False] * len(mesh.vertices))
    mesh.edges.foreach_set("select", [False] * len(mesh.edges))
    mesh.polygons.foreach_set("select", is_marked)
    for polygon in mesh.polygons:
        if polygon.select:
            for vertex in polygon.vertices:
                mesh.vertices[vertex].select = True
    group = lattice.vertex_groups.get(FOLDED_GROUP)
    if group is not None:
        lattice.vertex_groups.remove(group)
    if vertices:
        lattice.vertex_groups.new(name=FOLDED_GROUP).add(vertices, 1.0, "REPLACE")
    colors = np.tile(np.array([0.8, 0.8, 0.8, 1], dtype=np.float32), (len(mesh.loops), 1))
    for polygon, marked in zip(mesh.polygons, is_marked):
        if marked:
            colors[polygon.loop_start:polygon.loop_start + polygon.loop_total] = (1, 0.1, 0.05, 1)
    attribute = lattice_object.attribute_of(mesh, FOLDED_COLOR, "FLOAT_COLOR", "CORNER")
    attribute.data.foreach_set("color", colors.ravel())
    mesh.update()


class UpdateCells(EspalierOperator, bpy.types.Operator):
    """Make cells of the faces that were extruded, and tell which cells could not be kept"""

    bl_idname = "espalier.update_cells"
    bl_label = "Update Cells"

    def run(self, context):
        lattice = active_lattice(context)
        result = lattice_object.sync(lattice)
        changed = [o for o in binding.bound_objects(lattice=lattice)
                   if lattice_object.topology_change(lattice, o[binding.TOPOLOGY])]
        parts = [f"{len(result.cells)} cells"]
        if result.new_cells:
            parts.append(f"{result.new_cells} of them new")
        if result.loose:
            parts.append(f"{result.loose} faces belong to no cell")
        self.report({"WARNING" if result.lost or result.loose else "INFO"},
                    f"{lattice.name}: " + ", ".join(parts)
                    + "".join(f"; {sentence}" for sentence in result.lost[:5])
                    + (f"; and {len(result.lost) - 5} more" if len(result.lost) > 5 else ""))
        if changed:
            self.report({"WARNING"}, f"rebind: {', '.join(o.name for o in changed)}")


class ExtrudeCell(EspalierOperator, bpy.types.Operator):
    """Extrude the selected faces of the boundary along their normals into new cells"""

    bl_idname = "espalier.extrude_cell"
    bl_label = "Extrude Cells"

    distance: bpy.props.FloatProperty(name="Distance", default=1.0, unit="LENGTH")

    def run(self, context):
        lattice = active_lattice(context)
        result = lattice_object.sync(lattice)
        chosen = [p for p in lattice.data.polygons if p.select]
        if not chosen:
            raise LatticeError(f"{lattice.name}: select faces of the boundary in edit mode")
        boundary = {lattice_object.topology.key_of(loop)
                    for loop in lattice_object.topology.boundary_faces(result.cells)}
        for polygon in chosen:
            if lattice_object.topology.key_of(polygon.vertices) not in boundary:
                raise LatticeError(f"{lattice.name}: face {polygon.index} is between two cells; only faces of "
                                   "the boundary can be extruded")
        extrude(lattice.data, chosen, self.distance * outward(lattice.data, chosen, result.cells))
        result = lattice_object.sync(lattice)
        self.report({"INFO"}, f"{lattice.name}: {result.new_cells} new cells; rebind the objects")


def outward(mesh, faces, cells):
    """Returns the mean normal of faces of the boundary, which points out of their cells: array (3,)."""
    key_of = lattice_object.topology.key_of
    middle_of = {}
    for cell in cells:
        middle = np.mean([mesh.vertices[v].co for loop in cell for v in loop], axis=0)
        for loop in cell:
            middle_of[key_of(loop)] = middle
    normal = np.zeros(3)
    for polygon in faces:
        direction = np.array(polygon.normal)
        is_outward = direction @ (np.array(polygon.center) - middle_of[key_of(polygon.vertices)]) >= 0
        normal += direction * polygon.area * (1 if is_outward else -1)
    size = np.linalg.norm(normal)
    return normal / size if size > 0 else np.array([0, 0, 1.0])


def extrude(mesh, faces, move):
    """Extrudes faces of a mesh, which stay, and selects the new ones."""
    import bmesh
    editable = bmesh.new()
    editable.from_mesh(mesh)
    editable.faces.ensure_lookup_table()
    made = bmesh.ops.extrude_face_region(editable, geom=[editable.faces[p.index] for p in faces],
                                         use_keep_orig=True)
    vertices = [v for v in made["geom"] if isinstance(v, bmesh.types.BMVert)]
    bmesh.ops.translate(editable, verts=vertices, vec=move.tolist())
    for face in editable.faces:
        face.select_set(False)
    for face in made["geom"]:
        if isinstance(face, bmesh.types.BMFace):
            face.select_set(True)
    editable.to_mesh(mesh)
    editable.free()
    mesh.update()
