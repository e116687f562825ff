# SPDX-License-Identifier: Apache-2.0
"""Steps of blender_addon_test.py. Renders show what the viewport shows.

The scenes are made by the operators that a user presses. Nothing in them helps the render."""

import bpy
import numpy as np

from .common import ARGUMENTS, FOLDER, add_lattice, animate, check, clear, enable, evaluated, select

FRAMES = (1, 24)


def key(target, path, values):
    """Keys a property in the frames 1 and 24."""
    for frame, value in zip(FRAMES, values):
        setattr(target, path, value)
        target.keyframe_insert(path, frame=frame)


def top_of(lattice):
    return [v.index for v in lattice.data.vertices if v.co.z > 0.3]


def armature(lattice):
    data = bpy.data.armatures.new("armature")
    rig = bpy.data.objects.new("rig", data)
    bpy.context.collection.objects.link(rig)
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    bone = data.edit_bones.new("bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    lattice.vertex_groups.new(name="bone").add(top_of(lattice), 1.0, "REPLACE")
    lattice.modifiers.new("armature", "ARMATURE").object = rig
    key(rig.pose.bones["bone"], "location", ((0, 0, 0), (0.6, 0, 0)))


def hook(lattice):
    empty = bpy.data.objects.new("empty", None)
    bpy.context.collection.objects.link(empty)
    modifier = lattice.modifiers.new("hook", "HOOK")
    modifier.object = empty
    modifier.vertex_indices_set(top_of(lattice))
    key(empty, "location", ((0, 0, 0), (0.6, 0, 0)))


def twist_modifier(lattice):
    modifier = lattice.modifiers.new("twist", "SIMPLE_DEFORM")
    modifier.deform_method, modifier.deform_axis = "TWIST", "Z"
    key(modifier, "angle", (0.0, 1.5))


def transform(lattice):
    key(lattice, "location", ((0, 0, 0), (0.6, 0, 0)))


WAYS = {"shape_keys": animate, "armature": armature, "hook": hook, "modifier": twist_modifier,
        "transform": transform}


def scene_of(way, engine, kind="BOX"):
    """Makes a scene in which a lattice moves in some way. Returns the model."""
    clear()
    for object in list(bpy.data.objects):
        bpy.data.objects.remove(object)
    bpy.ops.mesh.primitive_monkey_add(size=2)
    model = bpy.context.active_object
    model.name = "model"
    lattice = add_lattice(model, kind=kind, cells=2, vertices=100)
    WAYS[way](lattice)
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.2, 0.5))
    bpy.context.active_object.data.energy = 4
    bpy.ops.object.camera_add(location=(3.2, -5.5, 2.2), rotation=(1.25, 0, 0.52))
    scene = bpy.context.scene
    scene.camera = bpy.context.active_object
    scene.frame_start, scene.frame_end = FRAMES
    scene.frame_step = FRAMES[1] - FRAMES[0]
    scene.render.resolution_x, scene.render.resolution_y = 96, 72
    scene.render.engine = engine
    scene.cycles.samples, scene.eevee.taa_render_samples = 4, 1
    scene.cycles.use_denoising = False
    scene.frame_set(1)
    return model


def picture(path):
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(-1, 4)


def still(frame):
    scene = bpy.context.scene
    scene.frame_set(frame)
    scene.render.filepath = str(FOLDER / "still.png")
    bpy.ops.render.render(write_still=True)
    return picture(FOLDER / "still.png")


def reference(model, frame):
    """Renders a plain mesh that has the points of the viewport, and no lattice."""
    bpy.context.scene.frame_set(frame)
    points = evaluated(model)
    plain = bpy.data.objects.new("plain", model.data.copy())
    plain.shape_key_clear()
    plain.data.vertices.foreach_set("co", points.ravel())
    bpy.context.collection.objects.link(plain)
    lattice = model.espalier.lattice
    before = model.hide_render, lattice.hide_render
    model.hide_render = lattice.hide_render = True
    found = still(frame)
    model.hide_render, lattice.hide_render = before
    bpy.data.objects.remove(plain)
    return found


def different(one, other):
    """Returns the number of pixels that differ by more than two of 255 steps."""
    return int((np.abs(one - other).max(axis=1) > 2.5 / 255).sum())


def check_pictures(pictures, expected, where):
    """Checks pictures of the frames 1 and 24."""
    count = different(*pictures)
    check(count > 300, f"{where}: {count} pixels differ between the frames")
    for frame, one, other in zip(FRAMES, pictures, expected):
        count = different(one, other)
        check(count == 0, f"{where}, frame {frame}: {count} pixels differ from the viewport's mesh")


