# SPDX-License-Identifier: Apache-2.0
"""Run by Blender (blender_addon_test.py): the steps of the test, one by one, by name.

    blender -b --python blender_addon_steps.py -- STEP FOLDER [ARGUMENT...]
"""

import json
import math
import pathlib
import sys
import time

import bpy
import numpy as np

ARGUMENTS = sys.argv[sys.argv.index("--") + 1:]
FOLDER = pathlib.Path(ARGUMENTS[1])


def check(condition, message):
    if not condition:
        raise AssertionError(message)


def enable():
    bpy.ops.preferences.addon_enable(module="espalier_lattice")


def clear():
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()


def sphere(name, subdivisions=4, radius=1.0, location=(0, 0, 0)):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=radius, location=location)
    object = bpy.context.active_object
    object.name = name
    return object


def grid_sphere(name, count):
    """A mesh of at least `count` points."""
    side = math.isqrt(count) + 1
    u, v = np.meshgrid(np.linspace(0, 2 * math.pi, side), np.linspace(0.1, math.pi - 0.1, side))
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    corner = np.arange((side - 1) * side).reshape(side - 1, side)[:, :-1].ravel()
    quads = np.stack([corner, corner + 1, corner + side + 1, corner + side], axis=-1)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    object = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(object)
    return object


def select(*objects):
    bpy.ops.object.select_all(action="DESELECT")
    for object in objects:
        object.select_set(True)
    bpy.context.view_layer.objects.active = objects[-1]


def evaluated(object):
    """Returns the points of an object with its shape keys and modifiers: array (N, 3)."""
    mesh = object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)


def write_obj(path, points):
    path.write_text("".join("v %.9g %.9g %.9g\n" % tuple(p) for p in points))


def add_lattice(*objects, **settings):
    select(*objects)
    result = bpy.ops.espalier.add_lattice(**settings)
    check(result == {"FINISHED"}, f"add_lattice: {result}")
    return bpy.context.active_object


def move_lattice(lattice, move):
    """Moves vertices of the mesh of a lattice, as edit mode does."""
    for vertex in lattice.data.vertices:
        vertex.co = move(vertex.co)
    lattice.data.update()
    bpy.context.view_layer.update()


def twist(co):
    angle = 0.6 * co[2]
    return (co[0] * math.cos(angle) - co[1] * math.sin(angle) + 0.2,
            co[0] * math.sin(angle) + co[1] * math.cos(angle), 1.2 * co[2])


def animate(lattice):
    """A shape key of the lattice goes from 0 to 1 in the frames 1 to 24."""
    if lattice.data.shape_keys is None:
        lattice.shape_key_add(name="Basis", from_mix=False)
    key = lattice.shape_key_add(name="pose", from_mix=False)
    for point in key.data:
        point.co = twist(point.co)
    for frame, value in ((1, 0.0), (24, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    for curve in lattice.data.shape_keys.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 24


def install():
    """Installs the zip, as a user does."""
    bpy.ops.preferences.addon_install(filepath=ARGUMENTS[2], overwrite=True)
    enable()
    from espalier_lattice import engine
    check("espalier_lattice/lib" in engine.load().__file__, engine.load().__file__)
    bpy.ops.wm.save_userpref()


def deform():
    """The object follows the lattice, in all kinds of lattices; files for the program are written."""
    enable()
    from espalier_lattice import engine, lattice_object, make
    for kind, _, _ in make.KINDS:
        clear()
        model = sphere("model", 4, location=(0.5, -0.25, 1))
        bpy.ops.object.transform_apply(location=True)
        lattice = add_lattice(model, kind=kind, cells=4)
        check(model.espalier.lattice == lattice, kind)
        outside = (np.asarray(__import__("espalier_lattice").binding.bound_of(model).binding.statuses) != 0)
        # The points are in the hole of the torus.
        check((outside.sum() == 0) == (kind != "TORUS"), f"{kind}: {outside.sum()} points outside")
        if kind == "TORUS":
            continue
        before = evaluated(model)
        write_obj(FOLDER / f"{kind}.obj", before)
        select(lattice)
        bpy.ops.espalier.export_lattice(filepath=str(FOLDER / f"{kind}-rest.ovm"))
        move_lattice(lattice, twist)
        after = evaluated(model)
        check(np.abs(after - before).max() > 0.1, f"{kind}: the model does not follow")
        bpy.ops.espalier.export_lattice(filepath=str(FOLDER / f"{kind}-pose.ovm"))
        np.save(FOLDER / f"{kind}.npy", after)
        # Lattice and model moved together: nothing changes.
        for object in (lattice, model):
            object.location = (3, 4, 5)
        bpy.context.view_layer.update()
        check(np.abs(evaluated(model) - after).max() < 2e-6, f"{kind}: moved together")
        # The lattice alone: the model moves with it.
        lattice.location = (3, 4, 6)
        bpy.context.view_layer.update()
        moved = evaluated(model) - after
        check(np.abs(moved - (0, 0, 1)).max() < 5e-6, f"{kind}: {np.abs(moved - (0, 0, 1)).max()}")
        # Unbound, it is as before.
        select(model)
        check(bpy.ops.espalier.unbind() == {"FINISHED"}, kind)
        check(np.array_equal(evaluated(model), before) and model.data.shape_keys is None, kind)


def save():
    """An animation is saved in a .blend file; its frames for comparison."""
    enable()
    clear()
    model = sphere("model", 4)
    lattice = add_lattice(model, kind="BOX", cells=3)
    model.espalier.level = 2
    animate(lattice)
    frames = []
    for frame in range(1, 25):
        bpy.context.scene.frame_set(frame)
        frames.append(evaluated(model))
    np.save(FOLDER / "frames.npy", np.array(frames))
    check(np.abs(frames[23] - frames[0]).max() > 0.1, "the model does not follow the animation")
    bpy.context.scene.frame_set(1)
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "a.blend"))


