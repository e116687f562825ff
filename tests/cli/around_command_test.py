#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier shape around`: lattices around models.

    around_command_test.py PATH_OF_ESPALIER
"""

import json
import math
import pathlib
import sys
import unittest

import program
from program import CliTest

# Models that are not part of the repository: tried where they are there.
MODELS = sorted(pathlib.Path(__file__).resolve().parents[3].glob("shared/data/models/*.obj"))


class Around(CliTest):
    def around(self, *options, output="rest.ovm"):
        return self.run_program("shape", "around", *options, "-o", output).stdout

    def extents(self, name="rest.ovm"):
        """Returns the lowest and the highest coordinates of the vertices of a lattice."""
        positions = self.read_ovm_positions(name)
        return [f(p[axis] for p in positions) for f in (min, max) for axis in range(3)]

    def write_corners(self, low, high, name="model.obj"):
        """Writes a model of the eight corners of a box."""
        corners = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
        self.write_model([tuple(p) for p in corners], name)

    def assert_moves_every_point(self, model, lattice, *options):
        """Checks that a translated lattice translates each point of the model, to rounding."""
        self.write_pose("moved.ovm", lattice, lambda p: (p[0] + 1, p[1], p[2]))
        report = json.loads(self.deform(model, lattice, "moved.ovm", *options, "--report", "json",
                                        out="moved.obj").stdout)
        self.assertEqual(report["points"]["inside"], sum(report["points"].values()))
        for before, after in zip(self.read_points(model), self.read_points("moved.obj")):
            self.assertAlmostEqual(after[0], before[0] + 1, delta=1e-9)
            self.assertAlmostEqual(after[1], before[1], delta=1e-9)

    def test_symmetry_puts_a_side_or_the_middle_into_the_plane(self):
        self.write_corners((0, 0, 0), (4, 2, 1))
        self.around("model.obj", "--symmetry", "y")
        low, high = self.extents()[:3], self.extents()[3:]
        self.assertEqual(low[1], 0)
        self.assertAlmostEqual(high[1], 2 + 0.05 * math.sqrt(21))
        self.around("model.obj", "--symmetry", "z=0.5", "--cells", "1,1,1")
        self.assertIn(0.5, [p[2] for p in self.read_ovm_positions("rest.ovm")])
        self.assertIn("--symmetry: expected a plane that the model reaches to",
                      self.error_of("shape", "around", "model.obj", "--symmetry", "y=3", "-o", "x.ovm", code=2))
        self.assertIn("expected x, y or z, or a plane",
                      self.error_of("shape", "around", "model.obj", "--symmetry", "up", "-o", "x.ovm", code=2))

    def test_says_that_the_plane_of_symmetry_changes_the_number_of_cells(self):
        self.write_model([(0, 0, 0), (4, 3, 2)], "both.obj")
        text = self.around("both.obj", "--symmetry", "x=2", "--cells", 3, 2, 5)
        self.assertIn("; 4 cells along x instead of 3, for faces in the plane of symmetry", text)
        self.assertNotIn("instead", self.around("both.obj", "--symmetry", "x=2", "--cells", 4, 3, 5))
        self.assertNotIn("instead", self.around("both.obj", "--symmetry", "x", "--cells", 3, 3, 5))

    def test_a_collar_leaves_the_plane_of_symmetry_open(self):
        self.write_corners((0, 0, 0), (4, 2, 1))
        text = self.around("model.obj", "--symmetry", "y", "--collar", 2, "--reach", 3)
        self.assertIn("a collar of 2 layers and", text)
        self.assertIn("reaches 3 away, c2", text)
        self.assertEqual(self.extents()[1], 0)
        self.assertGreater(self.extents()[4], 5)

    def test_the_box_has_a_margin_of_5_percent_of_the_diagonal(self):
        self.write_corners((0, 0, 0), (4, 2, 1))
        self.assertEqual(self.around("model.obj"),
                         "rest.ovm: 30 vertices, 8 cells; all 8 points inside\n")
        margin = 0.05 * math.sqrt(21)
        for value, expected in zip(self.extents(), [-margin] * 3 + [x + margin for x in (4, 2, 1)]):
            self.assertAlmostEqual(value, expected, delta=1e-14)

    def test_cells_size_and_margin(self):
        self.write_corners((0, 0, 0), (4, 2, 1))
        # With this margin the box is a little larger than 4 by 2 by 1, so that cells of half a unit
        # do not fill it exactly.
        for options, cells in [(["--cells", 8], 8 * 4 * 2), (["--cells", 2, 3, 5], 30),
                               (["--cells=2,3,5"], 30), (["--size", 0.5], 9 * 5 * 3)]:
            out = self.around("model.obj", "--margin", 1e-6, *options)
            self.assertIn(f", {cells} cells;", out)

    def test_a_margin_of_0_is_widened_until_rounding_puts_no_point_outside(self):
        self.write_model([(0.1 * i, 0.7 - 0.1 * i, 0.3 * i * i) for i in range(8)])
        out = self.around("model.obj", "--margin", 0)
        self.assertIn("all 8 points inside", out)
        self.assert_moves_every_point("model.obj", "rest.ovm")

    def test_points_in_a_plane(self):
        self.write_model([(0, 0, 5), (1, 0, 5), (1, 1, 5), (0, 1, 5)])
        self.assertIn("all 4 points inside", self.around("model.obj"))
        self.assertEqual(self.error_of("shape", "around", "model.obj", "--margin", 0, "-o", "x.ovm", code=2),
                         "espalier: --margin: expected a number above 0, since the points lie in a plane and the "
                         "box would be flat, got 0\n")

    def test_the_oriented_box_of_a_turned_box_is_smaller(self):
        c, s = math.cos(0.5), math.sin(0.5)
        corners = [(x * c - y * s, x * s + y * c, z) for x in (0, 4) for y in (0, 2) for z in (0, 1)]
        self.write_model(corners)
        self.around("model.obj", "--margin", 0.001, "--oriented", "--cells", 4)
        self.assertEqual(len(self.read_ovm_positions("rest.ovm")), 5 * 3 * 2)
        self.assert_moves_every_point("model.obj", "rest.ovm")
        # The box along the axes is 4c + 2s = 4.47 by 4s + 2c = 3.67 by 1.
        self.around("model.obj", "--margin", 0.001, "--cells", 4)
        self.assertEqual(len(self.read_ovm_positions("rest.ovm")), 5 * 4 * 2)

    def test_several_models_and_a_part(self):
        self.write_corners((0, 0, 0), (1, 1, 1))
        self.write_corners((3, 0, 0), (4, 1, 1), "second.obj")
        both = self.around("model.obj", "second.obj", "--margin", 0.01)
        self.assertIn("all 16 points inside", both)
        # Corners of the part in either order.
        for part in [(2, -1, -1, 5, 2, 2), (5, 2, 2, 2, -1, -1)]:
            out = self.around("model.obj", "second.obj", "--around-part", *part, "--margin", 0)
            self.assertIn("all 8 points inside", out)
            self.assertAlmostEqual(self.extents()[0], 3, delta=1e-6)
        self.assertEqual(
            self.error_of("shape", "around", "model.obj", "--around-part", 8, 8, 8, 9, 9, 9,
                          "-o", "x.ovm"),
            "espalier: model.obj: no point of the models is in the box of --around-part\n")

    def test_wrong_options_name_themselves(self):
        self.write_corners((0, 0, 0), (1, 1, 1))
        for options, message in [
                (["--cells", 0], "--cells: expected 1 or more, got 0\n"),
                (["--cells", 1, 2], "--cells: expected one number or three, got two"),
                (["--size", -1], "--size"),
                (["--size", 1, "--cells", 2], "--cells"),
                (["--margin", -0.5], "espalier: --margin: expected a fraction of 0 or more, got -0.5"),
                (["--size", 1e-300], "espalier: --size: expected a length for which the number of cells fits "
                                     "into 31 bits, got 1e-300\n")]:
            self.assertIn(message, self.error_of("shape", "around", "model.obj", *options,
                                                 "-o", "x.ovm", code=2))
            self.assertFalse((self.path / "x.ovm").exists())
        self.write_model([(1, 2, 3)] * 3, "point.obj")
        self.assertIn("point.obj: all points are at (1, 2, 3)",
                      self.error_of("shape", "around", "point.obj", "-o", "x.ovm"))

    def test_the_output_cannot_be_a_model(self):
        self.write_corners((0, 0, 0), (1, 1, 1))
        before = self.bytes("model.obj")
        self.error_of("shape", "around", "model.obj", "-o", "model.obj")
        self.assertEqual(self.bytes("model.obj"), before)

    def test_models_of_others(self):
        if not MODELS:
            self.skipTest("there are no models beside the repository")
        for model in MODELS:
            for options in [[], ["--oriented"]]:
                with self.subTest(model=model.name, options=options):
                    self.assertIn("points inside", self.around(model, *options))
                    self.assert_moves_every_point(model, "rest.ovm")
                    self.assert_moves_every_point(model, "rest.ovm", "--limit")


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