def rendered():
    """All ways to move a lattice, as single pictures and as animations, by one engine."""
    enable()
    engine = ARGUMENTS[2]
    scene = bpy.context.scene
    for way in WAYS:
        model = scene_of(way, engine, "CAGE" if way == "hook" else "BOX")
        lattice = model.espalier.lattice
        stills = [still(frame) for frame in FRAMES]
        again = still(1)
        scene.frame_set(1)
        scene.render.filepath = str(FOLDER / "animation")
        bpy.ops.render.render(animation=True)
        animation = [picture(FOLDER / f"animation{frame:04d}.png") for frame in FRAMES]
        expected = [reference(model, frame) for frame in FRAMES]
        check_pictures(stills, expected, f"{way}, stills")
        check_pictures(animation, expected, f"{way}, animation")
        check(different(stills[0], again) == 0, f"{way}: frame 1 after frame 24")
        # The viewport still shows the pose after a render, also of a lattice that is hidden there.
        scene.frame_set(24)
        shown = evaluated(model)
        lattice.hide_viewport = True
        scene.frame_set(1)
        scene.frame_set(24)
        check(np.array_equal(evaluated(model), shown), f"{way}: hidden in the viewport")
    # Unbound, nothing is left in the scene.
    select(model)
    bpy.ops.espalier.unbind()
    check(not [o.name for o in bpy.data.objects if o.type == "EMPTY" and o.name != "empty"], "an empty is left")


def motion_blur():
    """Blurred pictures of an object that follows, and of the same object baked, by one engine."""
    enable()
    model = scene_of("shape_keys", ARGUMENTS[2])
    scene = bpy.context.scene
    sharp = still(12)
    scene.render.use_motion_blur = scene.eevee.use_motion_blur = True
    scene.render.motion_blur_shutter = scene.eevee.motion_blur_shutter = 4
    shown = evaluated(model)
    blurred = still(12)
    check(np.array_equal(evaluated(model), shown), "the viewport is as before the render")
    check(different(sharp, blurred) > 100, "the picture is blurred")
    scene.frame_step = 1
    select(model)
    check(bpy.ops.espalier.bake_shape_keys() == {"FINISHED"}, "bake")
    count = different(still(12), blurred)
    # The keys of both are linear, but the renders sample them by float32 numbers of their own.
    check(count <= 10, f"{count} pixels differ from the baked object")


def save_scene():
    """Saves a scene, and a scene as an earlier version has saved it: without what makes Blender evaluate the lattice."""
    enable()
    from espalier_lattice import evaluation, following
    model = scene_of("armature", "CYCLES")
    expected = [reference(model, frame) for frame in FRAMES]
    np.save(FOLDER / "expected.npy", np.array(expected))
    bpy.context.scene.frame_set(1)
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "new.blend"))
    following.unregister()
    for empty in evaluation.keepers(bpy.context.scene):
        bpy.data.objects.remove(empty)
    check(model.espalier.lattice.hide_render, "earlier versions hide the lattice in renders")
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "old.blend"))


def compare_pictures():
    """Compares the pictures that the command line of Blender has rendered."""
    expected = np.load(FOLDER / "expected.npy")
    for name in ARGUMENTS[2:]:
        check_pictures([picture(FOLDER / f"{name}{frame:04d}.png") for frame in FRAMES], expected, name)


def render_in_window():
    """Runs with a window. Renders an animation as Ctrl-F12 does, in a thread, while the viewport is drawn. Blender runs
    the timers after this function has returned."""
    enable()
    model = scene_of("hook", ARGUMENTS[2])
    expected = [reference(model, frame) for frame in FRAMES]
    scene = bpy.context.scene
    scene.render.filepath = str(FOLDER / "window")
    bpy.context.preferences.view.render_display_type = "NONE"
    done = []
    bpy.app.handlers.render_complete.append(lambda *_: done.append("complete"))
    bpy.app.handlers.render_cancel.append(lambda *_: done.append("cancel"))

    def start():
        scene.frame_set(1)
        window = bpy.context.window_manager.windows[0]
        with bpy.context.temp_override(window=window, screen=window.screen):
            bpy.ops.render.render("INVOKE_DEFAULT", animation=True)

    def finish():
        if not done:
            return 0.1
        try:
            check(done == ["complete"], done)
            check_pictures([picture(FOLDER / f"window{frame:04d}.png") for frame in FRAMES], expected, "window")
            scene.frame_set(24)
            check(np.abs(evaluated(model)).max() > 0.5, "the model is there after the render")
            (FOLDER / "window.txt").write_text("passed")
        except Exception as error:
            (FOLDER / "window.txt").write_text(str(error))
        bpy.ops.wm.quit_blender()

    bpy.app.timers.register(start, first_interval=0.5)
    bpy.app.timers.register(finish, first_interval=1)