def reopen():
    """The animation is the same after opening the file; hooks and armatures move the lattice, too."""
    enable()
    bpy.ops.wm.open_mainfile(filepath=str(FOLDER / "a.blend"))
    model = bpy.data.objects["model"]
    lattice = model.espalier.lattice
    check(model.espalier.level == 2, "settings are saved")
    expected = np.load(FOLDER / "frames.npy")
    for frame in (24, 1, 12, 13):
        bpy.context.scene.frame_set(frame)
        check(np.array_equal(evaluated(model), expected[frame - 1]), f"frame {frame}")

    # A hook on the top vertices.
    bpy.context.scene.frame_set(1)
    before = evaluated(model)
    empty = bpy.data.objects.new("empty", None)
    bpy.context.collection.objects.link(empty)
    top = max(v.co.z for v in lattice.data.vertices)
    hook = lattice.modifiers.new("hook", "HOOK")
    hook.object = empty
    hook.vertex_indices_set([v.index for v in lattice.data.vertices if v.co.z > top - 1e-6])
    bpy.context.view_layer.update()
    empty.location = (0, 0, 1)
    bpy.context.view_layer.update()
    moved = evaluated(model) - before
    check(moved[:, 2].max() > 0.3 and abs(moved[:, 0]).max() < 1e-5, f"hook: {moved.max(axis=0)}")
    lattice.modifiers.remove(hook)

    # An armature whose bone moves all of the lattice.
    armature = bpy.data.armatures.new("armature")
    rig = bpy.data.objects.new("rig", armature)
    bpy.context.collection.objects.link(rig)
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.edit_bones.new("bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    lattice.vertex_groups.new(name="bone").add(list(range(len(lattice.data.vertices))), 1.0, "REPLACE")
    modifier = lattice.modifiers.new("armature", "ARMATURE")
    modifier.object = rig
    bpy.context.view_layer.update()
    rig.pose.bones["bone"].location = (0.5, 0, 0)
    bpy.context.view_layer.update()
    moved = evaluated(model) - before
    check(np.abs(moved - (0.5, 0, 0)).max() < 1e-5, f"armature: {moved.max(axis=0)}")
    lattice.modifiers.remove(modifier)

    # A modifier that adds vertices is an error that the panel shows.
    from espalier_lattice import binding
    subdivision = lattice.modifiers.new("subsurf", "SUBSURF")
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    check("change the number of vertices" in binding.problems.get("model", ""), binding.problems)
    lattice.modifiers.remove(subdivision)
    bpy.context.scene.frame_set(24)
    check(not binding.problems, binding.problems)


def bake():
    """Shape keys and a point cache play what the handler plays."""
    enable()
    bpy.ops.wm.open_mainfile(filepath=str(FOLDER / "a.blend"))
    model = bpy.data.objects["model"]
    expected = np.load(FOLDER / "frames.npy")
    select(model)
    check(bpy.ops.espalier.bake_shape_keys() == {"FINISHED"}, "bake_shape_keys")
    check(len(model.data.shape_keys.key_blocks) == 26, "one key per frame")
    for frame in (1, 7, 24):
        bpy.context.scene.frame_set(frame)
        check(np.abs(evaluated(model) - expected[frame - 1]).max() < 1e-6, f"shape keys, frame {frame}")
    check(bpy.ops.espalier.follow_again() == {"FINISHED"}, "follow_again")
    check(len(model.data.shape_keys.key_blocks) == 2, "keys are removed")
    bpy.context.scene.frame_set(5)
    check(np.abs(evaluated(model) - expected[4]).max() < 1e-6, "follows again")
    check(bpy.ops.espalier.bake_point_cache(filepath=str(FOLDER / "a.pc2")) == {"FINISHED"}, "cache")
    for frame in (1, 7, 24):
        bpy.context.scene.frame_set(frame)
        check(np.abs(evaluated(model) - expected[frame - 1]).max() < 1e-6, f"point cache, frame {frame}")
    # Without the add-on the baked file plays, too.
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "baked.blend"))


