# SPDX-License-Identifier: Apache-2.0
"""Steps of blender_addon_test.py. Presses all buttons in many states. Each press works or gives a report; the test fails
if Blender prints a traceback."""

import random
from types import SimpleNamespace

import bpy

from .common import ARGUMENTS, FOLDER, add_lattice, check, clear, enable, move_lattice, select, sphere, twist


def scene():
    """Makes a model that is bound to a box, and another mesh. The model is selected."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    model = sphere("model", 2)
    lattice = add_lattice(model, kind="BOX", cells=2)
    lattice.name = "lattice"
    other = sphere("other", 2, location=(0.5, 0, 0))
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 2
    select(model)
    return SimpleNamespace(model=model, lattice=lattice, other=other)


def mode(object, name):
    select(object)
    bpy.ops.object.mode_set(mode=name)


def edit_mesh(object, change, mode_after="OBJECT"):
    import bmesh
    mode(object, "EDIT")
    editable = bmesh.from_edit_mesh(object.data)
    editable.verts.ensure_lookup_table()
    editable.faces.ensure_lookup_table()
    change(bmesh, editable)
    bmesh.update_edit_mesh(object.data)
    bpy.ops.object.mode_set(mode=mode_after)


def delete_vertex(bmesh, editable):
    bmesh.ops.delete(editable, geom=[editable.verts[0]], context="VERTS")


def delete_all(bmesh, editable):
    bmesh.ops.delete(editable, geom=editable.verts[:], context="VERTS")


def poke(bmesh, editable):
    bmesh.ops.poke(editable, faces=[editable.faces[0]])


def exclude(s):
    collection = bpy.data.collections.new("excluded")
    bpy.context.scene.collection.children.link(collection)
    for each in list(s.lattice.users_collection):
        each.objects.unlink(s.lattice)
    collection.objects.link(s.lattice)
    bpy.context.view_layer.layer_collection.children[collection.name].exclude = True
    select(s.model)


def fold(s):
    middle = min(s.lattice.data.vertices, key=lambda v: v.co.length)
    middle.co = (3, 3, 3)
    s.lattice.data.update()
    bpy.context.view_layer.update()
    select(s.lattice)


def link(s, *names):
    """Replaces objects by objects that are linked from a file."""
    path = str(FOLDER / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    for name in names:
        bpy.data.objects.remove(bpy.data.objects[name])
    with bpy.data.libraries.load(path, link=True) as (_, to):
        to.objects = list(names)
    for object in to.objects:
        bpy.context.collection.objects.link(object)
    select(bpy.data.objects["other"], *to.objects)


def new_object(s, type):
    getattr(bpy.ops.object, f"{type}_add")()


def share(s, object):
    twin = object.copy()
    bpy.context.collection.objects.link(twin)
    select(twin, object)


def clear_keys(s):
    s.model.shape_key_clear()


def remove_key(s):
    s.model.shape_key_remove(s.model.data.shape_keys.key_blocks["Espalier"])


def subdivide(s):
    s.lattice.modifiers.new("subdivision", "SUBSURF")
    select(s.lattice)


def two_names(s):
    """Vertex groups that have the names of attributes of the add-on."""
    from espalier_lattice import binding, lattice_object, op_cells
    for name in (op_cells.FOLDED_COLOR, op_cells.FOLDED_GROUP, lattice_object.IDS, binding.OUTSIDE_GROUP):
        for object in (s.lattice, s.model, s.other):
            object.vertex_groups.new(name=name)
    fold(s)


def flat(s, object):
    object.scale = (0, 0, 0)
    bpy.context.view_layer.update()
    select(s.other, s.model, s.lattice)


def mesh_of_points(s, count):
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata([(i, 0, 0) for i in range(count)], [], [])
    object = bpy.data.objects.new("points", mesh)
    bpy.context.collection.objects.link(object)
    select(object, s.lattice)
    select(object)


def bake_keys(s):
    select(s.model)
    bpy.ops.espalier.bake_shape_keys()


def no_active(s):
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = None


def delete_object(s, object):
    select(object)
    bpy.ops.object.delete()
    select(s.model)


def select_faces(s):
    for polygon in s.lattice.data.polygons:
        polygon.select = True
    select(s.lattice)


STATES = {
    "the model": lambda s: None,
    "an empty scene": lambda s: clear(),
    "no active object": no_active,
    "nothing selected": lambda s: bpy.ops.object.select_all(action="DESELECT"),
    "an unbound mesh": lambda s: select(s.other),
    "the lattice": lambda s: select(s.lattice),
    "all, the lattice last": lambda s: select(s.model, s.other, s.lattice),
    "all, the model last": lambda s: select(s.other, s.lattice, s.model),
    "two bound objects": lambda s: (select(s.other, s.lattice), bpy.ops.espalier.bind(), select(s.model, s.other)),
    "all faces of the lattice": select_faces,
    "a folded lattice": fold,
    "names of the add-on": two_names,
    "edit mode of the model": lambda s: mode(s.model, "EDIT"),
    "edit mode of the lattice": lambda s: mode(s.lattice, "EDIT"),
    "edit mode of both": lambda s: (select(s.model, s.lattice), bpy.ops.object.mode_set(mode="EDIT")),
    "edit mode after an extrusion": lambda s: edit_mesh(s.lattice, poke, "EDIT"),
    "sculpt mode": lambda s: mode(s.model, "SCULPT"),
    "weights of the lattice": lambda s: mode(s.lattice, "WEIGHT_PAINT"),
    "a hidden lattice in edit mode": lambda s: (mode(s.lattice, "EDIT"), setattr(s.lattice, "hide_viewport", True)),
    "a light": lambda s: new_object(s, "light"),
    "an empty": lambda s: new_object(s, "empty"),
    "an armature in pose mode": lambda s: (new_object(s, "armature"), bpy.ops.object.mode_set(mode="POSE")),
    "an unbound lattice": lambda s: (select(s.model), bpy.ops.espalier.unbind(), select(s.lattice)),
    "a deleted lattice": lambda s: delete_object(s, s.lattice),
    "a removed lattice": lambda s: bpy.data.objects.remove(s.lattice),
    "a deleted model": lambda s: (delete_object(s, s.other), bpy.data.objects.remove(s.model), select(s.lattice)),
    "another lattice": lambda s: setattr(s.model.espalier, "lattice", add_lattice(s.other, bind=False)),
    "no lattice": lambda s: setattr(s.model.espalier, "lattice", None),
    "an object that is no lattice": lambda s: setattr(s.model.espalier, "lattice", s.other),
    "cells that were removed": lambda s: s.lattice.data.__delitem__("espalier_cells"),
    "an edited model": lambda s: edit_mesh(s.model, poke),
    "a model without vertices": lambda s: edit_mesh(s.model, delete_all),
    "an edited lattice": lambda s: edit_mesh(s.lattice, delete_vertex),
    "a poked lattice": lambda s: edit_mesh(s.lattice, poke),
    "a lattice without vertices": lambda s: edit_mesh(s.lattice, delete_all),
    "a lattice with more vertices": subdivide,
    "a lattice that is not drawn": lambda s: s.lattice.hide_set(True),
    "a hidden lattice": lambda s: setattr(s.lattice, "hide_viewport", True),
    "a hidden lattice that is active": lambda s: (select(s.lattice), setattr(s.lattice, "hide_viewport", True)),
    "a hidden model": lambda s: (select(s.lattice), setattr(s.model, "hide_viewport", True)),
    "a lattice that the view layer excludes": exclude,
    "linked: the model": lambda s: link(s, "model"),
    "linked: the other": lambda s: (link(s, "other"), select(bpy.data.objects["other"], s.lattice)),
    "linked: the lattice": lambda s: link(s, "lattice"),
    "linked: both": lambda s: link(s, "model", "lattice"),
    "a linked duplicate of the model": lambda s: share(s, s.model),
    "a linked duplicate of the lattice": lambda s: share(s, s.lattice),
    "a shape key that was removed": remove_key,
    "all shape keys removed": clear_keys,
    "a vertex group that is gone": lambda s: setattr(s.model.espalier, "vertex_group", "gone"),
    "a flat model": lambda s: flat(s, s.model),
    "a flat lattice": lambda s: flat(s, s.lattice),
    "no points": lambda s: mesh_of_points(s, 0),
    "points without faces": lambda s: mesh_of_points(s, 3),
    "baked": bake_keys,
}


def presses():
    """Returns names and functions of all presses: of all operators, and some with several kinds of options."""
    from espalier_lattice import operators
    file, missing = str(FOLDER / "press.vtu"), str(FOLDER / "missing" / "press.vtu")
    options = {"add_lattice": [{"kind": "BOX"}, {"kind": "CAGE", "vertices": 20}, {"kind": "TORUS", "bind": False}],
               "import_lattice": [{"filepath": file}, {"filepath": file, "as_pose": False, "up": "Y"},
                                  {"filepath": missing}, {"filepath": ""}],
               "export_lattice": [{"filepath": file}, {"filepath": file, "up": "Y"},
                                  {"filepath": missing}, {"filepath": str(FOLDER / "a.xyz")}],
               "bake_point_cache": [{"filepath": str(FOLDER / "press.pc2")}, {"filepath": missing}],
               "bake_shape_keys": [{}, {"use_scene_range": False, "first": 2, "last": 1}]}
    found = []
    for each in operators.CLASSES:
        name = each.bl_idname.split(".")[1]
        for settings in options.get(name, [{}]):
            found.append((f"{name} {settings}", lambda name=name, settings=settings:
                          getattr(bpy.ops.espalier, name)(**settings)))
    check(len(found) > 20, "presses")
    return found


class Layout:
    """Takes all that a panel draws."""

    def __getattr__(self, name):
        return lambda *_, **__: Layout()


def press(name, function, where):
    """Presses, and draws the panel before and after. Returns the report of an error."""
    from espalier_lattice import panel
    report = ""
    try:
        function()
    except RuntimeError as error:
        report = str(error)
        check(report.startswith("Error: ") and len(report) > 15, report)
        for word in ("Traceback", "Python:", "bpy_struct", "bpy.ops", "object is not", "Matrix"):
            check(word not in report, report)
    drawn = SimpleNamespace(layout=Layout())
    drawn.draw_settings = lambda *arguments: panel.LatticePanel.draw_settings(drawn, *arguments)
    panel.LatticePanel.draw(drawn, bpy.context)
    return report


def press_all():
    """Presses each button in each state, and lets the handlers run."""
    enable()
    from espalier_lattice import following
    scene()
    select(bpy.data.objects["lattice"])
    bpy.ops.espalier.export_lattice(filepath=str(FOLDER / "press.vtu"))
    reports, wrong = set(), []
    states = {name: STATES[name] for name in STATES if ARGUMENTS[2:] in ([], [name])}
    for where, prepare in states.items():
        for name, function in presses():
            prepare(scene())
            before = bpy.context.mode
            try:
                report = press(name, function, where)
            except Exception as error:
                wrong.append(f"{where}, {name}: {error}")
                continue
            reports.add(f"{where}, {name}: {report.strip()}")
            # Blender lets no hidden object enter a mode again.
            if report and bpy.context.mode != before and where != "a hidden lattice in edit mode":
                wrong.append(f"{where}, {name}: the mode is {bpy.context.mode}")
            bpy.context.scene.frame_set(2)
            bpy.context.view_layer.update()
            if where == "linked: both":
                told = following.problem_of(bpy.data.objects["model"])
                check("is linked from" in told and "Make Local" in told, told)
    check(not wrong, "\n".join(wrong))
    (FOLDER / "reports.txt").write_text("\n".join(sorted(reports)))


def press_at_random():
    """Presses buttons one after the other, and changes the state between them."""
    enable()
    scene()
    select(bpy.data.objects["lattice"])
    bpy.ops.espalier.export_lattice(filepath=str(FOLDER / "press.vtu"))
    chance = random.Random(1)
    for _ in range(12):
        s = scene()
        for _ in range(25):
            name, function = chance.choice(presses())
            if chance.random() < 0.5:
                meshes = [o for o in bpy.context.view_layer.objects if o.type == "MESH" and o.visible_get()]
                if meshes and bpy.context.mode == "OBJECT":
                    select(*chance.sample(meshes, min(len(meshes), chance.randint(1, 3))))
            if chance.random() < 0.1 and bpy.context.active_object and bpy.context.active_object.type == "MESH":
                bpy.ops.object.mode_set(mode=chance.choice(("EDIT", "OBJECT")))
            if chance.random() < 0.3 and s.lattice.mode == "OBJECT":
                move_lattice(s.lattice, twist)
            press(name, function, "at random")


def folded_first():
    """The natural order of presses: add, bind, pose, Folded Cells first, and the others after it."""
    enable()
    from espalier_lattice import binding, op_cells
    for first in ("add", "bind"):
        clear()
        model = sphere("model", 3)
        lattice = add_lattice(model, kind="BOX", cells=2, bind=first == "add")
        if first == "bind":
            select(model, lattice)
            check(bpy.ops.espalier.bind() == {"FINISHED"}, "bind")
        middle = min(lattice.data.vertices, key=lambda v: v.co.length)
        before = middle.co.copy()

        def count_red():
            colors = lattice.data.attributes[op_cells.FOLDED_COLOR].data
            return sum(each.color[1] < 0.2 for each in colors)

        def pose(co):
            middle.co = co
            lattice.data.update()
            bpy.context.view_layer.update()
            select(lattice)
            check(bpy.ops.espalier.mark_folded() == {"FINISHED"}, "mark_folded")
            return count_red(), lattice.vertex_groups.get(op_cells.FOLDED_GROUP) is not None

        check(min(pose((3, 3, 3))) > 0, "a cell is folded")
        select(model)
        check(bpy.ops.espalier.mark_outside() == {"FINISHED"}, "mark_outside")
        check(model.vertex_groups.get(binding.OUTSIDE_GROUP) is None, "no point is outside")
        check(min(pose((3, 3, 3))) > 0, "the cell is still folded")
        check(pose(before) == (0, False), "no cell is folded")
        check(min(pose((3, 3, 3))) > 0, "a cell is folded again")
        # A file of an earlier version may have the color under the name of the group.
        lattice.vertex_groups.remove(lattice.vertex_groups[op_cells.FOLDED_GROUP])
        lattice.data.attributes.new(op_cells.FOLDED_GROUP, "FLOAT_COLOR", "CORNER")
        check(pose((3, 3, 3))[0] > 0, "a color of an earlier version")
