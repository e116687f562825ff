# SPDX-License-Identifier: Apache-2.0
"""Run by Blender (blender_test.py): imports an .obj, moves its last vertex, and exports it.

    blender --background --python blender_round_trip.py -- IN.obj OUT.obj
"""

import os
import sys

import bpy

source, target = (os.path.abspath(name) for name in sys.argv[sys.argv.index("--") + 1:])
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
bpy.ops.wm.obj_import(filepath=source, forward_axis="Y", up_axis="Z")
mesh = bpy.context.selected_objects[0].data
for axis, distance in enumerate((0.5, 0.25, 0.125)):
    mesh.vertices[-1].co[axis] += distance
bpy.ops.wm.obj_export(filepath=target, forward_axis="Y", up_axis="Z", export_materials=False,
                      export_triangulated_mesh=False)
