#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""refine and stencils on control polygons, and with the rules of RATS splines.

    curves_and_rats_test.py PATH_OF_ESPALIER
"""

import os
import sys
import unittest

import program
from program import CliTest


class Curves(CliTest):
    def write_polygon(self, *lines, name="polygon.obj"):
        points = ["v 0 0 0", "v 1 2 0", "v 3 2 1", "v 4 0 0"]
        self.put(name, "\n".join([*points, *(lines or ["l 1 2 3 4"])]) + "\n")

    def refined(self, *options, level=1):
        self.run_program("refine", "polygon.obj", "-n", level, "-o", "r.obj", *options)
        return self.read_points("r.obj")

    def statements(self, word):
        lines = self.text("r.obj").splitlines()
        return [line for line in lines if line.startswith(word + " ")]

    def test_open_polygon(self):
        # CSE-96-1, section 2.1: E0 V0 E1 V1 E2, by the 5 × 4 matrix; vertex points come first.
        self.write_polygon()
        self.assertEqual(self.refined("--boundary", "open"),
                         [(1.125, 1.75, 0.125), (2.875, 1.75, 0.75), (0.5, 1, 0), (2, 2, 0.5),
                          (3.5, 1, 0.5)])
        self.assertEqual(self.statements("l"), ["l 3 1 4 2 5"])

    def test_ends_stay_and_closed_polygons_have_none(self):
        self.write_polygon()
        points = self.refined(level=3)
        self.assertEqual(len(points), 3 * 8 + 1)
        self.assertEqual((points[0], points[3]), ((0, 0, 0), (4, 0, 0)))
        self.write_polygon("l 1 2 3 4 1")
        self.assertEqual(len(self.refined("--boundary", "open", level=3)), 4 * 8)
        line = self.statements("l")
        self.assertEqual(len(line), 1)
        self.assertEqual(line[0].split()[1], line[0].split()[-1])

    def test_stencils_give_the_refined_points(self):
        self.write_polygon("l 1 2 3 1", "l 3 4")
        for options in [[], ["--boundary", "open"], ["--rules", "rats"]]:
            points = self.refined(*options, level=2)
            self.run_program("stencils", "polygon.obj", "-n", 2, "-o", "s.mtx", *options)
            self.assert_close(self.product("s.mtx", self.read_points("polygon.obj")), points,
                              1e-15)

    def test_refining_twice_is_refining_by_two_levels(self):
        for options in [[], ["--boundary", "open"], ["--rules", "rats"]]:
            self.write_polygon("l 1 2 3 4", "t corner 1/1/0 2 2.5" if not options else "")
            twice = self.refined(*options, level=2)
            self.refined(*options)
            (self.path / "r.obj").rename(self.path / "polygon.obj")
            self.assert_close(sorted(self.refined(*options)), sorted(twice), 1e-15)

    def test_what_curves_are_not_for(self):
        self.write_polygon()
        error = self.error_of("refine", "polygon.obj", "-n", 1, "-o", "out.ovm")
        self.assertIn("out.ovm: a curve cannot be written in this format; expected .obj", error)
        self.write_polygon("l 1 2", "l 2 1")
        error = self.error_of("refine", "polygon.obj", "-n", 1, "-o", "out.obj")
        self.assertIn("polygon.obj:6: vertex 1 and vertex 2 are joined twice", error)


class Rats(CliTest):
    def refined(self, *options, level=1, name="mesh.obj"):
        self.run_program("refine", name, "-n", level, "-o", "r.obj", "--rules", "rats", *options)
        return self.read_points("r.obj")

    def test_mesh(self):
        # 4 × 4 points become 7 × 7, and the corners stay where they were.
        self.write_mesh()
        points = self.refined()
        self.assertEqual(len(points), 49)
        base = self.read_points("mesh.obj")
        for corner in (0, 3, 12, 15):
            self.assertEqual(points[corner], base[corner])
        # Eq 7: vertex 5 is the mean of four centroids, (1 2 1; 2 4 2; 1 2 1)/16. Heights around it
        # are tenths of (0 1 2; 1 2 0; 2 0 1), so 0.1 (4 + 10 + 3)/16.
        self.assert_close([points[5]], [(1, 1, 1.7 / 16)], 1e-15)
        catmull_clark = self.run_program("refine", "mesh.obj", "-n", 1, "-o", "c.obj")
        self.assertIn("49 vertices", catmull_clark.stdout)
        self.assertNotEqual(points, self.read_points("c.obj"))

    def test_refining_twice_is_refining_by_two_levels(self):
        self.write_mesh(["t crease 2/1/0 5 6 10", "t crease 2/1/0 6 10 10", "t corner 1/1/0 9 10"])
        twice = self.refined(level=2)
        self.refined()
        (self.path / "r.obj").rename(self.path / "once.obj")
        self.assert_close(sorted(self.refined(name="once.obj")), sorted(twice), 1e-15)

    def test_stencils_give_the_refined_points(self):
        self.write_mesh()
        points = self.refined(level=2)
        self.run_program("stencils", "mesh.obj", "-n", 2, "-o", "s.mtx", "--rules", "rats")
        self.assert_close(self.product("s.mtx", self.read_points("mesh.obj")), points, 1e-15)

    def test_what_rats_has_no_rules_for(self):
        rats = ["--rules", "rats", "-o", "out.obj", "-n", 0]
        self.run_program("shape", "box", "-o", "b.ovm")
        error = self.error_of("refine", "b.ovm", "--rules", "rats", "-o", "out.ovm")
        self.assertIn("b.ovm: the rules of RATS are for curves and meshes, not for lattices", error)
        # Commands that take lattices only do not offer these rules.
        for command in [["deform", "model.obj", "--rest", "b.ovm", "--to", "b.ovm", "-o", "o.obj"],
                        ["bind", "model.obj", "--rest", "b.ovm", "-o", "o.espb"],
                        ["info", "b.ovm"]]:
            self.assertIn("got rats", self.error_of(*command, "--rules", "rats", code=2))
        self.write_mesh()
        self.assertIn("boundary mode", self.error_of("refine", "mesh.obj", "--boundary", "open", *rats))
        self.assertIn("triangles", self.error_of("refine", "mesh.obj", "--triangles", "smooth", *rats))
        self.write_mesh(["t crease 2/1/0 6 5 2.5"])
        error = self.error_of("refine", "mesh.obj", *rats)
        self.assertIn("mesh.obj: edge (5, 6) is semi-sharp", error)
        self.assertFalse((self.path / "out.obj").exists())


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop())
    unittest.main()
