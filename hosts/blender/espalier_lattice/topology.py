# SPDX-License-Identifier: Apache-2.0
"""The cells of a lattice whose mesh is edited in Blender. Needs neither Blender nor Espalier.

A lattice in Blender is a mesh with all faces of all cells. The mesh does not say which faces bound a
cell, so the cells are stored beside it, as loops of vertex ids. An id is a number above 0 that a vertex
keeps when others are deleted. Vertices that editing adds have the id of the vertex that they were copied
from, or 0.
"""

import itertools
import math


def key_of(loop):
    """Returns the same key for all ways to write one face."""
    return frozenset(loop)


def pack(cells):
    """Turns cells into one list of integers: their number, and for each cell the number of its faces, and
    for each face the number of its vertices and the vertices."""
    flat = [len(cells)]
    for cell in cells:
        flat.append(len(cell))
        for loop in cell:
            flat.append(len(loop))
            flat.extend(int(vertex) for vertex in loop)
    return flat


def unpack(flat):
    """The inverse of pack()."""
    numbers = iter(flat)
    take = lambda: int(next(numbers))
    return [[[take() for _ in range(take())] for _ in range(take())] for _ in range(take())]


class Sync:
    """Brings the stored cells of a lattice up to date with its edited mesh.

    cells      the cells that are left and the new ones, as loops of vertex numbers of the mesh
    ids        the ids of all vertices of the mesh, all different
    new_faces  loops that the mesh lacks: extruding removes the face that it extrudes
    new_cells  number of cells that extruding a face of the boundary has made
    lost       sentences that say which cells could not be kept, and why
    loose      number of faces of the mesh that belong to no cell
    """

    def __init__(self, cells, ids, faces, edges):
        """cells: stored cells, as loops of ids; ids: one per vertex of the mesh; faces: loops of vertex
        numbers of the mesh; edges: pairs of vertex numbers."""
        self.vertex_of = {}
        for vertex, number in enumerate(ids):
            if number > 0:
                self.vertex_of.setdefault(number, vertex)
        self.copies = {}  # vertex -> vertices that were copied from it
        originals = set(self.vertex_of.values())
        for vertex, number in enumerate(ids):
            if vertex not in originals and number in self.vertex_of:
                self.copies.setdefault(self.vertex_of[number], []).append(vertex)
        self.face_of = {key_of(loop): list(loop) for loop in faces}
        self.edges = {frozenset(edge) for edge in edges}
        self.lost = []
        self.new_faces = []
        self.cells = []
        self._extruded_bases(cells)
        self._keep(cells)
        kept = len(self.cells)
        self._add_extruded()
        self.new_cells = len(self.cells) - kept
        used = {key_of(loop) for cell in self.cells for loop in cell}
        self.loose = sum(1 for key in self.face_of if key not in used)
        next_id = max([0, *ids]) + 1
        self.ids = list(ids)
        for vertex in range(len(ids)):
            if vertex not in originals:
                self.ids[vertex] = next_id
                next_id += 1

    def _loops(self, cell):
        """Returns a stored cell as loops of vertices; None if one of them is gone."""
        loops = []
        for loop in cell:
            vertices = [self.vertex_of.get(number) for number in loop]
            if None in vertices:
                return None
            loops.append(vertices)
        return loops

    def _extruded_bases(self, cells):
        """Finds faces that Blender removed because they were extruded."""
        self.bases = set()
        for cell in cells:
            for loop in self._loops(cell) or []:
                if key_of(loop) not in self.face_of and self._top(loop, set()) is not None:
                    self.bases.add(key_of(loop))

    def _keep(self, cells):
        for number, cell in enumerate(cells):
            loops = self._loops(cell)
            if loops is None:
                self.lost.append(f"cell {number} is gone, because one of its vertices was deleted or merged")
                continue
            missing = [loop for loop in loops
                       if key_of(loop) not in self.face_of and key_of(loop) not in self.bases]
            if missing:
                self.lost.append(f"cell {number} is gone, because its face of the vertices "
                                 f"{', '.join(map(str, sorted(missing[0])))} was deleted, split or merged")
                continue
            self.cells.append(loops)

    def _top(self, loop, used):
        """Returns the face that a face was extruded to, in the order of the face; None if it was not."""
        def candidates(vertex):
            same = [copy for origin, copies in self.copies.items()
                    if origin == vertex or vertex in copies for copy in copies
                    if copy not in used and copy != vertex]
            # A vertex inside the faces that are extruded together has no edge to its copy.
            joined = [copy for copy in same if frozenset((vertex, copy)) in self.edges]
            return joined or same

        choices = [candidates(vertex) for vertex in loop]
        if math.prod(map(len, choices)) > 1000:
            return None
        for top in itertools.product(*choices):
            if len(set(top)) < len(top):
                continue
            # A face that was extruded again is gone, too.
            if key_of(top) in self.face_of or self._top(top, used | set(loop)) is not None:
                return list(top)
        return None

    def _add_extruded(self):
        """Adds a cell for each face of the boundary that was extruded, and for faces extruded again."""
        count = {}
        for cell in self.cells:
            for loop in cell:
                count.setdefault(key_of(loop), [0, loop])[0] += 1
        open_faces = [loop for number, loop in count.values() if number == 1]
        known = set(self.face_of)
        used = set()  # vertices of the faces that were extruded before
        while open_faces:
            tops = []
            for loop in open_faces:
                top = self._top(loop, used)
                if top is None:
                    continue
                sides = [[loop[i], loop[(i + 1) % len(loop)], top[(i + 1) % len(loop)], top[i]]
                         for i in range(len(loop))]
                cell = [list(reversed(loop)), top, *sides]
                self.cells.append(cell)
                for face in cell:
                    if key_of(face) not in known:
                        known.add(key_of(face))
                        self.new_faces.append(face)
                tops.append((loop, top))
            for loop, top in tops:
                used.update(loop)
            open_faces = [top for _, top in tops]


def boundary_faces(cells):
    """Returns the loops that are in one cell only."""
    count = {}
    for cell in cells:
        for loop in cell:
            count.setdefault(key_of(loop), []).append(loop)
    return [loops[0] for loops in count.values() if len(loops) == 1]


def all_faces(cells):
    """Returns each face once, in the order of the first use."""
    faces = {}
    for cell in cells:
        for loop in cell:
            faces.setdefault(key_of(loop), loop)
    return list(faces.values())
