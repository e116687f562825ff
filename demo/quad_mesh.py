# SPDX-License-Identifier: Apache-2.0
"""Quad meshes with materials: checks, and OBJ files."""

from dataclasses import dataclass

import numpy as np

#: Colours of the materials, red, green and blue in 0 … 1, which all differ in lightness.
MATERIALS = {
    "suit": (0.27, 0.36, 0.52),
    "shirt": (0.93, 0.92, 0.88),
    "tie": (0.80, 0.36, 0.16),
    "skin": (0.91, 0.72, 0.56),
    "hat": (0.21, 0.28, 0.41),
    "shoe": (0.20, 0.18, 0.18),
    "light": (0.90, 0.87, 0.79),
    "dark": (0.36, 0.55, 0.64),
    "accent": (0.85, 0.45, 0.20),
}


@dataclass
class QuadMesh:
    points: np.ndarray  # n × 3
    quads: np.ndarray  # m × 4 vertices, anticlockwise from outside
    material: np.ndarray  # m names

    def euler_characteristic(self):
        return len(self.points) - 2 * len(self.quads) + len(self.quads)


def check(mesh, least_area):
    """Raises ValueError unless the mesh is a closed, consistently oriented manifold with the topology
    of a sphere, whose quads are larger than `least_area`."""
    quads, count = mesh.quads, len(mesh.points)
    faces = np.arange(len(quads))
    if not np.array_equal(np.unique(quads), np.arange(count)):
        raise ValueError("some vertices belong to no quad")
    opposite = opposites(quads)
    # Rotation around a vertex: from one outgoing half-edge to the next.
    previous = (np.repeat(faces, 4) * 4) + (np.tile(np.arange(4), len(faces)) + 3) % 4
    if orbit_count(opposite[previous]) != count:
        raise ValueError("the quads around a vertex are more than one fan")
    if mesh.euler_characteristic() != 2:
        raise ValueError(f"Euler characteristic {mesh.euler_characteristic()}, expected 2")
    area = quad_areas(mesh.points, quads)
    if area.min() < least_area:
        raise ValueError(f"a quad of area {area.min():.3g}, expected at least {least_area:.3g}")
    # This is six times the enclosed volume.
    if (mesh.points[quads].mean(axis=1) * area_vectors(mesh.points, quads)).sum() <= 0:
        raise ValueError("the mesh is inside out")


def opposites(quads):
    """Returns the opposite of each half-edge. Half-edge 4 q + i runs from corner i of quad q to the
    next corner.

    Raises ValueError unless each edge has two quads with consistent orientation.
    """
    tail, head = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    count = quads.max() + 1
    key, opposite_key = tail * count + head, head * count + tail
    order = np.argsort(key)
    if (np.diff(key[order]) == 0).any():
        raise ValueError("two quads run along an edge the same way")
    place = np.minimum(np.searchsorted(key[order], opposite_key), len(key) - 1)
    opposite = order[place]
    if (key[opposite] != opposite_key).any():
        raise ValueError("an edge has one quad")
    return opposite


def area_vectors(points, quads):
    """Returns the cross products of the diagonals: outward normals of twice the quads' area."""
    corner = points[quads]
    return np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])


def quad_areas(points, quads):
    return np.linalg.norm(area_vectors(points, quads), axis=1) / 2


def orbit_count(permutation):
    """Number of cycles of a permutation whose cycles have at most 64 members."""
    label = np.arange(len(permutation))
    jump = permutation
    for _ in range(6):
        label = np.minimum(label, label[jump])
        jump = jump[jump]
    return len(np.unique(label))


def write_obj(path, name, mesh, library):
    """Writes positions to 0.01 mm for a model in metres, and the quads sorted by material."""
    with open(path, "w", encoding="ascii") as file:
        file.write(f"# {name}: {len(mesh.points)} vertices, {len(mesh.quads)} quads\n")
        file.write(f"mtllib {library}\no {name}\n")
        np.savetxt(file, mesh.points, fmt="v %.5f %.5f %.5f")
        for material in MATERIALS:
            chosen = mesh.quads[mesh.material == material]
            if len(chosen):
                file.write(f"usemtl {material}\n")
                np.savetxt(file, chosen + 1, fmt="f %d %d %d %d")


def write_materials(path):
    with open(path, "w", encoding="ascii") as file:
        for name, colour in MATERIALS.items():
            file.write(f"newmtl {name}\nKd {colour[0]} {colour[1]} {colour[2]}\n")