def baked():
    """Run without the add-on."""
    bpy.ops.preferences.addon_disable(module="espalier_lattice")
    bpy.ops.wm.open_mainfile(filepath=str(FOLDER / "baked.blend"))
    expected = np.load(FOLDER / "frames.npy")
    bpy.context.scene.frame_set(20)
    check(np.abs(evaluated(bpy.data.objects["model"]) - expected[19]).max() < 1e-6, "frame 20")


def undo():
    """The object follows the lattice after undo and redo, too."""
    enable()
    clear()
    sphere("model", 3)
    add_lattice(bpy.data.objects["model"], kind="BOX", cells=2)
    bpy.ops.ed.undo_push(message="bound")
    before = evaluated(bpy.data.objects["model"])
    move_lattice(bpy.data.objects["Espalier box"], twist)
    bpy.ops.ed.undo_push(message="moved")
    after = evaluated(bpy.data.objects["model"])
    check(np.abs(after - before).max() > 0.1, "the model follows")
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    check(np.abs(evaluated(bpy.data.objects["model"]) - before).max() < 1e-6, "undo")
    bpy.ops.ed.redo()
    bpy.context.view_layer.update()
    check(np.abs(evaluated(bpy.data.objects["model"]) - after).max() < 1e-6, "redo")
    # Another move, which starts from what undo and redo have left.
    bpy.ops.ed.undo()
    move_lattice(bpy.data.objects["Espalier box"], lambda co: co)
    check(np.abs(evaluated(bpy.data.objects["model"]) - before).max() < 1e-6, "undo again")
    # The undo of a rebinding gives the binding before it back.
    move_lattice(bpy.data.objects["Espalier box"], twist)
    bpy.ops.ed.undo_push(message="moved again")
    check(np.abs(evaluated(bpy.data.objects["model"]) - after).max() < 1e-6, "moved again")
    select(bpy.data.objects["model"])
    check(bpy.ops.espalier.rebind() == {"FINISHED"}, "rebind")
    bpy.ops.ed.undo_push(message="rebound")
    check(np.abs(evaluated(bpy.data.objects["model"]) - before).max() < 1e-6, "at rest after rebinding")
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    check(np.abs(evaluated(bpy.data.objects["model"]) - after).max() < 1e-6, "undo of the rebinding")
    move_lattice(bpy.data.objects["Espalier box"], lambda co: (co[0] + 1, co[1], co[2]))
    check(np.abs(evaluated(bpy.data.objects["model"]) - after - (1, 0, 0)).max() < 1e-5, "the first binding again")


def renamed():
    """Objects that exchange their names keep their bindings."""
    enable()
    clear()
    from espalier_lattice import binding
    large, small = sphere("large", 3), sphere("small", 2, radius=0.5)
    lattice = add_lattice(large, small, kind="BOX", cells=2)
    alike = sphere("alike", 2, radius=0.6)
    twin = alike.copy()
    twin.data, twin.name = alike.data.copy(), "twin"
    twin.location = (0.3, 0, 0)
    bpy.context.collection.objects.link(twin)
    select(alike, twin, lattice)
    check(bpy.ops.espalier.bind() == {"FINISHED"}, "bind")
    move_lattice(lattice, twist)
    objects = [large, small, alike, twin]
    before = [evaluated(object) for object in objects]
    for one, other in ((large, small), (alike, twin)):
        names = one.name, other.name
        other.name = "between"
        one.name, other.name = names[1], names[0]
    move_lattice(lattice, lambda co: (co[0] + 1, co[1], co[2]))
    check(not binding.problems, binding.problems)
    for object, points in zip(objects, before):
        check(np.abs(evaluated(object) - points - (1, 0, 0)).max() < 1e-5, object.name)


