# SPDX-License-Identifier: Apache-2.0
"""The menus, and the panel in the sidebar of the 3D view."""

import textwrap

import bpy

from . import binding, following, lattice_object, make, operators


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
        kind = "other"
        if lattice_object.is_lattice(object):
            kind = "lattice"
            layout.label(text=f"{object.name}: {object.data[lattice_object.CELLS][0]} cells")
        elif binding.is_bound(object):
            kind = "bound"
            self.draw_settings(layout, object)
        else:
            layout.menu(AddMenu.bl_idname, text="Add Lattice Around Selection")
        for group in operators.BUTTONS[kind]:
            column = layout.column(align=True)
            for each in group:
                column.operator(each.bl_idname)

    def draw_settings(self, layout, object):
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
        problem = following.problem_of(object)
        if problem:
            box = layout.box()
            box.alert = True
            lines = box.column(align=True)
            for i, line in enumerate(textwrap.wrap(problem, 22)):
                lines.label(text=line, icon="BLANK1" if i else "ERROR")


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
