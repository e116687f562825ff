# SPDX-License-Identifier: Apache-2.0
"""Steps of blender_addon_test.py. How objects follow a lattice in the viewport."""

import json
import time

import bpy
import numpy as np

from .common import (ARGUMENTS, FOLDER, check, enable, clear, sphere, grid_sphere, select, evaluated, write_obj,
                     add_lattice, move_lattice, twist, animate)


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


def part():
    """A vertex group and a falloff: a part of the object follows, also in what is baked."""
    enable()
    clear()
    from espalier_lattice import binding
    model = sphere("model", 3)
    lattice = add_lattice(model, kind="BOX", cells=2)
    rest = evaluated(model)
    weights = np.clip(0.5 + rest[:, 2], 0, 1)
    group = model.vertex_groups.new(name="upper")
    for i, weight in enumerate(weights.tolist()):
        group.add([i], weight, "REPLACE")
    move_lattice(lattice, twist)
    full = evaluated(model) - rest
    check(np.abs(full).max() > 0.1, "the model follows")
    model.espalier.vertex_group = "upper"
    bpy.context.view_layer.update()
    expected = rest + weights[:, None] * full
    # Blender's weights and points are floats.
    check(np.abs(evaluated(model) - expected).max() < 1e-6, "weights")
    # Painting shows at once.
    group.add([0], 0.25, "REPLACE")
    weights[0] = 0.25
    expected = rest + weights[:, None] * full
    model.data.update()
    bpy.context.view_layer.update()
    check(np.abs(evaluated(model) - expected).max() < 1e-6, "painted")
    # The same after rebinding to another level and back, and in what is baked.
    select(model)
    model.espalier.level = 2
    model.espalier.level = 3
    bpy.context.view_layer.update()
    check(np.abs(evaluated(model) - expected).max() < 1e-6, "another level")
    frames = {"use_scene_range": False, "first": 1, "last": 1}
    check(bpy.ops.espalier.bake_shape_keys(**frames) == {"FINISHED"}, "baked to shape keys")
    bpy.context.scene.frame_set(1)
    check(np.abs(evaluated(model) - expected).max() < 1e-6, "shape keys")
    check(bpy.ops.espalier.follow_again() == {"FINISHED"}, "follows again")
    check(bpy.ops.espalier.bake_point_cache(filepath=str(FOLDER / "part.pc2"), **frames) == {"FINISHED"}, "cache")
    bpy.context.scene.frame_set(1)
    check(np.abs(evaluated(model) - expected).max() < 1e-6, "point cache")
    check(bpy.ops.espalier.follow_again() == {"FINISHED"}, "follows again")
    # A group that is gone is told, and the object does not jump.
    model.vertex_groups.remove(group)
    move_lattice(lattice, lambda co: co)
    check("no vertex group upper" in binding.problems.get("model", ""), "a group that is gone")
    model.espalier.vertex_group = ""
    move_lattice(lattice, lambda co: co)
    check(np.abs(evaluated(model) - rest - full).max() < 1e-6 and not binding.problems, "without a group")

    # A falloff: points above the box follow in part, and those beyond the distance stay.
    clear()
    mesh = bpy.data.meshes.new("line")
    heights = np.linspace(0, 2, 41)
    mesh.from_pydata([(0.1, 0.2, z) for z in heights.tolist()], [(i, i + 1) for i in range(40)], [])
    line = bpy.data.objects.new("line", mesh)
    bpy.context.collection.objects.link(line)
    box = sphere("box", 3)
    lattice = add_lattice(box, kind="BOX", cells=2)
    top = max(vertex.co.z for vertex in lattice.data.vertices)
    select(line, lattice)
    check(bpy.ops.espalier.bind() == {"FINISHED"}, "bind")
    line.espalier.falloff = 0.5
    move_lattice(lattice, lambda co: (co[0] + 1, co[1], co[2]))
    r = np.clip((heights - top) / 0.5, 0, 1)
    got = evaluated(line)[:, 0] - 0.1
    check(np.abs(got - (1 - r * r * (3 - 2 * r))).max() < 1e-5, f"falloff: {got}")


def custom_normals():
    """Normals that were set by hand turn with the object, as Blender keeps them relative to the surface."""
    enable()
    clear()
    model = sphere("model", 3)
    mesh = model.data
    mesh.use_auto_smooth = True
    rest = evaluated(model)
    normals = rest / np.linalg.norm(rest, axis=1)[:, None] + (0.3, 0, 0.2)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    mesh.normals_split_custom_set_from_vertices(normals.tolist())
    lattice = add_lattice(model, kind="BOX", cells=2)

    def corner_normals():
        mesh = model.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        mesh.calc_normals_split()
        found = np.empty(3 * len(mesh.loops), dtype=np.float32)
        mesh.loops.foreach_get("normal", found)
        return found.reshape(-1, 3)

    before = corner_normals()
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    move_lattice(lattice, lambda co: turn @ np.array(co))
    angles = np.degrees(np.arccos(np.clip((corner_normals() * (before @ turn.T)).sum(axis=1), -1, 1)))
    # Blender stores them as angles of 16 bits, relative to the normals of the surface.
    check(angles.max() < 0.1, f"custom normals are {angles.max()} degrees off")
    check(np.abs(before @ turn.T - before).max() > 0.5, "the normals turn")


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
    from espalier_lattice import binding, following, lattice_object

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
        following.on_load()  # Opening the file again changes nothing of it.
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
