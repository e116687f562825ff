# SPDX-License-Identifier: Apache-2.0
"""Operators that add lattices: around objects, of a mesh, from a file; and the one that writes a file."""

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import axes, binding, engine, evaluation, lattice_object, make, shape_keys
from .lattice_object import LatticeError
from .op_base import EspalierOperator, active_lattice, report_bound, select_only, selected_meshes

FILE_FILTER = "*.vtu;*.vtk;*.ovm"


class AddLattice(EspalierOperator, bpy.types.Operator):
    """Add a lattice around the selected objects"""

    bl_idname = "espalier.add_lattice"
    bl_label = "Espalier Lattice"

    kind: bpy.props.EnumProperty(name="Kind", items=make.KINDS, default="BOX")
    # tests/docs/defaults_test.py compares these defaults with the defaults of the library.
    cells: bpy.props.IntProperty(name="Cells", min=1, max=64, default=4,
                                 description="Cells along the longest side of a box")
    vertices: bpy.props.IntProperty(name="Vertices", min=8, max=100000, soft_max=2000, default=200,
                                    description="About the number of vertices of a cage; with more of them, it "
                                                "follows the objects more closely")
    margin: bpy.props.FloatProperty(name="Margin", min=0, max=2, default=0.05,
                                    description="Distance from the objects to the sides of the lattice, as a "
                                                "fraction of their size")
    cage_margin: bpy.props.FloatProperty(name="Margin", min=0, max=1, default=0,
                                         description="Least distance from the objects to the boundary of a cage, as "
                                                     "a fraction of their size")
    bind: bpy.props.BoolProperty(name="Bind", default=True,
                                 description="Bind the selected objects to the lattice")

    def draw(self, context):
        column = self.layout.column()
        column.prop(self, "kind")
        if self.kind in ("BOX", "CAGE"):
            column.prop(self, "cells" if self.kind == "BOX" else "vertices")
        column.prop(self, "cage_margin" if self.kind == "CAGE" else "margin")
        column.prop(self, "bind")

    def run(self, context):
        espalier = engine.load()
        objects = selected_meshes(context)
        bound = objects if self.bind else []
        for object in bound:
            lattice_object.check_local(object)
        model = make.model_of(objects, context.evaluated_depsgraph_get(), with_rest=self.bind)
        margin = self.cage_margin if self.kind == "CAGE" else self.margin
        lattice = make.around(espalier, self.kind, model, self.cells, self.vertices, margin)
        added = lattice_object.object_of(lattice, "Espalier " + self.kind.lower(), context.collection)
        self.give_own_meshes(bound)
        context.view_layer.update()
        depsgraph = context.evaluated_depsgraph_get()
        try:
            bounds = [binding.bind(object, added, depsgraph) for object in bound]
        except Exception:
            for object in binding.bound_objects(lattice=added):
                binding.unbind(object)
            bpy.data.meshes.remove(added.data)  # and the object with it
            raise
        evaluation.keep(context.scene)
        select_only(context, added)
        report_bound(self, bounds, f"{added.name}: {len(lattice.cells)} cells, {len(bound)} objects bound")


class MakeLattice(EspalierOperator, bpy.types.Operator):
    """Make a lattice of the active mesh: its parts that are closed become cells"""

    bl_idname = "espalier.make_lattice"
    bl_label = "Make Lattice of Mesh"

    def run(self, context):
        espalier = engine.load()
        object = context.view_layer.objects.active
        if object is None or object.type != "MESH" or lattice_object.is_lattice(object):
            raise LatticeError("select a mesh that is no lattice yet")
        lattice_object.check_local(object)
        if binding.is_bound(object):
            raise LatticeError(f"{object.name} is bound to a lattice; unbind it first")
        cells = make.closed_parts(object.data)
        if not cells:
            raise LatticeError(f"{object.name}: no part of the mesh is closed, with each edge in two faces")
        lattice_object.make_lattice(object, cells, espalier)
        self.report({"INFO"}, f"{object.name}: {len(cells)} cells")


class ImportLattice(EspalierOperator, ImportHelper, axes.HasUp, bpy.types.Operator):
    """Import a lattice, or a pose of the active lattice"""

    bl_idname = "espalier.import_lattice"
    bl_label = "Import Espalier Lattice"

    filename_ext = ".vtu"
    filter_glob: bpy.props.StringProperty(default=FILE_FILTER, options={"HIDDEN"})
    as_pose: bpy.props.BoolProperty(name="As Pose", default=True,
                                    description="A file with the cells of the active lattice becomes a shape key of "
                                                "this lattice")

    def run(self, context):
        espalier = engine.load()
        if not self.filepath:
            raise LatticeError("choose a file with a lattice")
        name = bpy.path.display_name_from_filepath(self.filepath)
        active = lattice_of_active(context) if self.as_pose else None
        pose = pose_in_file(espalier, self.filepath, active) if active else None
        if pose is not None:
            self.add_pose(active, name, axes.from_file(pose, self.up))
        else:
            self.add_lattice(context, name, espalier.read(self.filepath))

    def add_pose(self, lattice, name, positions):
        lattice_object.check_local(lattice)
        key, turned_off = shape_keys.add_pose(lattice, name, positions)
        self.report({"INFO"}, f"{name} is a pose of {lattice.name}: its shape key {key.name} has the value 1"
                    + (f"; set to 0: {', '.join(turned_off)}" if turned_off else ""))

    def add_lattice(self, context, name, lattice):
        turned = lattice.with_positions(axes.from_file(lattice.positions, self.up))
        select_only(context, lattice_object.object_of(turned, name, context.collection))
        dropped = [*lattice.attributes, *lattice.integers]
        if lattice.vertex_sharpness:
            dropped.append("sharpness of vertices")
        self.report({"WARNING" if dropped else "INFO"}, f"{name}: {len(lattice.cells)} cells"
                    + (f"; a mesh cannot hold: {', '.join(dropped)}" if dropped else ""))


def lattice_of_active(context):
    """Returns the active object if it is a lattice, or the lattice to which it is bound; None if there is none."""
    active = context.view_layer.objects.active
    if active is not None and binding.is_bound(active):
        active = active.espalier.lattice
    return active if lattice_object.is_lattice(active) else None


def pose_in_file(espalier, path, lattice):
    """Returns the positions of a file that is a pose of a lattice object: array (V, 3); None if it is none."""
    try:
        return espalier.read_pose(path, lattice_object.lattice_of(lattice, espalier, use_creases=False))
    except (LatticeError, OSError, ValueError):
        return None


class ExportLattice(EspalierOperator, ExportHelper, axes.HasUp, bpy.types.Operator):
    """Export the active lattice as it is posed now, in its own coordinates"""

    bl_idname = "espalier.export_lattice"
    bl_label = "Export Espalier Lattice"

    filename_ext = ".vtu"
    check_extension = None
    filter_glob: bpy.props.StringProperty(default=FILE_FILTER, options={"HIDDEN"})

    def run(self, context):
        espalier = engine.load()
        lattice = active_lattice(context, to_change=False)
        lattice_object.sync(lattice)
        positions = lattice_object.posed_positions(lattice, context.evaluated_depsgraph_get())
        lattice_object.lattice_of(lattice, espalier, axes.to_file(positions, self.up)).write(self.filepath)
        self.report({"INFO"}, f"{self.filepath}: {len(positions)} vertices")
