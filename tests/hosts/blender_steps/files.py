# SPDX-License-Identifier: Apache-2.0
"""Steps of blender_addon_test.py. What is saved, baked, rendered, imported and exported."""

import json

import bpy
import numpy as np

from .common import (FOLDER, check, enable, clear, sphere, select, evaluated, world_points, import_model, z_up,
                     add_lattice, move_lattice, twist, animate)


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
    object = import_model("out.glb")
    keys = object.data.shape_keys.key_blocks
    check([k.name for k in keys][1:] == [f"pose {i}" for i in range(len(expected))], [k.name for k in keys])
    turned = z_up(expected)
    for i in range(len(expected)):
        points = np.empty(3 * len(rest), dtype=np.float32)
        keys[i + 1].data.foreach_get("co", points)
        difference = np.abs(points.reshape(-1, 3) - turned[i]).max()
        check(difference < 2e-6, f"glb, pose {i}: {difference}")
    for i in range(len(expected)):
        scene.frame_set(i)
        difference = np.abs(evaluated(object) - turned[i]).max()
        check(difference < 2e-6, f"glb, frame {i}: {difference}")


def import_lattice(name, **settings):
    result = bpy.ops.espalier.import_lattice(filepath=str(FOLDER / name), **settings)
    check(result == {"FINISHED"}, f"import_lattice: {result}")
    return bpy.context.active_object


def poses_with_y_up():
    """Models, a lattice and its poses, all with y up: the lattice fits the model, and poses are shape keys of it."""
    enable()
    from espalier_lattice import engine
    espalier = engine.load()
    expected = z_up(np.load(FOLDER / "expected.npy"))
    # Blender has floats; the binding and the result are rounded, and the turn of an OBJ is a matrix of floats.
    bound = 3 * 2 ** -22
    for name in ("model.glb", "model.obj"):
        clear()
        model = import_model(name)
        rest = world_points(model)
        lattice = import_lattice("rest.vtu", up="Y")
        check(np.abs(evaluated(lattice) - z_up(espalier.read(FOLDER / "rest.vtu").positions)).max() < 1e-6, "rest")
        select(model, lattice)
        check(bpy.ops.espalier.bind() == {"FINISHED"}, "bind")
        check(np.abs(world_points(model) - rest).max() < bound, f"{name}: at rest")

        # The lattice is active; then the bound model. Each pose is shown alone.
        for i, (pose, active) in enumerate((("pose", lattice), ("bent", model))):
            select(active)
            check(import_lattice(f"{pose}.vtu", up="Y") == active, "a pose becomes no object")
            difference = np.abs(world_points(model) - expected[i]).max()
            check(difference < bound, f"{name}, {pose}: {difference}")
            check(lattice.active_shape_key.name == pose, lattice.active_shape_key.name)
        keys = lattice.data.shape_keys.key_blocks
        values = [(key.name, key.value) for key in keys[1:]]
        check(values == [("pose", 0), ("bent", 1)], values)

        # Keyframes of the values play the poses.
        keys["bent"].value = 0
        for frame, value in ((1, 0), (24, 1)):
            keys["pose"].value = value
            keys["pose"].keyframe_insert("value", frame=frame)
        for frame, points in ((24, expected[0]), (1, rest)):
            bpy.context.scene.frame_set(frame)
            check(np.abs(world_points(model) - points).max() < bound, f"{name}, frame {frame}")

        # Other cells, or As Pose turned off: another lattice.
        for file, settings in (("other.vtu", {}), ("pose.vtu", {"as_pose": False})):
            select(lattice)
            check(import_lattice(file, **settings) != lattice, file)
            check(len(keys) == 3, "no shape key is added")

    # A file whose coordinates are floats is the same file after import and export.
    lattice = espalier.read(FOLDER / "pose.vtu")
    lattice.with_positions(lattice.positions.astype(np.float32)).write(FOLDER / "floats.vtu")
    for up in "YZ":
        import_lattice("floats.vtu", up=up, as_pose=False)
        bpy.ops.espalier.export_lattice(filepath=str(FOLDER / "again.vtu"), up=up)
        check((FOLDER / "again.vtu").read_bytes() == (FOLDER / "floats.vtu").read_bytes(), f"{up} up, there and back")


def legacy_obj():
    """The older importer of Blender 3 numbers the vertices in the order in which the faces use them, unless it is told to
    keep their order."""
    def import_and_export(name, **settings):
        clear()
        bpy.ops.import_scene.obj(filepath=str(FOLDER / "editor.obj"), **settings)
        bpy.ops.wm.obj_export(filepath=str(FOLDER / name), export_selected_objects=True)

    import_and_export("legacy.obj")
    import_and_export("kept.obj", split_mode="OFF")