def edit():
    """Cells survive editing; what cannot be kept is told."""
    enable()
    clear()
    from espalier_lattice import binding, engine, lattice_object
    espalier = engine.load()
    model = sphere("model", 3)
    lattice = add_lattice(model, kind="BOX", cells=2)
    check(len(lattice_object.lattice_of(lattice, espalier).cells) == 8, "8 cells")

    # Blender's own extrusion of the four faces on top, in edit mode.
    select(lattice)
    top = max(v.co.z for v in lattice.data.vertices)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    for polygon in lattice.data.polygons:
        polygon.select = all(lattice.data.vertices[v].co.z > top - 1e-6 for v in polygon.vertices)
    check(sum(p.select for p in lattice.data.polygons) == 4, "four faces on top")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.extrude_region_move(TRANSFORM_OT_translate={"value": (0, 0, 1)})
    check(bpy.ops.espalier.update_cells() == {"FINISHED"}, "update_cells")
    check(lattice.mode == "EDIT", "the mode stays")
    bpy.ops.object.mode_set(mode="OBJECT")
    refined = lattice_object.lattice_of(lattice, espalier)
    check(refined.counts[3] == 12 and refined.counts[0] == 36, f"extruded: {refined.counts}")
    check(len(lattice.data.polygons) == refined.counts[2], "all faces, also those that Blender removed")
    check("rebind" in binding.problems.get("model", "") or not binding.update(
        model, bpy.context.evaluated_depsgraph_get()), "the binding is refused")
    check("rebind" in binding.problems["model"], binding.problems)
    select(model)
    check(bpy.ops.espalier.rebind() == {"FINISHED"}, "rebind")

    # The operator, on one face.
    select(lattice)
    boundary = {frozenset(loop) for loop in lattice_object.topology.boundary_faces(refined.cells)}
    for polygon in lattice.data.polygons:
        polygon.select = False
    chosen = next(p for p in lattice.data.polygons if frozenset(p.vertices) in boundary
                  and all(abs(lattice.data.vertices[v].co.z - top - 1) < 1e-5 for v in p.vertices))
    chosen.select = True
    check(bpy.ops.espalier.extrude_cell(distance=0.5) == {"FINISHED"}, "extrude_cell")
    refined = lattice_object.lattice_of(lattice, espalier)
    check(refined.counts[3] == 13, f"extrude_cell: {refined.counts}")
    check(abs(refined.positions[:, 2].max() - (top + 1.5)) < 1e-5, "outwards")

    # Deleting vertices loses their cells, and the others stay.
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.mesh.select_mode(type="VERT")
    bpy.ops.object.mode_set(mode="OBJECT")
    for vertex in lattice.data.vertices:
        vertex.select = vertex.co.z > top + 0.5
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="VERT")
    bpy.ops.object.mode_set(mode="OBJECT")
    result = lattice_object.sync(lattice)
    check(len(result.cells) == 8 and len(result.lost) == 5, (len(result.cells), result.lost))
    check("deleted or merged" in result.lost[0], result.lost)

    # Creases are sharpness, there and back.
    edges = {frozenset(e.vertices): e.index for e in lattice.data.edges}
    values = np.zeros(len(lattice.data.edges))
    values[3], values[5] = 1.0, 0.25
    lattice_object.set_creases(lattice.data, values)
    sharp = lattice_object.lattice_of(lattice, espalier).edge_sharpness
    check(sorted(sharp.values()) == [2.5, math.inf], sharp)
    bpy.ops.espalier.export_lattice(filepath=str(FOLDER / "creased.vtu"))
    bpy.ops.espalier.import_lattice(filepath=str(FOLDER / "creased.vtu"))
    imported = bpy.context.active_object
    check(imported != lattice, "imported")
    again = lattice_object.lattice_of(imported, espalier).edge_sharpness
    check(sorted(again.values()) == [2.5, math.inf], again)
    check(sorted(map(frozenset, again)) == sorted(map(frozenset, sharp)) or
          set(map(frozenset, again)) == set(map(frozenset, sharp)), "the same edges")
    check(edges is not None, "")


def marks():
    """Points outside, and folded cells."""
    enable()
    clear()
    from espalier_lattice import binding, operators
    inside = sphere("inside", 3)
    lattice = add_lattice(inside, kind="BOX", cells=2)
    half = sphere("half", 3, location=(1.0, 0, 0))
    select(half, lattice)
    check(bpy.ops.espalier.bind() == {"FINISHED"}, "bind")
    select(half)
    check(bpy.ops.espalier.mark_outside() == {"FINISHED"}, "mark_outside")
    group = half.vertex_groups[binding.OUTSIDE_GROUP].index
    marked = {v.index for v in half.data.vertices if any(g.group == group for g in v.groups)}
    limit = max(v.co.x for v in lattice.data.vertices)
    expected = {v.index for v in half.data.vertices if v.co.x + 1 > limit + 1e-5}
    check(marked == expected and 10 < len(marked) < len(half.data.vertices), (len(marked), len(expected)))

    # The middle vertex goes through a corner of one cell.
    select(lattice)
    check(bpy.ops.espalier.mark_folded() == {"FINISHED"}, "mark_folded")
    check(lattice.vertex_groups.get(operators.FOLDED) is None, "nothing is folded")
    middle = min(lattice.data.vertices, key=lambda v: v.co.length)
    middle.co = (3, 3, 3)
    lattice.data.update()
    bpy.context.view_layer.update()
    check(bpy.ops.espalier.mark_folded(level=2) == {"FINISHED"}, "mark_folded")
    check(lattice.vertex_groups.get(operators.FOLDED) is not None, "a cell is folded")
    colors = {tuple(round(c, 2) for c in each.color) for each in lattice.data.attributes[operators.FOLDED].data}
    check((1.0, 0.1, 0.05, 1.0) in colors, colors)


