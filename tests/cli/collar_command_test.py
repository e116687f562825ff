#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier shape collar`, and the vertices that lattices hold in `pose` and `fit`.

    collar_command_test.py PATH_OF_ESPALIER
"""

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
