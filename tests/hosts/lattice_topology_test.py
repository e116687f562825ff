#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The cells of a lattice that is edited in Blender: hosts/blender/espalier_lattice/topology.py, without
Blender.

    lattice_topology_test.py
"""

import importlib.util
import pathlib
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2] / "hosts/blender/espalier_lattice/topology.py"
spec = importlib.util.spec_from_file_location("topology", SOURCE)
topology = importlib.util.module_from_spec(spec)
spec.loader.exec_module(topology)

CUBE = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def cube(*vertices):
    return [[vertices[i] for i in loop] for loop in CUBE]


def row(count):
    """Cells one above the other, by numbers of vertices."""
    return [cube(*range(4 * i, 4 * i + 8)) for i in range(count)]


def with_ids(cells):
    return [[[v + 1 for v in loop] for loop in cell] for cell in cells]


def edges_of(faces):
    return {frozenset((loop[i], loop[i - 1])) for loop in faces for i in range(len(loop))}


def keys(cells):
    return {frozenset(topology.key_of(loop) for loop in cell) for cell in cells}


class Topology(unittest.TestCase):
    def sync(self, cells, ids, faces):
        return topology.Sync(with_ids(cells), ids, faces, [tuple(e) for e in edges_of(faces)])

    def test_cells_are_packed(self):
        cells = row(2)
        self.assertEqual(topology.unpack(topology.pack(cells)), cells)
        self.assertEqual(topology.unpack(topology.pack([])), [])
        self.assertEqual(len(topology.all_faces(cells)), 11)
        self.assertEqual(len(topology.boundary_faces(cells)), 10)

    def test_what_is_not_edited_is_kept(self):
        cells = row(2)
        found = self.sync(cells, list(range(1, 13)), topology.all_faces(cells))
        self.assertEqual(found.cells, cells)
        self.assertEqual((found.lost, found.new_faces, found.new_cells, found.loose), ([], [], 0, 0))
        self.assertEqual(found.ids, list(range(1, 13)))

    def test_faces_may_begin_anywhere_and_vertices_may_move(self):
        cells = row(1)
        faces = [loop[1:] + loop[:1] for loop in cells[0][::-1]]
        self.assertEqual(keys(self.sync(cells, list(range(1, 9)), faces).cells), keys(cells))

    def test_an_extruded_face_makes_a_cell(self):
        """Blender removes the face that it extrudes, and copies the attributes of its vertices."""
        cells = row(1)
        faces = [loop for loop in cells[0] if set(loop) != {4, 5, 6, 7}]
        faces += [[8, 9, 10, 11], [4, 5, 9, 8], [5, 6, 10, 9], [6, 7, 11, 10], [7, 4, 8, 11]]
        for order in ([5, 6, 7, 8], [6, 7, 8, 5]):  # The copies in another order.
            rotated = order[0] - 5
            turned = [[v if v < 8 else 8 + (v - 8 - rotated) % 4 for v in loop] for loop in faces]
            found = self.sync(cells, [*range(1, 9), *order], turned)
            self.assertEqual(found.new_cells, 1)
            self.assertEqual(found.lost, [])
            self.assertEqual([topology.key_of(f) for f in found.new_faces], [frozenset((4, 5, 6, 7))])
            self.assertEqual(keys(found.cells), keys(row(2)) if rotated == 0 else keys(found.cells))
            self.assertEqual(len(topology.all_faces(found.cells)), 11)
            self.assertEqual(len(set(found.ids)), 12)
            self.assertEqual(found.loose, 0)

    def test_two_faces_extruded_together_share_a_face(self):
        """Blender makes no side at the edge between them."""
        cells = [cube(0, 1, 4, 3, 6, 7, 10, 9), cube(1, 2, 5, 4, 7, 8, 11, 10)]
        top = [{6, 7, 10, 9}, {7, 8, 11, 10}]
        faces = [loop for loop in topology.all_faces(cells) if set(loop) not in top]
        faces += [[12, 13, 16, 15], [13, 14, 17, 16], [6, 7, 13, 12], [7, 8, 14, 13], [8, 11, 17, 14],
                  [11, 10, 16, 17], [10, 9, 15, 16], [9, 6, 12, 15]]
        found = self.sync(cells, [*range(1, 13), 7, 8, 9, 10, 11, 12], faces)
        self.assertEqual(found.new_cells, 2)
        self.assertEqual(found.lost, [])
        self.assertEqual({topology.key_of(f) for f in found.new_faces},
                         {frozenset(top[0]), frozenset(top[1]), frozenset((7, 10, 13, 16))})

    def test_a_vertex_inside_the_extruded_faces_has_no_edge_to_its_copy(self):
        """Four cells in a square. Their upper faces are extruded together."""
        def at(i, j, k):
            return 9 * k + 3 * j + i

        def column(i, j, k):
            return cube(*(at(i + x, j + y, k + z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))))

        low = [column(i, j, 0) for j in (0, 1) for i in (0, 1)]
        high = [column(i, j, 1) for j in (0, 1) for i in (0, 1)]
        middle = {at(1, 1, k) for k in (1, 2)}
        faces = [loop for loop in topology.all_faces(low + high)
                 if not (min(loop) >= 9 and max(loop) < 18)  # Blender removes what it extrudes,
                 and not (middle <= set(loop))]              # and makes no face between two of them.
        found = self.sync(low, [*range(1, 19), *range(10, 19)], faces)
        self.assertEqual(found.lost, [])
        self.assertEqual(found.new_cells, 4)
        self.assertEqual(keys(found.cells), keys(low + high))
        self.assertEqual(len(found.new_faces), 8)

    def test_a_face_extruded_twice_makes_two_cells(self):
        cells = row(1)
        faces = [loop for loop in topology.all_faces(row(3))
                 if set(loop) not in ({4, 5, 6, 7}, {8, 9, 10, 11})]
        found = self.sync(cells, [*range(1, 9), 5, 6, 7, 8, 5, 6, 7, 8], faces)
        self.assertEqual(found.new_cells, 2)
        self.assertEqual(keys(found.cells), keys(row(3)))
        self.assertEqual({topology.key_of(f) for f in found.new_faces},
                         {frozenset((4, 5, 6, 7)), frozenset((8, 9, 10, 11))})

    def test_deleted_vertices_and_faces_are_told(self):
        cells = row(2)
        # The upper four vertices are deleted.
        faces = [loop for loop in topology.all_faces(cells) if max(loop) < 8]
        found = self.sync(cells, list(range(1, 9)), faces)
        self.assertEqual(found.cells, cells[:1])
        self.assertEqual(found.lost,
                         ["cell 1 is gone, because one of its vertices was deleted or merged"])
        # The lower four, so that all numbers change.
        faces = [[v - 4 for v in loop] for loop in topology.all_faces(cells) if min(loop) >= 4]
        found = self.sync(cells, list(range(5, 13)), faces)
        self.assertEqual(keys(found.cells), keys([cube(*range(8))]))
        # A face between the cells.
        faces = [loop for loop in topology.all_faces(cells) if set(loop) != {4, 5, 6, 7}]
        found = self.sync(cells, list(range(1, 13)), faces)
        self.assertEqual(found.cells, [])
        self.assertEqual(len(found.lost), 2)
        self.assertIn("its face of the vertices 4, 5, 6, 7 was deleted", found.lost[0])
        self.assertEqual(found.loose, 10)

    def test_split_faces_and_added_meshes_are_told(self):
        cells = row(1)
        faces = [loop for loop in cells[0] if set(loop) != {4, 5, 6, 7}] + [[4, 5, 6], [4, 6, 7]]
        found = self.sync(cells, list(range(1, 9)), faces)
        self.assertEqual(found.cells, [])
        self.assertIn("deleted, split or merged", found.lost[0])
        # A new primitive has ids 0, and is no cell.
        faces = [*cells[0], [8, 9, 10]]
        found = self.sync(cells, [*range(1, 9), 0, 0, 0], faces)
        self.assertEqual((found.cells, found.loose, found.lost), (cells, 1, []))
        self.assertEqual(len(set(found.ids)), 11)


if __name__ == "__main__":
    unittest.main()