def linked():
    """Objects that share a mesh get meshes of their own when they are bound."""
    enable()
    clear()
    from espalier_lattice import binding
    first = sphere("first", 3)
    second = first.copy()
    second.name = "second"
    second.location = (0.5, 0, 0)
    bpy.context.collection.objects.link(second)
    alone = second.copy()
    alone.name, alone.data = "alone", second.data.copy()
    bpy.context.collection.objects.link(alone)
    first.data.use_fake_user = True  # This is no other object.
    lattice = add_lattice(first, second, alone, kind="BOX", cells=2)
    check(first.data != second.data, "two meshes")
    move_lattice(lattice, twist)
    check(not binding.problems, binding.problems)
    check(np.array_equal(evaluated(second), evaluated(alone)), "the second object follows as one with its own mesh")
    check(np.abs(evaluated(first) - evaluated(second)).max() > 0.1, "the first follows in its own way")

    # A linked duplicate of a bound object.
    third = second.copy()
    third.name = "third"
    third.location = (0.25, 0, 0)
    bpy.context.collection.objects.link(third)
    move_lattice(lattice, lambda co: (co[0], co[1], co[2] + 0.1))
    for object in (second, third):
        check("shares its mesh" in binding.problems.get(object.name, "")
              and "Rebind" in binding.problems[object.name], binding.problems)
    select(third)
    check(bpy.ops.espalier.unbind() == {"FINISHED"}, "unbind")
    check(third.data != second.data and third.data.shape_keys is None, "the third has its own mesh at rest")
    check(np.array_equal(evaluated(third), binding.rest_points(second).astype(np.float32)), "at rest")
    move_lattice(lattice, lambda co: (co[0] + 0.1, co[1], co[2]))
    check(not binding.problems, binding.problems)
    check(np.array_equal(evaluated(second), evaluated(alone)), "the second follows again")


def changed():
    """Changes of the object or the lattice after binding are told; Rebind takes them."""
    enable()
    clear()
    from espalier_lattice import binding, lattice_object

    def edit_mesh(object, change):
        import bmesh
        select(object)
        bpy.ops.object.mode_set(mode="EDIT")
        editable = bmesh.from_edit_mesh(object.data)
        editable.verts.ensure_lookup_table()
        change(bmesh, editable)
        bmesh.update_edit_mesh(object.data)
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()

    def told(expected):
        move_lattice(lattice, lambda co: (co[0], co[1], co[2] + 0.05))
        check(expected in binding.problems.get("model", ""), (expected, binding.problems))
        check("rebind" in binding.problems["model"], binding.problems)
        binding.on_load()  # Opening the file again changes nothing of it.
        move_lattice(lattice, lambda co: (co[0], co[1], co[2] - 0.05))
        check(expected in binding.problems.get("model", ""), (expected, binding.problems))
        select(model)
        check(bpy.ops.espalier.rebind() == {"FINISHED"}, expected)
        check(not binding.problems, binding.problems)
        before = evaluated(model)
        check(np.array_equal(before, binding.rest_points(model).astype(np.float32)), "at rest")
        move_lattice(lattice, lambda co: (co[0] + 0.05, co[1], co[2]))
        check(not binding.problems, binding.problems)
        check(np.abs(evaluated(model) - before - (0.05, 0, 0)).max() < 1e-6, "all of it follows")

    model = sphere("model", 3)
    lattice = add_lattice(model, kind="BOX", cells=2)
    move_lattice(lattice, lambda co: (co[0] + 0.05, co[1], co[2]))
    check(not binding.problems, binding.problems)

    def move_point(_, editable):
        editable.verts[0].co *= 0.5

    def add_point(bmesh, editable):
        bmesh.ops.poke(editable, faces=[next(iter(editable.faces))])

    edit_mesh(model, move_point)
    told("points of model have moved")
    edit_mesh(model, add_point)
    told("model has 163 points; it had 162")
    values = np.zeros(len(lattice.data.edges))
    values[3] = 0.5
    lattice_object.set_creases(lattice.data, values)
    told("creases of Espalier box have changed")
    # Faces of the model do not matter.
    edit_mesh(model, lambda bmesh, editable: bmesh.ops.delete(editable, geom=[next(iter(editable.faces))],
                                                              context="FACES_ONLY"))
    move_lattice(lattice, lambda co: (co[0], co[1], co[2] + 0.05))
    check(not binding.problems, binding.problems)
    # Another shape key of the user does not matter, either.
    key = model.shape_key_add(name="smile", from_mix=False)
    model.active_shape_key_index = len(model.data.shape_keys.key_blocks) - 1
    edit_mesh(model, move_point)
    check(key.data[0].co != model.data.shape_keys.key_blocks[0].data[0].co, "the key is edited")
    move_lattice(lattice, lambda co: (co[0], co[1], co[2] + 0.05))
    check(not binding.problems, binding.problems)


