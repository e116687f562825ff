# SPDX-License-Identifier: Apache-2.0
"""The menus, and the panel in the sidebar of the 3D view."""

import textwrap

import bpy

from . import binding, lattice_object, make


class AddMenu(bpy.types.Menu):
    bl_idname = "VIEW3D_MT_espalier_add"
    bl_label = "Espalier Lattice"

    def draw(self, context):
        for kind, name, _ in make.KINDS:
            self.layout.operator("espalier.add_lattice", text=name).kind = kind


class LatticePanel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_espalier"
    bl_label = "Espalier Lattice"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Espalier"

    def draw(self, context):
        layout = self.layout
        object = context.active_object
        if lattice_object.is_lattice(object):
            self.draw_lattice(layout, object)
        elif binding.is_bound(object):
            self.draw_bound(layout, object)
        else:
            layout.menu(AddMenu.bl_idname, text="Add Lattice Around Selection")
            layout.operator("espalier.make_lattice")
            layout.operator("espalier.import_lattice")

    def draw_lattice(self, layout, object):
        layout.label(text=f"{object.name}: {object.data[lattice_object.CELLS][0]} cells")
        column = layout.column(align=True)
        column.operator("espalier.bind")
        column.operator("espalier.rebind")
        column.operator("espalier.unbind")
        column = layout.column(align=True)
        column.operator("espalier.update_cells")
        column.operator("espalier.extrude_cell")
        column.operator("espalier.mark_folded")
        layout.operator("espalier.export_lattice")

    def draw_bound(self, layout, object):
        settings = object.espalier
        layout.prop(settings, "lattice")
        row = layout.row()
        row.prop(settings, "use_limit")
        if not settings.use_limit:
            row.prop(settings, "level")
        row = layout.row()
        row.enabled = settings.falloff == 0
        row.prop(settings, "outside")
        layout.prop(settings, "falloff")
        layout.prop_search(settings, "vertex_group", object, "vertex_groups")
        layout.prop(settings, "rules")
        layout.prop(settings, "is_live")
        problem = binding.problems.get(object.name_full)
        if problem:
            box = layout.box()
            box.alert = True
            lines = box.column(align=True)
            for i, line in enumerate(textwrap.wrap(problem, 22)):
                lines.label(text=line, icon="BLANK1" if i else "ERROR")
        column = layout.column(align=True)
        column.operator("espalier.rebind")
        column.operator("espalier.unbind")
        column.operator("espalier.mark_outside")
        column = layout.column(align=True)
        column.operator("espalier.bake_shape_keys")
        column.operator("espalier.bake_point_cache")
        column.operator("espalier.follow_again")


def draw_add(self, context):
    self.layout.menu(AddMenu.bl_idname, icon="LATTICE_DATA")


def draw_import(self, context):
    self.layout.operator("espalier.import_lattice", text="Espalier lattice (.vtu, .vtk, .ovm)")


def draw_export(self, context):
    self.layout.operator("espalier.export_lattice", text="Espalier lattice (.vtu, .vtk, .ovm)")


MENUS = (("VIEW3D_MT_add", draw_add), ("TOPBAR_MT_file_import", draw_import),
         ("TOPBAR_MT_file_export", draw_export))
CLASSES = (AddMenu, LatticePanel)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    for name, draw in MENUS:
        getattr(bpy.types, name).append(draw)


def unregister():
    for name, draw in MENUS:
        getattr(bpy.types, name).remove(draw)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
