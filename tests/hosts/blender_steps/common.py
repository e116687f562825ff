# SPDX-License-Identifier: Apache-2.0
"""Helpers of the steps of blender_addon_test.py."""

import math
import pathlib
import sys

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


def world_points(object):
    """Returns evaluated() in the coordinates of the scene: array (N, 3)."""
    matrix = np.array(object.matrix_world)
    return evaluated(object) @ matrix[:3, :3].T + matrix[:3, 3]


def import_model(name):
    """Imports a file of FOLDER, .glb or .obj, by Blender's importer with its defaults. Returns the mesh object."""
    if name.endswith(".glb"):
        np.bool = bool  # The importer of Blender 3.4 uses a name that NumPy 1.24 has removed.
        bpy.ops.import_scene.gltf(filepath=str(FOLDER / name))
    else:
        bpy.ops.wm.obj_import(filepath=str(FOLDER / name))
    bpy.context.view_layer.update()
    return next(object for object in bpy.context.selected_objects if object.type == "MESH")


def z_up(points):
    """Returns what Blender's importers make of points with y up: (x, y, z) becomes (x, -z, y)."""
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


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