def keys():
    """Only what the add-on has made is removed, and all of it."""
    enable()
    clear()
    from espalier_lattice import binding
    model = sphere("model", 3)
    mine = ["Basis", "Espalier", "Espalier smile", "Espalier 2"]
    for name in mine:
        model.shape_key_add(name=name, from_mix=False)
    blocks = model.data.shape_keys.key_blocks
    blocks["Espalier smile"].data[0].co = (0, 0, 2)
    for frame, value in ((1, 0.0), (9, 1.0)):
        blocks["Espalier smile"].value = value
        blocks["Espalier smile"].keyframe_insert("value", frame=frame)
    own_modifier = model.modifiers.new("Espalier", "MESH_CACHE")
    own_modifier.show_viewport = False

    def curves():
        data = model.data.shape_keys.animation_data
        return [curve.data_path for curve in data.action.fcurves] if data and data.action else []

    def check_mine(when):
        check(list(model.data.shape_keys.key_blocks.keys()) == mine, (when, list(blocks.keys())))
        check(curves() == ['key_blocks["Espalier smile"].value'], (when, curves()))
        curve = model.data.shape_keys.animation_data.action.fcurves[0]
        check([p.interpolation for p in curve.keyframe_points] == ["BEZIER"] * 2, when)
        check(list(model.modifiers.keys()) == ["Espalier"], (when, list(model.modifiers.keys())))

    lattice = add_lattice(model, kind="BOX", cells=2)
    animate(lattice)
    bpy.context.scene.frame_end = 4
    bpy.context.scene.frame_set(4)
    posed = evaluated(model)
    check(len(model.data.shape_keys.key_blocks) == len(mine) + 1, "one key is added")

    # Baked twice, in two ways, the model moves once.
    cache = str(FOLDER / "keys.pc2")
    for action in (bpy.ops.espalier.bake_shape_keys, bpy.ops.espalier.bake_shape_keys,
                   lambda: bpy.ops.espalier.bake_point_cache(filepath=cache), bpy.ops.espalier.bake_shape_keys):
        select(model)
        check(action() == {"FINISHED"}, "bake")
    check(len(model.data.shape_keys.key_blocks) == len(mine) + 1 + 4, list(model.data.shape_keys.key_blocks.keys()))
    bpy.context.scene.frame_set(4)
    check(np.abs(evaluated(model) - posed).max() < 1e-6, "baked")
    check(bpy.ops.espalier.follow_again() == {"FINISHED"}, "follow_again")
    check(len(model.data.shape_keys.key_blocks) == len(mine) + 1, list(model.data.shape_keys.key_blocks.keys()))
    check(np.abs(evaluated(model) - posed).max() < 1e-6, "follows again")
    check(bpy.ops.espalier.unbind() == {"FINISHED"}, "unbind")
    check_mine("unbound")

    # Bake, and unbind without Follow Again.
    for bake_it in (bpy.ops.espalier.bake_shape_keys, lambda: bpy.ops.espalier.bake_point_cache(filepath=cache)):
        select(model, lattice)
        check(bpy.ops.espalier.bind() == {"FINISHED"}, "bind")
        select(model)
        check(model.espalier.is_live and bake_it() == {"FINISHED"}, "bake")
        check(bpy.ops.espalier.unbind() == {"FINISHED"}, "unbind")
        check_mine("unbound after baking")
        bpy.context.scene.frame_set(1)
        check(np.array_equal(evaluated(model), binding.rest_points(model).astype(np.float32)), "at rest")

    # A Basis of the user stays, also alone; one of the add-on goes.
    for has_basis in (True, False):
        clear()
        model = sphere("model", 3)
        before = evaluated(model)
        if has_basis:
            model.shape_key_add(name="Basis", from_mix=False)
        lattice = add_lattice(model, kind="BOX", cells=2)
        move_lattice(lattice, twist)
        select(model)
        check(bpy.ops.espalier.bake_shape_keys(use_scene_range=False, first=1, last=2) == {"FINISHED"}, "bake")
        check(bpy.ops.espalier.unbind() == {"FINISHED"}, "unbind")
        found = list(model.data.shape_keys.key_blocks.keys()) if model.data.shape_keys else []
        check(found == ["Basis"] * has_basis, found)
        check(np.array_equal(evaluated(model), before), "at rest")


