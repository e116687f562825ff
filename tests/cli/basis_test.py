#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""deform and bind with --basis: the Bezier and B-spline lattices that came before subdivision.

    basis_test.py PATH_OF_ESPALIER
"""

import math
import os
import sys
import unittest

import program
from program import CliTest


def sixths(cells):
    """Points of the region of a B-spline lattice of unit cells, six a cell. At every level they lie
    at 0, 1/3 or 2/3 of a cell, which makes the differences of levels fall evenly."""
    axes = [[i / 6 for i in range(6, 6 * (n - 1) + 1)] for n in cells]
    return [(x, y, z) for z in axes[2] for y in axes[1] for x in axes[0]]


def bend(point):
    x, y, z = point
    return (x + 0.4 * math.sin(2 * y + z), y + 0.3 * math.cos(3 * x), z + 0.2 * x * y)


class Basis(CliTest):
    CELLS = (3, 4, 3)

    def setUp(self):
        super().setUp()
        self.points = sixths(self.CELLS)
        self.write_model(self.points)
        self.write_box("rest.ovm", self.CELLS)
        self.write_pose("pose.ovm", "rest.ovm", bend)

    def write_box(self, name, cells):
        self.run_program("shape", "box", "--cells", *cells, "--max", *cells, "-o", name, "--quiet")

    def deformed(self, *options, rest="rest.ovm", pose="pose.ovm"):
        self.run_program("deform", "model.obj", "--rest", rest, "--to", pose, "-o", "out.obj",
                         *options)
        return self.read_points("out.obj")

    def test_bezier_lattice_of_one_cell_is_trilinear(self):
        self.write_box("cube.ovm", (1, 1, 1))
        # The corner at (1, 1, 1) goes by (8, 16, 24), and a point by xyz of that.
        self.write_pose("corner.ovm", "cube.ovm",
                        lambda p: (9, 17, 25) if p == (1, 1, 1) else p)
        self.write_model([(0.5, 0.5, 0.5), (1, 0.5, 0.25), (0, 1, 1)])
        self.assert_close(self.deformed("--basis", "bezier", rest="cube.ovm", pose="corner.ovm"),
                          [(1.5, 2.5, 3.5), (2, 2.5, 3.25), (0, 1, 1)], 1e-14)

    def test_points_outside(self):
        self.write_pose("affine.ovm", "rest.ovm", lambda p: (2 * p[0], p[1] - p[2], p[2] + 1))
        self.write_model([(1.5, 1.5, 1.5), (0.5, 2, 2)])
        options = ["--basis", "bspline", "--outside"]
        self.assertEqual(self.deformed(*options, "keep", pose="affine.ovm")[1], (0.5, 2, 2))
        self.assert_close(self.deformed(*options, "nearest", pose="affine.ovm"),
                          [(3, 0, 2.5), (1, 0, 3)], 1e-13)
        error = self.error_of("deform", "model.obj", "--rest", "rest.ovm", "--to", "affine.ovm",
                              "-o", "out.obj", *options, "error")
        self.assertIn("point 1 at (0.5, 2, 2)", error)
        # All of the box is the region of a Bezier lattice.
        self.deformed("--basis", "bezier", "--outside", "error")

    def test_options_without_meaning_are_refused(self):
        bind = ["bind", "model.obj", "--rest", "rest.ovm", "-o", "m.espb"]
        for option, value in [("--level", "2"), ("--boundary", "open"), ("--creasing", "chaikin"),
                              ("--triangles", "smooth"), ("--sharp-edges", "literal"),
                              ("--rules", "cse96")]:
            for basis in ["bezier", "bspline"]:
                error = self.error_of(*bind, "--basis", basis, option, value, code=2)
                self.assertIn(option, error)
            self.run_program(*bind, "--basis", "subdivision", option, value, "--quiet")
        self.error_of(*bind, "--basis", "bezier", "-n", 3, code=2)
        self.assertIn("bspline", self.error_of(*bind, "--basis", "nurbs", code=2))

    def refusal_of(self, rest, basis="bezier"):
        return self.error_of("bind", "model.obj", "--rest", rest, "-o", "m.espb", "--basis", basis)

    def test_lattices_that_are_refused_are_named_with_the_cause(self):
        self.run_program("shape", "torus", "-o", "torus.ovm")
        self.assertIn("torus.ovm: the lattice is not a box", self.refusal_of("torus.ovm"))
        self.assertIn("pose.ovm: the rest positions are not an evenly divided parallelepiped: "
                      "vertex ", self.refusal_of("pose.ovm"))
        self.write_box("thin.ovm", (5, 5, 2))
        self.assertIn("thin.ovm: a B-spline lattice needs 3 cells",
                      self.refusal_of("thin.ovm", "bspline"))
        count = len(self.read_ovm_positions("rest.ovm"))
        sharp = ["VProp double \"espalier:vertex_sharpness\"", "10", *["-1"] * (count - 1)]
        self.put("marked.ovm", self.text("rest.ovm") + "\n".join(sharp) + "\n")
        self.assertIn("marked.ovm: the lattice has marks", self.refusal_of("marked.ovm"))


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop())
    unittest.main()
