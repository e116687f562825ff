# SPDX-License-Identifier: Apache-2.0
"""Makes lattices around objects."""

import numpy as np

from . import lattice_object
from .lattice_object import LatticeError

KINDS = (
    ("BOX", "Box", "A box of cells around the selected objects"),
    ("CAGE", "Cage", "Cells that follow the shape of the selected objects"),
    ("CYLINDER", "Cylinder", "Cells in sectors and layers, along z"),
    ("TORUS", "Torus", ""),
    ("STAR", "Star", ""),
    ("BARBELL", "Barbell", ""),
    ("ARM", "Arm", ""),
    ("TETRAHEDRON", "Tetrahedron", ""),
    ("CUBE", "Cube", ""),
    ("OCTAHEDRON", "Octahedron", ""),
    ("DODECAHEDRON", "Dodecahedron", ""),
    ("ICOSAHEDRON", "Icosahedron", ""),
    ("PRISM", "Prism", ""),
    ("PYRAMID", "Pyramid", ""),
    ("BIPYRAMID", "Bipyramid", ""),
)


def model_of(objects, depsgraph, with_rest):
    """Returns the points of mesh objects with their shape keys and modifiers, in the coordinates of the world,
    and their faces as triangles: arrays (N, 3) and (T, 3).

    with_rest: add the points and faces at rest, before modifiers, which are what a lattice binds"""
    points, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for object in objects:
        evaluated = object.evaluated_get(depsgraph)
        matrix = np.array(evaluated.matrix_world)
        meshes = [evaluated.data]
        if with_rest and not np.array_equal(lattice_object.base_positions(object.data),
                                            lattice_object.base_positions(evaluated.data)):
            meshes.append(object.data)
        for mesh in meshes:
            points.append(lattice_object.base_positions(mesh) @ matrix[:3, :3].T + matrix[:3, 3])
            mesh.calc_loop_triangles()
            corners = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
            mesh.loop_triangles.foreach_get("vertices", corners)
            triangles.append(corners.reshape(-1, 3).astype(np.int64) + count)
            count += len(points[-1])
    return np.concatenate(points), np.concatenate(triangles)


def cube(espalier):
    """Returns the points and triangles of a cube of side 2, the model of an empty selection."""
    lattice = espalier.shapes.cube()
    faces = [loop for cell in lattice.cells for loop in cell]
    size = np.abs(lattice.positions).max()
    return lattice.positions / size, np.array([(loop[0], loop[i], loop[i + 1]) for loop in faces
                                               for i in range(1, len(loop) - 1)])


def around(espalier, kind, model, cells, vertices, margin):
    """Returns a lattice of a kind around a model, or around a cube if the model has no points.

    model: points (N, 3) and triangles (T, 3)
    cells: number of cells along the longest side of a box
    vertices: about the number of vertices of a cage"""
    points, triangles = model if len(model[0]) else cube(espalier)
    if kind == "BOX":
        return espalier.shapes.around(points, cells=cells, margin=margin)
    if kind == "CAGE":
        if len(triangles) == 0:
            raise LatticeError("the selected objects have no faces for a cage to follow; use Box")
        return espalier.shapes.cage(points, triangles, vertices=vertices, margin=margin)
    ready = getattr(espalier.shapes, kind.lower())()
    return fitted(espalier, ready, points, margin)


def fitted(espalier, lattice, points, margin):
    """Scales a ready lattice to the smallest tried size that has all points inside its second level. If no
    size has, as for points in the hole of a torus, its box has the size of the points."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = (low + high) / 2, np.maximum(high - low, 1e-9 * max(1.0, np.abs(points).max()))
    own_low, own_high = lattice.positions.min(axis=0), lattice.positions.max(axis=0)
    sample = points[:: max(1, len(points) // 2000)]
    sizes = [lattice.with_positions((lattice.positions - (own_low + own_high) / 2) * (
        1.25 ** k * (1 + 2 * margin) * size / (own_high - own_low)) + middle) for k in range(12)]
    for moved in sizes:
        statuses = np.asarray(espalier.bind(moved, sample, 2).statuses)
        if (statuses == int(espalier.PointStatus.INSIDE)).all():
            return moved
    return sizes[0]


def closed_parts(mesh):
    """Returns the faces of each part of a mesh that is joined by edges, if each edge is in two faces."""
    parents = list(range(len(mesh.polygons)))

    def root(face):
        while parents[face] != face:
            parents[face] = parents[parents[face]]
            face = parents[face]
        return face

    faces_of = {}
    for polygon in mesh.polygons:
        for key in polygon.edge_keys:
            faces_of.setdefault(key, []).append(polygon.index)
    closed = True
    for faces in faces_of.values():
        closed = closed and len(faces) == 2
        for face in faces[1:]:
            parents[root(face)] = root(faces[0])
    if not closed:
        return []
    parts = {}
    for polygon in mesh.polygons:
        parts.setdefault(root(polygon.index), []).append(list(polygon.vertices))
    return list(parts.values())
