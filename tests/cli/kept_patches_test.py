#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Tests --hold and --slide: patches whose points stay, or stay in their planes, cylinders and lines."""

import json
import math
import sys
import unittest

import program
from program import CliTest

SIDES, ROWS = 12, 3


class KeptPatches(CliTest):
    """A pipe of one layer of hexahedra in SU2's format, in a box that is bent."""

    def setUp(self):
        super().setUp()
        self.points, cells, markers = [], [], {name: [] for name in ("hull", "inner", "inlet", "outlet")}
        for k in range(ROWS + 1):
            for radius in (0.3, 0.5):
                for i in range(SIDES):
                    angle = 2 * math.pi * i / SIDES
                    self.points.append((radius * math.cos(angle), radius * math.sin(angle), k / ROWS))

        def at(i, outer, k):
            return (2 * k + outer) * SIDES + i % SIDES
        for k in range(ROWS):
            for i in range(SIDES):
                cells.append((12, *(at(*corner) for corner in (
                    (i, 0, k), (i, 1, k), (i + 1, 1, k), (i + 1, 0, k),
                    (i, 0, k + 1), (i, 1, k + 1), (i + 1, 1, k + 1), (i + 1, 0, k + 1)))))
                for name, layer in (("inner", 0), ("hull", 1)):
                    markers[name].append((9, at(i, layer, k), at(i + 1, layer, k), at(i + 1, layer, k + 1),
                                          at(i, layer, k + 1)))
        for name, k in (("inlet", 0), ("outlet", ROWS)):
            markers[name] = [(9, at(i, 0, k), at(i, 1, k), at(i + 1, 1, k), at(i + 1, 0, k)) for i in range(SIDES)]
        lines = ["NDIME= 3", f"NELEM= {len(cells)}", *(" ".join(map(str, cell)) for cell in cells),
                 f"NPOIN= {len(self.points)}", *("%.17g %.17g %.17g" % point for point in self.points),
                 f"NMARK= {len(markers)}"]
        for name, faces in markers.items():
            lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(faces)}", *(" ".join(map(str, f)) for f in faces)]
        self.put("pipe.su2", "\n".join([*lines, ""]))
        self.run_program("shape", "box", "--min", -1, -1, -1, "--max", 1, 1, 2, "--cells", 3, 3, 4, "-o", "rest.ovm")
        # The bend moves all points, along and across the pipe.
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (
            p[0] + 0.1 * math.sin(2 * p[2] + 1), p[1] + 0.05 * p[2] * p[0], p[2] + 0.05 * math.cos(3 * p[0])))

    def deform(self, *options, model="pipe.su2", out="out.su2", code=0):
        return self.run_program("deform", model, "--rest", "rest.ovm", "--to", "pose.ovm", "-o", out, *options,
                                code=code)

    def points_in(self, name):
        lines = self.text(name).splitlines()
        first = lines.index(f"NPOIN= {len(self.points)}") + 1
        return [tuple(map(float, line.split())) for line in lines[first:first + len(self.points)]]

    def test_held_points_stay_and_all_others_move(self):
        self.deform("--quiet", out="all.su2")
        free = self.points_in("all.su2")
        result = self.deform("--hold", "inlet", "--hold", "outlet")
        expected = 0
        for rest, moved, now in zip(self.points, free, self.points_in("out.su2")):
            isHeld = rest[2] in (0, 1)
            self.assertEqual(now, rest if isHeld else moved)
            expected = max(expected, math.dist(rest, moved) if isHeld else 0)
        self.assertRegex(result.stdout, r"\nheld +48 points of inlet, outlet; the poses would move them by up to "
                                        rf"{expected:.3g} \(point \d+\)\n")
        report = json.loads(self.deform("--hold", "inlet", "--report", "json").stdout)["held"]
        self.assertEqual((report["points"], report["patches"]), (24, ["inlet"]))
        self.assertAlmostEqual(report["largest_move"], math.dist(self.points[report["point"]], free[report["point"]]),
                               delta=1e-15)
        # A held point need not be in the lattice; but to be moved, a point must be.
        self.run_program("shape", "box", "--min", -1, -1, 0.2, "--max", 1, 1, 2, "-o", "small.ovm")
        options = ("deform", "pipe.su2", "--rest", "small.ovm", "--to", "small.ovm", "--outside", "error", "-o",
                   "out.su2")
        self.run_program(*options, "--hold", "inlet")
        self.assertIn("is outside the lattice", self.error_of(*options))

    def test_slid_points_are_on_their_shapes(self):
        self.deform("--quiet", out="all.su2")
        free = self.points_in("all.su2")
        result = self.deform("--slide", "hull", "--slide", "inlet")
        expected = 0
        for rest, moved, now in zip(self.points, free, self.points_in("out.su2")):
            isOnHull = math.hypot(*rest[:2]) > 0.4
            if isOnHull:
                self.assertAlmostEqual(math.hypot(*now[:2]), 0.5, delta=1e-15)
            if rest[2] == 0:
                self.assertEqual(now[2], 0)
            self.assertNotEqual(now, rest)
            if not isOnHull and rest[2] > 0:
                self.assertEqual(now, moved)
            expected = max(expected, math.dist(moved, now))
        self.assertRegex(result.stdout, r"\nslid +60 points of hull \(cylinder\), inlet \(plane\); the poses would "
                                        rf"take them off by up to {expected:.3g} \(point \d+\)\n")
        report = json.loads(self.deform("--slide", "hull", "--report", "json").stdout)["slid"]
        self.assertEqual((report["points"], report["patches"]), (48, [{"name": "hull", "shapes": ["cylinder"]}]))
        self.assertGreater(report["largest_move"], 0.01)

    def test_both_at_once_and_with_a_pose_that_moves_nothing(self):
        self.deform("--slide", "hull", "--hold", "inlet", "--quiet")
        for rest, now in zip(self.points, self.points_in("out.su2")):
            if rest[2] == 0:
                self.assertEqual(now, rest)
        result = self.run_program("deform", "pipe.su2", "--rest", "rest.ovm", "--to", "rest.ovm", "-o", "out.su2",
                                  "--slide", "hull", "--hold", "inlet")
        self.assertEqual(self.text("out.su2"), self.text("pipe.su2"))
        self.assertIn("24 points of inlet\n", result.stdout)
        self.assertIn("48 points of hull (cylinder)\n", result.stdout)

    def test_cells_beside_the_patches_are_checked(self):
        # A pose that moves all cells by 0.5 along the pipe pulls those at the inlet longer, and turns those at the
        # outlet inside out if the outlet is held.
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (p[0], p[1], p[2] + 0.5))
        self.assertIn("  inverted          0\n", self.deform("--hold", "inlet").stdout)
        self.assertIn("  inverted          12,", self.deform("--slide", "outlet").stdout)
        self.assertIn("nothing was written", self.deform("--slide", "outlet", "--no-inverted", code=3).stderr)

    def test_bind_apply_and_stencils(self):
        self.deform("--hold", "inlet", "--slide", "hull", "--quiet")
        self.run_program("bind", "pipe.su2", "--rest", "rest.ovm", "--hold", "inlet", "-o", "a.espb")
        result = self.run_program("apply", "a.espb", "--to", "pose.ovm", "--slide", "hull", "-o", "applied.su2")
        self.assertEqual(self.text("applied.su2"), self.text("out.su2"))
        self.assertIn("48 points of hull (cylinder); the poses", result.stdout)
        self.run_program("stencils", "rest.ovm", "--points", "pipe.su2", "--hold", "inlet", "-n", 3, "-o", "d.mtx")
        rows = {int(line.split()[0]) - 1 for line in self.text("d.mtx").splitlines()[2:] if not line.startswith("%")}
        self.assertEqual(rows & {i for i, p in enumerate(self.points) if p[2] == 0}, set())
        self.assertEqual(len(rows), len(self.points) - 24)

    def test_groups_of_other_models_slide_too(self):
        self.put("two.obj", "v 0 0 0\nv .5 0 0\nv .5 .5 0\nv 0 .5 0.25\ng low\nf 1 2 3\ng high\nf 1 3 4\n")
        self.deform("--slide", "low", "--quiet", model="two.obj", out="out.obj")
        z = [float(line.split()[3]) for line in self.text("out.obj").splitlines()[:4]]
        self.assertEqual(z[:3], [0, 0, 0])
        self.assertNotEqual(z[3], 0.25)
        self.put("n.obj", "v 0 0 0\nv .5 0 0\nv .5 .5 0\nvn 0 0 1\ng low\nf 1//1 2//1 3//1\n")
        self.assertIn("n.obj: has normals, tangents or splats, which follow the lattice and not the points that slide. "
                      "Add --keep-normals", self.deform("--slide", "low", model="n.obj", out="out.obj", code=1).stderr)
        self.deform("--slide", "low", "--keep-normals", model="n.obj", out="out.obj")

    def test_mistakes_name_the_way_out(self):
        self.put("ball.obj", "".join("v %.17g %.17g %.17g\n" % (
            0.5 * math.cos(i) * math.cos(j), 0.5 * math.sin(i) * math.cos(j), 0.5 * math.sin(j))
            for i in (0, 0.3, 0.6) for j in (0, 0.3, 0.6)) + "g ball\nf 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n")
        error = self.deform("--slide", "ball", model="ball.obj", out="out.obj", code=1).stderr
        self.assertRegex(error, "ball.obj: the points of the patch 'ball' cannot slide: 9 points of it are on no plane and "
                                r"no cylinder; the best cylinder is [\d.e-]+ away from point \d, where [\d.e-]+ is allowed. "
                                "To keep them still, hold the patch")
        self.assertIn("pipe.su2: has no group 'x' of points; it has 'hull', 'inner', 'inlet', 'outlet'",
                      self.deform("--slide", "x", code=1).stderr)
        self.assertIn("pipe.su2: has no group 'x' of points", self.deform("--hold", "x", code=1).stderr)
        self.assertIn("pipe.su2: the patch 'hull' is curved, and points on the straight way to a pose leave it: "
                      "--largest-step works with --slide of planes and lines",
                      self.deform("--slide", "inlet", "--slide", "hull", "--largest-step", code=1).stderr)
        self.deform("--slide", "inlet", "--largest-step")


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
