# SPDX-License-Identifier: Apache-2.0
"""Steps of blender_addon_test.py. The cells of lattices: editing, marks, cages."""

import math

import bpy
import numpy as np

from .common import FOLDER, check, enable, clear, sphere, select, evaluated, add_lattice


def edit():
    """Cells survive editing; what cannot be kept is told."""
    enable()
    clear()
    from espalier_lattice import binding, engine, following, lattice_object
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
    check("rebind" in binding.problems.get("model", "") or not following.update(
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
    bpy.ops.espalier.import_lattice(filepath=str(FOLDER / "creased.vtu"), as_pose=False)
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
    from espalier_lattice import binding, op_cells
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
    check(lattice.vertex_groups.get(op_cells.FOLDED_GROUP) is None, "nothing is folded")
    middle = min(lattice.data.vertices, key=lambda v: v.co.length)
    middle.co = (3, 3, 3)
    lattice.data.update()
    bpy.context.view_layer.update()
    check(bpy.ops.espalier.mark_folded(level=2) == {"FINISHED"}, "mark_folded")
    check(lattice.vertex_groups.get(op_cells.FOLDED_GROUP) is not None, "a cell is folded")
    colors = {tuple(round(c, 2) for c in each.color) for each in lattice.data.attributes[op_cells.FOLDED_COLOR].data}
    check((1.0, 0.1, 0.05, 1.0) in colors, colors)


def cage():
    """A cage follows the evaluated faces of the selected objects, in the coordinates of the world."""
    enable()
    clear()
    from espalier_lattice import binding, engine, following, lattice_object
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
    lattice = check_cage(add_lattice(narrow, other, kind="CAGE", vertices=150, cage_margin=0.02), 150, 2)
    check(not np.asarray(espalier.bind(lattice, points, 3).statuses).any(), "the subdivided points are inside")
    volume = 4 / 3 * math.pi * 1 + abs(np.linalg.det(world[:3, :3])) * 8
    box = np.prod(lattice.positions.max(axis=0) - lattice.positions.min(axis=0))
    check(box > 10 * volume, "the box around both is large")
    # The cells fill little of the box.
    filled = sum(abs(np.linalg.det(np.stack([p[1] - p[0], p[3] - p[0], p[4] - p[0]])))
                 for p in lattice.positions[lattice.hexahedra])
    check(filled < 0.5 * box, (filled, box))

    # Without options, boxes and cages are the library's.
    clear()
    model = sphere("model", 3)
    points = evaluated(model).astype(np.float64)
    triangles = [tuple(p.vertices) for p in model.data.polygons]
    for kind, expected in (("CAGE", espalier.shapes.cage(points, triangles)), ("BOX", espalier.shapes.around(points))):
        got = lattice_object.lattice_of(add_lattice(model, kind=kind), espalier)
        check(got.counts == expected.counts and np.abs(got.positions - expected.positions).max() < 1e-6, kind)

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
