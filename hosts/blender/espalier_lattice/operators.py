# SPDX-License-Identifier: Apache-2.0
"""The operators of the add-on."""

import struct

import bpy
import numpy as np
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import binding, engine, lattice_object, make
from .lattice_object import LatticeError

FOLDED = "Espalier folded"
FILE_FILTER = "*.vtu;*.vtk;*.ovm"


class EspalierOperator:
    """Turns the add-on's errors into reports."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            return self.run(context)
        except (LatticeError, ImportError, ValueError, MemoryError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    def give_own_meshes(self, objects):
        """Gives each object a mesh of its own, and reports the objects whose mesh was shared."""
        for object in objects:
            others = binding.give_own_mesh(object)
            if others:
                self.report({"INFO"}, f"{object.name} shared its mesh with {', '.join(others)}; it has a copy of "
                                      "its own now")


def selected_meshes(context):
    return [o for o in context.selected_objects
            if o.type == "MESH" and not lattice_object.is_lattice(o)]


def object_mode(context):
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


class AddLattice(EspalierOperator, bpy.types.Operator):
    """Add a lattice around the selected objects"""

    bl_idname = "espalier.add_lattice"
    bl_label = "Espalier Lattice"

    kind: bpy.props.EnumProperty(name="Kind", items=make.KINDS, default="BOX")
    cells: bpy.props.IntProperty(name="Cells", min=1, max=64, default=3,
                                 description="Cells along the longest side of a box")
    vertices: bpy.props.IntProperty(name="Vertices", min=8, max=100000, soft_max=2000, default=200,
                                    description="About the number of vertices of a cage; with more of them, it "
                                                "follows the objects more closely")
    margin: bpy.props.FloatProperty(name="Margin", min=0, max=2, default=0.05,
                                    description="Distance from the objects to the sides of the lattice, as a "
                                                "fraction of their size")
    bind: bpy.props.BoolProperty(name="Bind", default=True,
                                 description="Bind the selected objects to the lattice")

    def draw(self, context):
        column = self.layout.column()
        column.prop(self, "kind")
        if self.kind in ("BOX", "CAGE"):
            column.prop(self, "cells" if self.kind == "BOX" else "vertices")
        column.prop(self, "margin")
        column.prop(self, "bind")

    def run(self, context):
        espalier = engine.load()
        object_mode(context)
        depsgraph = context.evaluated_depsgraph_get()
        objects = selected_meshes(context)
        model = make.model_of(objects, depsgraph, with_rest=self.bind)
        lattice = make.around(espalier, self.kind, model, self.cells, self.vertices, self.margin)
        added = lattice_object.object_of(lattice, "Espalier " + self.kind.lower(), context.collection)
        if self.bind:
            self.give_own_meshes(objects)
        context.view_layer.update()
        depsgraph = context.evaluated_depsgraph_get()
        outside = 0
        for object in objects if self.bind else ():
            bound = binding.bind(object, added, depsgraph)
            outside += int((np.asarray(bound.binding.statuses) != 0).sum())
        for object in context.selected_objects:
            object.select_set(False)
        added.select_set(True)
        context.view_layer.objects.active = added
        self.report({"WARNING" if outside else "INFO"},
                    f"{added.name}: {len(lattice.cells)} cells, {len(objects) if self.bind else 0} objects "
                    f"bound, {outside} points outside")
        return {"FINISHED"}


class MakeLattice(EspalierOperator, bpy.types.Operator):
    """Make a lattice of the active mesh: its parts that are closed become cells"""

    bl_idname = "espalier.make_lattice"
    bl_label = "Make Lattice of Mesh"

    def run(self, context):
        object_mode(context)
        object = context.active_object
        if object is None or object.type != "MESH" or lattice_object.is_lattice(object):
            raise LatticeError("select a mesh that is no lattice yet")
        mesh = object.data
        cells = closed_parts(mesh)
        if not cells:
            raise LatticeError(f"{object.name}: no part of the mesh is closed, with each edge in two faces")
        lattice_object.set_vertex_ids(mesh, list(range(1, len(mesh.vertices) + 1)))
        mesh[lattice_object.CELLS] = lattice_object.topology.pack(
            [[[v + 1 for v in loop] for loop in cell] for cell in cells])
        lattice_object.lattice_of(object, engine.load())
        object.display_type = "WIRE"
        object.hide_render = True
        self.report({"INFO"}, f"{object.name}: {len(cells)} cells")
        return {"FINISHED"}


def closed_parts(mesh):
    """Returns the faces of each part of a mesh that is joined by edges, if each edge is in two faces."""
    parents = list(range(len(mesh.polygons)))

    def root(face):
        while parents[face] != face:
            parents[face] = parents[parents[face]]
            face = parents[face]
        return face

    faces_of = {}
    for polygon in mesh.polygons:
        for key in polygon.edge_keys:
            faces_of.setdefault(key, []).append(polygon.index)
    closed = True
    for faces in faces_of.values():
        closed = closed and len(faces) == 2
        for face in faces[1:]:
            parents[root(face)] = root(faces[0])
    if not closed:
        return []
    parts = {}
    for polygon in mesh.polygons:
        parts.setdefault(root(polygon.index), []).append(list(polygon.vertices))
    return list(parts.values())


class Bind(EspalierOperator, bpy.types.Operator):
    """Bind the selected objects to the active lattice as it is now"""

    bl_idname = "espalier.bind"
    bl_label = "Bind"

    def run(self, context):
        object_mode(context)
        lattice = context.active_object
        if not lattice_object.is_lattice(lattice):
            raise LatticeError("select the objects, and last the lattice")
        objects = selected_meshes(context)
        if not objects:
            raise LatticeError("select objects to bind, and last the lattice")
        self.give_own_meshes(objects)
        depsgraph = context.evaluated_depsgraph_get()
        outside = points = 0
        for object in objects:
            bound = binding.bind(object, lattice, depsgraph)
            outside += int((np.asarray(bound.binding.statuses) != 0).sum())
            points += len(bound.points)
        self.report({"WARNING" if outside else "INFO"},
                    f"{len(objects)} objects bound to {lattice.name}; {outside} of {points} points outside")
        return {"FINISHED"}


def bound_selection(context):
    """Returns the bound objects that are selected, and those of selected lattices."""
    selected = list(context.selected_objects)
    objects = [o for o in selected if binding.is_bound(o)]
    for lattice in selected:
        if lattice_object.is_lattice(lattice):
            objects += [o for o in binding.bound_objects(lattice=lattice) if o not in objects]
    if not objects:
        raise LatticeError("select bound objects, or their lattice")
    return objects


class Rebind(EspalierOperator, bpy.types.Operator):
    """Bind again: the lattice as it is now becomes the rest of the selected bound objects"""

    bl_idname = "espalier.rebind"
    bl_label = "Rebind"

    def run(self, context):
        object_mode(context)
        objects = bound_selection(context)
        self.give_own_meshes(objects)
        for object in objects:
            binding.bind(object, object.espalier.lattice, context.evaluated_depsgraph_get())
        self.report({"INFO"}, f"{len(objects)} objects bound again")
        return {"FINISHED"}


class Unbind(EspalierOperator, bpy.types.Operator):
    """Unbind the selected objects, which return to their shape at rest"""

    bl_idname = "espalier.unbind"
    bl_label = "Unbind"

    def run(self, context):
        object_mode(context)
        objects = bound_selection(context)
        self.give_own_meshes(objects)
        for object in objects:
            binding.unbind(object)
        self.report({"INFO"}, f"{len(objects)} objects unbound")
        return {"FINISHED"}


class MarkOutside(EspalierOperator, bpy.types.Operator):
    """Make a vertex group of the points outside the lattice"""

    bl_idname = "espalier.mark_outside"
    bl_label = "Points Outside"

    def run(self, context):
        object_mode(context)
        counts = {o.name: binding.mark_outside(o) for o in bound_selection(context)}
        self.report({"INFO"}, ", ".join(f"{name}: {count} points outside" for name, count in counts.items()))
        return {"FINISHED"}


class MarkFolded(EspalierOperator, bpy.types.Operator):
    """Select the faces of the cells that the pose turns inside out, and color them"""

    bl_idname = "espalier.mark_folded"
    bl_label = "Folded Cells"

    level: bpy.props.IntProperty(name="Level", min=1, max=6, default=2,
                                 description="Level whose cells are checked")

    def run(self, context):
        espalier = engine.load()
        object_mode(context)
        lattice = context.active_object
        if not lattice_object.is_lattice(lattice):
            raise LatticeError("select a lattice")
        objects = binding.bound_objects(lattice=lattice)
        if not objects:
            raise LatticeError(f"{lattice.name}: no object is bound to it, so it has no shape at rest")
        depsgraph = context.evaluated_depsgraph_get()
        rest = binding.bound_of(objects[0]).rest
        pose = binding.in_object(objects[0], lattice, lattice_object.posed_positions(lattice, depsgraph),
                                 depsgraph)
        folded = binding.folded_cells(lattice, rest, self.level, espalier, pose)
        mark_cells(lattice, folded)
        self.report({"WARNING" if folded else "INFO"}, f"{lattice.name}: {len(folded)} cells folded")
        return {"FINISHED"}


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
    group = lattice.vertex_groups.get(FOLDED)
    if group is not None:
        lattice.vertex_groups.remove(group)
    if vertices:
        lattice.vertex_groups.new(name=FOLDED).add(vertices, 1.0, "REPLACE")
    attribute = mesh.attributes.get(FOLDED)
    if attribute is None:
        attribute = mesh.attributes.new(FOLDED, "FLOAT_COLOR", "CORNER")
    colors = np.tile(np.array([0.8, 0.8, 0.8, 1], dtype=np.float32), (len(mesh.loops), 1))
    for polygon, marked in zip(mesh.polygons, is_marked):
        if marked:
            colors[polygon.loop_start:polygon.loop_start + polygon.loop_total] = (1, 0.1, 0.05, 1)
    attribute.data.foreach_set("color", colors.ravel())
    mesh.update()


class UpdateCells(EspalierOperator, bpy.types.Operator):
    """Make cells of the faces that were extruded, and tell which cells could not be kept"""

    bl_idname = "espalier.update_cells"
    bl_label = "Update Cells"

    def run(self, context):
        lattice = context.active_object
        if not lattice_object.is_lattice(lattice):
            raise LatticeError("select a lattice")
        mode = lattice.mode
        object_mode(context)
        result = lattice_object.sync(lattice)
        changed = [o for o in binding.bound_objects(lattice=lattice)
                   if lattice_object.topology_change(lattice, o[binding.TOPOLOGY])]
        if mode == "EDIT":
            bpy.ops.object.mode_set(mode="EDIT")
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
        return {"FINISHED"}


class ExtrudeCell(EspalierOperator, bpy.types.Operator):
    """Extrude the selected faces of the boundary along their normals into new cells"""

    bl_idname = "espalier.extrude_cell"
    bl_label = "Extrude Cells"

    distance: bpy.props.FloatProperty(name="Distance", default=1.0, unit="LENGTH")

    def run(self, context):
        import bmesh
        lattice = context.active_object
        if not lattice_object.is_lattice(lattice):
            raise LatticeError("select a lattice")
        mode = lattice.mode
        object_mode(context)
        mesh = lattice.data
        result = lattice_object.sync(lattice)
        boundary = {lattice_object.topology.key_of(loop): loop
                    for loop in lattice_object.topology.boundary_faces(result.cells)}
        chosen = [p for p in mesh.polygons if p.select]
        if not chosen:
            raise LatticeError(f"{lattice.name}: select faces of the boundary in edit mode")
        for polygon in chosen:
            if lattice_object.topology.key_of(polygon.vertices) not in boundary:
                raise LatticeError(f"{lattice.name}: face {polygon.index} is between two cells; only faces of "
                                   "the boundary can be extruded")
        owner = {}
        for cell in result.cells:
            middle = np.mean([mesh.vertices[v].co for loop in cell for v in loop], axis=0)
            for loop in cell:
                owner[lattice_object.topology.key_of(loop)] = middle
        normal = np.zeros(3)
        for polygon in chosen:
            outward = np.array(polygon.center) - owner[lattice_object.topology.key_of(polygon.vertices)]
            direction = np.array(polygon.normal)
            normal += direction * polygon.area * (1 if direction @ outward >= 0 else -1)
        size = np.linalg.norm(normal)
        normal = normal / size if size > 0 else np.array([0, 0, 1.0])
        editable = bmesh.new()
        editable.from_mesh(mesh)
        editable.faces.ensure_lookup_table()
        faces = [editable.faces[p.index] for p in chosen]
        made = bmesh.ops.extrude_face_region(editable, geom=faces, use_keep_orig=True)
        vertices = [v for v in made["geom"] if isinstance(v, bmesh.types.BMVert)]
        bmesh.ops.translate(editable, verts=vertices, vec=(normal * self.distance).tolist())
        for face in editable.faces:
            face.select_set(False)
        for face in made["geom"]:
            if isinstance(face, bmesh.types.BMFace):
                face.select_set(True)
        editable.to_mesh(mesh)
        editable.free()
        mesh.update()
        result = lattice_object.sync(lattice)
        if mode == "EDIT":
            bpy.ops.object.mode_set(mode="EDIT")
        self.report({"INFO"}, f"{lattice.name}: {result.new_cells} new cells; rebind the objects")
        return {"FINISHED"}


def frames_of(operator, context):
    scene = context.scene
    first, last = operator.first, operator.last
    if operator.use_scene_range:
        first, last = scene.frame_start, scene.frame_end
    if last < first:
        raise LatticeError(f"the last frame, {last}, is before the first, {first}")
    return range(first, last + 1, operator.step)


def bake(context, objects, frames, take):
    """Calls take(object, frame, points) for each object in each frame. Returns to the current frame. What was
    baked before is removed first."""
    scene = context.scene
    for object in objects:
        binding.remove_baked(object)
    before = scene.frame_current
    try:
        for frame in frames:
            scene.frame_set(frame)
            depsgraph = context.evaluated_depsgraph_get()
            for object in objects:
                lattice = object.espalier.lattice
                pose = lattice_object.posed_positions(lattice, depsgraph)
                bound = binding.bound_of(object)
                take(object, frame, bound.deform(binding.in_object(object, lattice, pose, depsgraph)))
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
        object_mode(context)
        objects = bound_selection(context)
        self.give_own_meshes(objects)
        frames = frames_of(self, context)

        def take(object, frame, points):
            key = object.shape_key_add(name=f"{binding.KEY} {frame}", from_mix=False)
            object.espalier.baked_keys.add().name = key.name
            key.vertex_group = object.espalier.vertex_group
            key.data.foreach_set("co", points.astype(np.float32).ravel())
            for other, value in ((frame - self.step, 0.0), (frame, 1.0), (frame + self.step, 0.0)):
                if other in frames or other == frame:
                    key.value = value
                    key.keyframe_insert("value", frame=other)
            for curve in binding.key_curves(object.data.shape_keys, key.name):
                for point in curve.keyframe_points:
                    point.interpolation = "LINEAR"

        bake(context, objects, frames, take)
        context.scene.frame_set(context.scene.frame_current)
        self.report({"INFO"}, f"{len(frames)} shape keys for each of {len(objects)} objects")
        return {"FINISHED"}


class BakePointCache(BakeBase, ExportHelper, bpy.types.Operator):
    """Write the points of the active object in each frame to a point cache (.pc2), and play it"""

    bl_idname = "espalier.bake_point_cache"
    bl_label = "Bake to Point Cache"

    filename_ext = ".pc2"
    filter_glob: bpy.props.StringProperty(default="*.pc2", options={"HIDDEN"})

    def run(self, context):
        object_mode(context)
        object = context.active_object
        if not binding.is_bound(object):
            raise LatticeError("select a bound object")
        self.give_own_meshes([object])
        frames = frames_of(self, context)
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
        return {"FINISHED"}


class FollowAgain(EspalierOperator, bpy.types.Operator):
    """Remove what was baked, and follow the lattice again"""

    bl_idname = "espalier.follow_again"
    bl_label = "Follow Again"

    def run(self, context):
        object_mode(context)
        objects = bound_selection(context)
        self.give_own_meshes(objects)
        for object in objects:
            binding.remove_baked(object)
            object.espalier.is_live = True
            binding.update(object, context.evaluated_depsgraph_get())
        return {"FINISHED"}


class ImportLattice(EspalierOperator, ImportHelper, bpy.types.Operator):
    """Import a lattice"""

    bl_idname = "espalier.import_lattice"
    bl_label = "Import Espalier Lattice"

    filename_ext = ".vtu"
    filter_glob: bpy.props.StringProperty(default=FILE_FILTER, options={"HIDDEN"})

    def run(self, context):
        espalier = engine.load()
        object_mode(context)
        lattice = espalier.read(self.filepath)
        name = bpy.path.display_name_from_filepath(self.filepath)
        added = lattice_object.object_of(lattice, name, context.collection)
        for object in context.selected_objects:
            object.select_set(False)
        added.select_set(True)
        context.view_layer.objects.active = added
        dropped = [*lattice.attributes, *lattice.integers]
        if lattice.vertex_sharpness:
            dropped.append("sharpness of vertices")
        self.report({"WARNING" if dropped else "INFO"}, f"{name}: {len(lattice.cells)} cells"
                    + (f"; a mesh cannot hold: {', '.join(dropped)}" if dropped else ""))
        return {"FINISHED"}


class ExportLattice(EspalierOperator, ExportHelper, bpy.types.Operator):
    """Export the active lattice as it is posed now, in its own coordinates"""

    bl_idname = "espalier.export_lattice"
    bl_label = "Export Espalier Lattice"

    filename_ext = ".vtu"
    check_extension = None
    filter_glob: bpy.props.StringProperty(default=FILE_FILTER, options={"HIDDEN"})

    def run(self, context):
        espalier = engine.load()
        lattice = context.active_object
        if not lattice_object.is_lattice(lattice):
            raise LatticeError("select a lattice")
        object_mode(context)
        lattice_object.sync(lattice)
        positions = lattice_object.posed_positions(lattice, context.evaluated_depsgraph_get())
        lattice_object.lattice_of(lattice, espalier, positions).write(self.filepath)
        self.report({"INFO"}, f"{self.filepath}: {len(positions)} vertices")
        return {"FINISHED"}


CLASSES = (AddLattice, MakeLattice, Bind, Rebind, Unbind, MarkOutside, MarkFolded, UpdateCells, ExtrudeCell,
           BakeShapeKeys, BakePointCache, FollowAgain, ImportLattice, ExportLattice)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister():
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
