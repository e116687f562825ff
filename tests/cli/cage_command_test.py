#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier shape cage`: lattices that follow models.

    cage_command_test.py PATH_OF_ESPALIER
"""

import json
import math
import re
import sys
import unittest

import program
from program import CliTest


def tube(along, around, radius, length):
    """Returns points and faces of a closed tube along x."""
    points = [(length * i / along, radius * math.cos(2 * math.pi * k / around),
               radius * math.sin(2 * math.pi * k / around))
              for i in range(along + 1) for k in range(around)]
    faces = [(i * around + k, i * around + (k + 1) % around, (i + 1) * around + (k + 1) % around,
              (i + 1) * around + k) for i in range(along) for k in range(around)]
    faces.append(tuple(reversed(range(around))))
    faces.append(tuple(along * around + k for k in range(around)))
    return points, faces


class Cage(CliTest):
    def write(self, name, points, faces):
        text = "".join("v %.9g %.9g %.9g\n" % tuple(p) for p in points)
        text += "".join("f " + " ".join(str(v + 1) for v in face) + "\n" for face in faces)
        self.put(name, text)

    def cage(self, *options, output="rest.ovm"):
        """Returns the number of vertices that the program prints."""
        out = self.run_program("shape", "cage", *options, "-o", output).stdout
        found = re.fullmatch(re.escape(output) + r": (\d+) vertices, (\d+) cells(; .*)?\n", out)
        self.assertTrue(found, out)
        self.symmetry = found[3]
        return int(found[1])

    def inside_and_outside(self, model, lattice="rest.ovm"):
        """Returns the numbers of points of a model that are inside a lattice, and that are not."""
        report = json.loads(self.deform(model, lattice, lattice, "--report", "json",
                                        out="moved.obj").stdout)
        inside = report["points"]["inside"]
        return inside, sum(report["points"].values()) - inside

    def assert_all_inside(self, model, lattice="rest.ovm"):
        inside, outside = self.inside_and_outside(model, lattice)
        self.assertEqual(outside, 0)
        self.assertGreater(inside, 0)

    def setUp(self):
        super().setUp()
        self.write("tube.obj", *tube(20, 12, 0.5, 4))

    def test_vertices_and_size(self):
        for wanted in (30, 60):
            found = self.cage("tube.obj", "--vertices", wanted)
            self.assertLessEqual(abs(found - wanted), 0.2 * wanted)
            self.assert_all_inside("tube.obj")
        coarse = self.cage("tube.obj", "--size", 1.2)
        self.assertGreater(self.cage("tube.obj", "--size", 0.6), coarse)
        self.assert_all_inside("tube.obj")

    def test_the_default_is_200_vertices(self):
        self.assertLessEqual(abs(self.cage("tube.obj") - 200), 40)

    def test_several_models_are_one(self):
        points, faces = tube(20, 12, 0.5, 4)
        self.write("second.obj", [(x, y, z + 3) for x, y, z in points], faces)
        self.cage("tube.obj", "second.obj", "--vertices", 80)
        self.assert_all_inside("tube.obj")
        self.assert_all_inside("second.obj")

    def test_a_margin_and_a_shell(self):
        # The margin is a tenth of the diagonal, which is 4.24: points 0.42 outside the tube are inside.
        self.write("wide.obj", *tube(20, 12, 0.5 + 0.42, 4))
        self.cage("tube.obj", "--vertices", 40)
        self.assertGreater(self.inside_and_outside("wide.obj")[1], 0)
        self.cage("tube.obj", "--vertices", 40, "--margin", 0.1)
        self.assert_all_inside("wide.obj")
        self.write("square.obj", [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
        self.cage("square.obj", "--vertices", 40, "--shell", 0.3)
        self.assert_all_inside("square.obj")
        heights = [p[2] for p in self.read_ovm_positions("rest.ovm")]
        self.assertLessEqual(min(heights), -0.15)
        self.assertGreaterEqual(max(heights), 0.15)

    def test_keep_apart(self):
        points, faces = tube(20, 12, 0.5, 4)
        both = points + [(x, y, z + 1.15) for x, y, z in points]
        self.write("two.obj", both, faces + [tuple(v + len(points) for v in f) for f in faces])
        euler = {}  # of a lattice without handles: the number of its components
        for options in ([], ["--keep-apart"]):
            self.cage("two.obj", "--vertices", 40, *options)
            info = json.loads(self.run_program("info", "rest.ovm", "--json").stdout)
            euler[bool(options)] = info["levels"][0]["euler_characteristic"]
            self.assert_all_inside("two.obj")
        self.assertEqual(euler, {False: 1, True: 2})

    def test_symmetry(self):
        self.cage("tube.obj", "--vertices", 40)
        self.assertEqual(self.symmetry, "; symmetric about x = 2, y = 0, z = 0")
        self.cage("tube.obj", "--vertices", 40, "--symmetric", "none")
        self.assertIsNone(self.symmetry)
        points, faces = tube(20, 12, 0.5, 4)
        points[0] = (points[0][0] - 0.05, *points[0][1:])
        self.write("bent.obj", points, faces)
        self.cage("bent.obj", "--vertices", 40)
        self.assertRegex(self.symmetry, "^; (symmetric about .*; |not symmetric; )off by 1.* % about x")
        for options, expected in [(["--symmetric", "x"], "; symmetric about x = 1.975 (the model is off by "),
                                  (["--symmetry", 0.05], "; symmetric about x = 1.975 within 1.")]:
            self.cage("bent.obj", "--vertices", 40, *options)
            self.assertTrue(self.symmetry.startswith(expected), self.symmetry)
            xs = sorted(p[0] for p in self.read_ovm_positions("rest.ovm"))
            for low, high in zip(xs, reversed(xs)):
                self.assertAlmostEqual(low + high, 2 * 1.975, 12)
            self.assert_all_inside("bent.obj")

    def test_wrong_arguments_name_themselves(self):
        for options, message, code in [
                (["--vertices", 7], "--vertices", 2),
                (["--vertices", 100, "--size", 1], "--size", 2),
                (["--size", 0], "--size", 2),
                (["--margin", -0.5], "--margin", 2),
                (["--shell", 0], "--shell", 2),
                (["--symmetric", "zx"], "--symmetric", 2),
                (["--symmetry", -1], "--symmetry", 2),
                (["--size", 1e-9], "--size: expected at least", 2)]:
            self.assertIn(message, self.error_of("shape", "cage", "tube.obj", *options, "-o",
                                                 "x.ovm", code=code))
            self.assertFalse((self.path / "x.ovm").exists())

    def test_models_without_a_surface(self):
        self.write("points.obj", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [])
        self.assertIn("points.obj: has no faces",
                      self.error_of("shape", "cage", "points.obj", "-o", "x.ovm"))
        self.write("point.obj", [(1, 2, 3)] * 3, [(0, 1, 2)])
        self.assertIn("point.obj: all points of the model are at one place",
                      self.error_of("shape", "cage", "point.obj", "-o", "x.ovm"))

    def test_the_cells_of_a_volume_have_a_boundary(self):
        self.run_program("shape", "box", "--cells", 3, 3, 3, "-o", "mesh.vtu")
        self.run_program("shape", "cage", "mesh.vtu", "--vertices", 20, "-o", "cage.ovm")
        self.put("a.su2", "NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\nNMARK= 0\n")
        self.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        for name in ("a.su2", "a.obj"):
            self.run_program("shape", "cage", name, "--vertices", 20, "-o", name + ".ovm")
        self.assertEqual(self.text("a.su2.ovm"), self.text("a.obj.ovm"))

    def test_the_output_cannot_be_a_model(self):
        before = self.bytes("tube.obj")
        self.error_of("shape", "cage", "tube.obj", "-o", "tube.obj")
        self.assertEqual(self.bytes("tube.obj"), before)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