def frames():
    """Frames below zero are baked, too."""
    enable()
    clear()
    model = sphere("model", 3)
    lattice = add_lattice(model, kind="BOX", cells=2)
    animate(lattice)
    scene = bpy.context.scene
    curve = lattice.data.shape_keys.animation_data.action.fcurves[0]
    curve.keyframe_points[0].co.x = -3
    curve.keyframe_points[1].co.x = 3
    curve.update()
    expected = {}
    for frame in range(-3, 4):
        scene.frame_set(frame)
        expected[frame] = evaluated(model)
    select(model)
    cache = str(FOLDER / "frames.pc2")
    for first, last in ((-1, 2), (-3, -1), (-1, -1)):
        settings = {"use_scene_range": False, "first": first, "last": last}
        check(bpy.ops.espalier.bake_shape_keys(**settings) == {"FINISHED"}, "bake_shape_keys")
        check(len(model.espalier.baked_keys) == last - first + 1, "one key per frame")
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            check(np.abs(evaluated(model) - expected[frame]).max() < 1e-6, f"shape keys, frame {frame}")
        check(bpy.ops.espalier.bake_point_cache(filepath=cache, **settings) == {"FINISHED"}, "bake_point_cache")
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            check(np.abs(evaluated(model) - expected[frame]).max() < 1e-6, f"point cache, frame {frame}")
        bpy.ops.espalier.follow_again()
    scene.frame_start, scene.frame_end = 2, 3
    check(bpy.ops.espalier.bake_shape_keys(first=-1, last=-1) == {"FINISHED"}, "the range of the scene")
    check(len(model.espalier.baked_keys) == 2, "the range of the scene")


def cage():
    """A cage follows the evaluated faces of the selected objects, in the coordinates of the world."""
    enable()
    clear()
    from espalier_lattice import binding, engine, lattice_object
    espalier = engine.load()

    def parts(lattice):
        """Returns the number of connected parts of a lattice."""
        parents = list(range(len(lattice.positions)))

        def root(vertex):
            while parents[vertex] != vertex:
                vertex = parents[vertex]
            return vertex

        for cell in lattice.cells:
            vertices = [v for loop in cell for v in loop]
            for vertex in vertices[1:]:
                parents[root(vertex)] = root(vertices[0])
        return len({root(v) for v in range(len(parents))})

    def check_cage(object, vertices, count):
        lattice = lattice_object.lattice_of(object, espalier)
        check(parts(lattice) == count, f"{parts(lattice)} parts, expected {count}")
        check(0.8 * vertices <= len(lattice.positions) <= 1.2 * vertices, len(lattice.positions))
        for bound in binding.bound_objects(lattice=object):
            check(not np.asarray(binding.bound_of(bound).binding.statuses).any(), f"{bound.name}: points outside")
        return lattice

    # The faces count, not the points: a cube has few points.
    bpy.ops.mesh.primitive_cube_add()
    check_cage(add_lattice(bpy.context.active_object, kind="CAGE", vertices=60), 60, 1)

    # A narrow object that is rotated, scaled and subdivided, and one far away.
    clear()
    bpy.ops.mesh.primitive_cube_add(location=(4, 0, 0), rotation=(0, 0.7, 0.4), scale=(3, 0.3, -0.5))
    narrow = bpy.context.active_object
    subdivision = narrow.modifiers.new("subdivision", "SUBSURF")
    subdivision.levels = 3
    bpy.context.view_layer.update()
    world = np.array(narrow.matrix_world)
    points = evaluated(narrow) @ world[:3, :3].T + world[:3, 3]
    check(len(points) > 100, "subdivided")
    other = sphere("other", 3, location=(-5, 2, 1))
    lattice = check_cage(add_lattice(narrow, other, kind="CAGE", vertices=150, margin=0.02), 150, 2)
    check(not np.asarray(espalier.bind(lattice, points, 3).statuses).any(), "the subdivided points are inside")
    volume = 4 / 3 * math.pi * 1 + abs(np.linalg.det(world[:3, :3])) * 8
    box = np.prod(lattice.positions.max(axis=0) - lattice.positions.min(axis=0))
    check(box > 10 * volume, "the box around both is large")
    # The cells fill little of the box.
    filled = sum(abs(np.linalg.det(np.stack([p[1] - p[0], p[3] - p[0], p[4] - p[0]])))
                 for p in lattice.positions[lattice.hexahedra])
    check(filled < 0.5 * box, (filled, box))

    # Points without faces have no cage.
    clear()
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 1)], [], [])
    cloud = bpy.data.objects.new("points", mesh)
    bpy.context.collection.objects.link(cloud)
    select(cloud)
    try:
        bpy.ops.espalier.add_lattice(kind="CAGE")
        check(False, "no error")
    except RuntimeError as error:
        check("no faces" in str(error) and "Box" in str(error), error)
    # Without a selection, it is a cage around a cube.
    clear()
    check(bpy.ops.espalier.add_lattice(kind="CAGE", vertices=60) == {"FINISHED"}, "no selection")
    check_cage(bpy.context.active_object, 60, 1)


def speed():
    """Times 100,000 points without drawing."""
    enable()
    clear()
    model = grid_sphere("model", 100000)
    lattice = add_lattice(model, kind="BOX", cells=4)
    model.espalier.level = 3
    animate(lattice)
    scene = bpy.context.scene
    scene.frame_set(1)
    wall, cpu = [], []
    for repeat in range(3):
        begin, used = time.perf_counter(), time.process_time()
        for frame in range(1, 25):
            scene.frame_set(frame)
        wall.append(24 / (time.perf_counter() - begin))
        cpu.append(24 / (time.process_time() - used))
    moved = evaluated(model)
    check(np.abs(moved - np.asarray([v.co for v in model.data.shape_keys.key_blocks[0].data])).max() > 0.1,
          "the points move")
    (FOLDER / "speed.json").write_text(json.dumps({"points": len(model.data.vertices),
                                                   "frames_per_second": max(wall),
                                                   "frames_per_cpu_second": max(cpu)}))


