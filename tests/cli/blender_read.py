# SPDX-License-Identifier: Apache-2.0
"""Run by Blender (blender_test.py): imports files, and writes their vertices, faces and the normals of
their corners as JSON.

    blender --background --python blender_read.py -- OUT.json IN...
"""

import json
import os
import sys

import bpy

target, *sources = (os.path.abspath(name) for name in sys.argv[sys.argv.index("--") + 1:])
meshes = {}
for source in sources:
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    if source.endswith(".obj"):
        bpy.ops.wm.obj_import(filepath=source, forward_axis="Y", up_axis="Z")
    elif source.endswith(".ply"):
        bpy.ops.import_mesh.ply(filepath=source)
    else:
        bpy.ops.import_mesh.stl(filepath=source, axis_forward="Y", axis_up="Z")
    mesh = bpy.context.selected_objects[0].data
    mesh.calc_normals_split()
    meshes[os.path.basename(source)] = {
        "vertices": [list(vertex.co) for vertex in mesh.vertices],
        "faces": [list(face.vertices) for face in mesh.polygons],
        "normals": [list(loop.normal) for loop in mesh.loops]}
with open(target, "w") as out:
    json.dump(meshes, out)
