# SPDX-License-Identifier: Apache-2.0
"""Moves points by Blender's lattice modifier: peer_bench runs this script.

    blender --background --factory-startup --threads 1 --python bench/blender_lattice.py -- FOLDER

Reads FOLDER/points, FOLDER/pose (positions of the 11³ vertices of a lattice of the unit cube, x fastest) and
FOLDER/loops (corners of quadrilaterals). Writes FOLDER/moved, and FOLDER/seconds: the processor time of one update of
the scene after a change of the lattice. All are raw values: float32, int32 for the loops, float64 for the seconds.
"""

import pathlib
import sys
import time

import bpy
import numpy

REPEATS = 7
SIDE = 11


def mesh_object(folder):
    points = numpy.fromfile(folder / "points", numpy.float32)
    loops = numpy.fromfile(folder / "loops", numpy.int32)
    mesh = bpy.data.meshes.new("model")
    mesh.vertices.add(len(points) // 3)
    mesh.vertices.foreach_set("co", points)
    mesh.loops.add(len(loops))
    mesh.loops.foreach_set("vertex_index", loops)
    mesh.polygons.add(len(loops) // 4)
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, len(loops), 4, numpy.int32))
    mesh.polygons.foreach_set("loop_total", numpy.full(len(loops) // 4, 4, numpy.int32))
    mesh.update(calc_edges=True)
    return bpy.data.objects.new("model", mesh)


def lattice_object():
    lattice = bpy.data.lattices.new("lattice")
    lattice.points_u = lattice.points_v = lattice.points_w = SIDE
    lattice.interpolation_type_u = lattice.interpolation_type_v = lattice.interpolation_type_w = "KEY_BSPLINE"
    made = bpy.data.objects.new("lattice", lattice)
    # At rest, the vertices are 1 apart, around 0.
    made.location = (0.5, 0.5, 0.5)
    made.scale = [1 / (SIDE - 1)] * 3
    return made


def main():
    folder = pathlib.Path(sys.argv[-1])
    model, cage = mesh_object(folder), lattice_object()
    for each in (model, cage):
        bpy.context.collection.objects.link(each)
    modifier = model.modifiers.new("lattice", "LATTICE")
    modifier.object = cage
    pose = (numpy.fromfile(folder / "pose", numpy.float32) - numpy.float32(0.5)) * numpy.float32(SIDE - 1)
    rest = numpy.empty_like(pose)
    cage.data.points.foreach_get("co", rest)
    bpy.context.view_layer.update()
    seconds = []
    for positions in [rest, pose] * REPEATS:
        cage.data.points.foreach_set("co_deform", positions)
        cage.data.update_tag()
        begin = time.process_time()
        bpy.context.view_layer.update()
        seconds.append(time.process_time() - begin)
    moved = numpy.empty(3 * len(model.data.vertices), numpy.float32)
    model.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices.foreach_get("co", moved)
    moved.tofile(folder / "moved")
    numpy.array([min(seconds)]).tofile(folder / "seconds")
    print("seconds of each update:", " ".join(f"{each:.4f}" for each in seconds))


main()