def render():
    """A picture by Cycles, at rest and posed."""
    enable()
    clear()
    bpy.ops.mesh.primitive_monkey_add(size=2)
    model = bpy.context.active_object
    model.name = "model"
    bpy.ops.object.modifier_add(type="SUBSURF")
    model.modifiers[0].levels = model.modifiers[0].render_levels = 2
    bpy.ops.object.modifier_apply(modifier=model.modifiers[0].name)
    for polygon in model.data.polygons:
        polygon.use_smooth = True
    lattice = add_lattice(model, kind="BOX", cells=3)
    animate(lattice)
    wire = lattice.copy()
    wire.data = lattice.data
    bpy.context.collection.objects.link(wire)
    wire.hide_render = False
    modifier = wire.modifiers.new("wire", "WIREFRAME")
    modifier.thickness = 0.015
    material = bpy.data.materials.new("clay")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.35, 0.12, 1)
    model.data.materials.append(material)
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1.6))
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.2, 0.5))
    bpy.context.active_object.data.energy = 4
    bpy.ops.object.camera_add(location=(3.2, -5.5, 2.2), rotation=(1.25, 0, 0.52))
    scene = bpy.context.scene
    scene.camera = bpy.context.active_object
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 24
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = 480, 360
    scene.world.color = (0.5, 0.5, 0.5)
    for frame in (1, 24):
        scene.frame_set(frame)
        scene.render.filepath = str(FOLDER / f"frame{frame:02d}.png")
        bpy.ops.render.render(write_still=True)
    pictures = []
    for frame in (1, 24):
        image = bpy.data.images.load(str(FOLDER / f"frame{frame:02d}.png"))
        pixels = np.empty(len(image.pixels), dtype=np.float32)
        image.pixels.foreach_get(pixels)
        pictures.append(pixels)
    check(np.abs(pictures[0] - pictures[1]).mean() > 0.01, "the pictures differ")
    # An animation is rendered with the handler: its last frame is the same picture.
    scene.frame_start = scene.frame_end = 24
    scene.render.filepath = str(FOLDER / "animation")
    bpy.ops.render.render(animation=True)
    image = bpy.data.images.load(str(FOLDER / "animation0024.png"))
    pixels = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(pixels)
    check(np.abs(pixels - pictures[1]).mean() < 0.01, "the animation follows the lattice")


def caches():
    """Files of the program: .pc2, .mdd and .glb."""
    clear()
    expected = np.load(FOLDER / "expected.npy")
    rest = np.load(FOLDER / "points.npy")
    faces = json.loads((FOLDER / "faces.json").read_text())
    scene = bpy.context.scene
    scene.render.fps = 24
    for kind in ("pc2", "mdd"):
        mesh = bpy.data.meshes.new(kind)
        mesh.from_pydata(rest.tolist(), [], faces)
        object = bpy.data.objects.new(kind, mesh)
        bpy.context.collection.objects.link(object)
        modifier = object.modifiers.new("cache", "MESH_CACHE")
        modifier.cache_format = kind.upper()
        modifier.filepath = str(FOLDER / f"out.{kind}")
        modifier.frame_start = 0
        for frame in range(len(expected)):
            scene.frame_set(frame)
            difference = np.abs(evaluated(object) - expected[frame]).max()
            check(difference < 1e-6, f"{kind}, frame {frame}: {difference}")
    # The importer of Blender 3.4 uses a name that NumPy 1.24 has removed.
    np.bool = bool
    bpy.ops.import_scene.gltf(filepath=str(FOLDER / "out.glb"))
    object = bpy.context.selected_objects[0]
    keys = object.data.shape_keys.key_blocks
    check([k.name for k in keys][1:] == [f"pose {i}" for i in range(len(expected))], [k.name for k in keys])
    # Blender's importer turns y up into z up: (x, y, z) becomes (x, -z, y).
    turned = np.stack([expected[..., 0], -expected[..., 2], expected[..., 1]], axis=-1)
    for i in range(len(expected)):
        points = np.empty(3 * len(rest), dtype=np.float32)
        keys[i + 1].data.foreach_get("co", points)
        difference = np.abs(points.reshape(-1, 3) - turned[i]).max()
        check(difference < 2e-6, f"glb, pose {i}: {difference}")
    for i in range(len(expected)):
        scene.frame_set(i)
        difference = np.abs(evaluated(object) - turned[i]).max()
        check(difference < 2e-6, f"glb, frame {i}: {difference}")


globals()[ARGUMENTS[0]]()
print("step passed:", ARGUMENTS[0])
