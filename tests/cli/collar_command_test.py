#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier shape collar`, and the vertices that lattices hold in `pose` and `fit`.

    collar_command_test.py PATH_OF_ESPALIER
"""

import math
import random
import sys
import unittest

import program
from program import CliTest


class Collar(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 3, 2, 1, "--max", 3, 2, 1, "-o", "box.vtu")

    def collar(self, *options, output="collar.ovm"):
        return self.run_program("shape", "collar", "box.vtu", *options, "-o", output).stdout

    def positions(self, name):
        return self.read_ovm_positions(name)

    def test_says_what_it_made(self):
        self.assertEqual(self.collar("--layers", 2, "--reach", 3),
                         "collar.ovm: 336 vertices, 210 cells; a collar of 2 layers and 312 held "
                         "vertices reaches 3 away, c2\n")
        self.assertIn("reaches 3 away, c0\n", self.collar("--layers", 1, "--reach", 3))
        # The diagonal of the box is sqrt(14).
        self.assertIn("reaches 1.871 away", self.collar("--layers", 2, "--reach", "50%"))

    def test_poses_keep_held_vertices_in_all_formats(self):
        for name in ("c.ovm", "c.vtu", "c.vtk"):
            self.collar("--layers", 2, "--reach", 3, output=name)
            text = self.run_program("pose", name, "--move", 1, 0, 0, "-o", "p.ovm").stdout
            self.assertEqual(text, "p.ovm: 24 of 336 vertices moved; 312 are held\n")
            text = self.run_program("pose", name, "--move", 1, 0, 0, "--move-held", "-o", "p.ovm").stdout
            self.assertEqual(text, "p.ovm: 336 of 336 vertices moved\n")
        self.assertIn("all selected vertices are held",
                      self.error_of("pose", "c.vtu", "--select", "end", "+z", "--move", 0, 0, 1, "-o", "p.ovm", code=2))

    def test_fits_keep_held_vertices(self):
        self.collar("--layers", 2, "--reach", 3)
        rest = self.positions("collar.ovm")
        self.write_model([(1, 1, 0.5), (2, 1, 0.5)], "model.obj")
        for options in (["--pull", 1, 1, 0.5, 0, 0.2, 0], ["--pull", 1, 1, 0.5, 0, 0.2, 0, "--stiff"]):
            text = self.run_program("fit", "model.obj", "--rest", "collar.ovm", *options,
                                    "-o", "p.ovm").stdout
            self.assertRegex(text, r"vertices held +312\n")
            moved = [i for i, p in enumerate(self.positions("p.ovm")) if p != rest[i]]
            self.assertTrue(moved)
            self.assertLess(max(moved), 24)
        self.run_program("fit", "model.obj", "--rest", "collar.ovm", *options, "--move-held",
                         "-o", "p.ovm")
        moved = [i for i, p in enumerate(self.positions("p.ovm")) if p != rest[i]]
        self.assertGreater(max(moved), 24)

    def test_reaches_to_a_box_or_a_model(self):
        self.write_model([(-5, -6, -7), (8, 9, 10)], "mesh.obj")
        for options in (["--until", -5, -6, -7, 8, 9, 10], ["--until-model", "mesh.obj"]):
            self.collar("--layers", 3, *options)
            positions = self.positions("collar.ovm")
            self.assertEqual([min(p[a] for p in positions) for a in range(3)], [-5, -6, -7])
            self.assertEqual([max(p[a] for p in positions) for a in range(3)], [8, 9, 10])

    def test_open_sides(self):
        self.collar("--layers", 2, "--reach", 1, "--open", "z,+x", "--open=-y")
        positions = self.positions("collar.ovm")
        self.assertEqual([min(p[a] for p in positions) for a in range(3)], [-1, 0, 0])
        self.assertEqual([max(p[a] for p in positions) for a in range(3)], [3, 3, 1])

    def test_cells_of_a_boundary_layer_keep_their_height_under_a_rotation(self):
        # An ellipse of chord 1; cells at it are 0.01 long and 1e-6 high: an aspect ratio of 10,000.
        count, height = 240, 1e-6
        wall, above = [], []
        for i in range(count):
            t = 2 * math.pi * i / count
            x, y = 0.5 + 0.5 * math.cos(t), 0.06 * math.sin(t)
            nx, ny = 0.06 * math.cos(t), 0.5 * math.sin(t)
            size = math.hypot(nx, ny)
            wall.append((x, y, 0))
            above.append((x + height * nx / size, y + height * ny / size, 0))
        self.write_model(wall + above, "layer.obj")
        self.run_program("shape", "around", "layer.obj", "--cells", 6, 2, 1, "--collar", 5, "--reach", 2,
                         "--open", "z", "-o", "rest.ovm")
        # The body and the first layer of the collar turn by 10 degrees.
        self.run_program("pose", "rest.ovm", "--select", "box", -0.3, -0.3, -9, 1.3, 0.3, 9,
                         "--falloff", "smooth", 2, "--center", 0.5, 0, 0, "--rotate", "z", 10,
                         "-o", "turned.ovm")
        self.deform("layer.obj", "rest.ovm", "turned.ovm", "--limit", out="turned.obj")
        points = self.read_points("turned.obj")
        self.assertGreater(math.dist(points[0], wall[0]), 0.08)
        for i in range(count):
            before, here, after = points[i - 1], points[i], points[(i + 1) % count]
            along = [b - a for a, b in zip(before, after)]
            way = [b - a for a, b in zip(here, points[count + i])]
            normal_height = abs(along[0] * way[1] - along[1] * way[0]) / math.hypot(*along[:2])
            self.assertAlmostEqual(normal_height / height, 1, delta=0.02)

    def test_points_in_a_plane_of_symmetry_stay_in_it(self):
        random.seed(3)
        model = [(random.uniform(0, 3), 0.0, random.uniform(0, 1)) for _ in range(200)]
        model += [(random.uniform(0, 3), random.uniform(0, 2), random.uniform(0, 1)) for _ in range(50)]
        self.write_model(model, "half.obj")
        self.run_program("shape", "around", "half.obj", "--symmetry", "y", "--collar", 2, "--reach", 1,
                         "-o", "rest.ovm")

        def in_planes(p):
            return tuple(x + random.uniform(-0.05, 0.05) * (axis != 1) for axis, x in enumerate(p))

        def in_plane(p):
            # Vertices in the plane move in it; the others move anywhere.
            return tuple(x + random.uniform(-0.05, 0.05) * (axis != 1 or p[1] != 0)
                         for axis, x in enumerate(p))

        self.write_pose("across.ovm", "rest.ovm", in_planes)
        self.write_pose("anywhere.ovm", "rest.ovm", in_plane)
        for options in ([], ["-n", 1], ["--limit"]):
            self.deform("half.obj", "rest.ovm", "across.ovm", *options, out="moved.obj")
            points = self.read_points("moved.obj")
            self.assertEqual([p[1] for p in points], [p[1] for p in model], options)
            self.assertNotEqual(points[0][0], model[0][0])
            # The place of a point across the plane is 0 up to rounding, 1e-16 of a cell, and so are the
            # weights of the vertices outside the plane, which move by 0.05.
            self.deform("half.obj", "rest.ovm", "anywhere.ovm", *options, out="moved.obj")
            points = self.read_points("moved.obj")
            self.assertLess(max(abs(p[1]) for p in points[:200]), 1e-17, options)

    def test_data_named_held_of_another_kind_stay(self):
        points = [(i >> a & 1 for a in range(3)) for i in range(8)]
        lines = ["# vtk DataFile Version 3.0", "a cube", "ASCII", "DATASET UNSTRUCTURED_GRID", "POINTS 8 double"]
        lines += [" ".join(map(str, p)) for p in points]
        lines += ["CELLS 1 9", "8 0 1 3 2 4 5 7 6", "CELL_TYPES 1", "12", "POINT_DATA 8", "SCALARS held int 1",
                  "LOOKUP_TABLE default", "0 1 2 0 0 0 0 0"]
        self.put("user.vtk", "\n".join(lines) + "\n")
        self.assertEqual(self.run_program("pose", "user.vtk", "--move", 1, 0, 0, "-o", "moved.vtk").stdout,
                         "moved.vtk: 8 of 8 vertices moved\n")
        self.assertIn(b"held", self.bytes("moved.vtk"))
        self.assertIn('point data with the name "held" that are not integers 0 and 1',
                      self.error_of("shape", "collar", "user.vtk", "--layers", 1, "--reach", 1, "-o", "x.vtk"))

    def test_refusals_name_a_vertex_and_what_works(self):
        self.run_program("shape", "box", "--cells", 2, 1, 1, "--max", 2, 1, 1, "-o", "a.vtu")
        self.run_program("shape", "box", "--cells", 1, 1, 1, "--min", 0, 1, 0, "--max", 1, 2, 1, "-o", "b.vtu")
        self.run_program("shape", "merge", "a.vtu", "b.vtu", "-o", "l.vtu")
        message = self.error_of("shape", "collar", "l.vtu", "--layers", 3, "--reach", 0.25, "-o", "x.ovm")
        self.assertRegex(message, r"cells would be thicker than twice the reach near vertex \d+ of the lattice at "
                                  r"\(.*\); a collar of 1 layer works")
        text = self.run_program("shape", "collar", "l.vtu", "--layers", 1, "--reach", 0.25, "-o", "x.ovm").stdout
        self.assertIn("a collar of 1 layer and 16 held vertices reaches 0.", text)

    def test_refuses_wrong_options(self):
        for options, message in (
                (["--layers", 2], "--reach, --until or --until-model is required"),
                (["--reach", 2], "--layers is required"),
                (["--layers", 2, "--reach", "far"], "expected a length above 0"),
                (["--layers", 2, "--reach", 1, "--open", "up"], "--open: expected an axis x, y or z"),
                (["--layers", 2, "--reach", 1, "--held", 3], "--held: expected 1 to the number of layers"),
                (["--layers", 2, "--until", 0, 0, 0, 1, 1, 1], "--until: expected a box around")):
            self.assertIn(message,
                      self.error_of("shape", "collar", "box.vtu", *options, "-o", "x.ovm", code=2))
        self.run_program("shape", "around", "box.vtu", "-o", "a.vtu")
        self.assertIn("--collar",
                      self.error_of("shape", "around", "box.vtu", "--reach", 1, "-o", "x.ovm", code=2))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
