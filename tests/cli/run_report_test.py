#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What deform, bind and apply report: as text and as JSON, and that it is so.

    run_report_test.py PATH_OF_ESPALIER
"""

import json
import os
import re
import struct
import subprocess
import sys
import unittest

import program
from program import CliTest, icosphere_points

POINT = 24  # bytes of three coordinates in double precision
BINDING = ["reading", "binding"]


class Report(CliTest):
    def setUp(self):
        super().setUp()
        self.write_model(icosphere_points(500))
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "rest.vtu")
        for name, top in [("a.ovm", 2), ("b.vtk", 3), ("c.vtu", 4)]:
            self.run_program("shape", "box", "--cells", 2, 2, 2, "--max", 1, 1, top, "-o", name)
        self.bind = ["bind", "model.obj", "--rest", "rest.vtu", "-n", 2, "-o", "m.espb"]
        self.deform = ["deform", "model.obj", "--rest", "rest.vtu", "-n", 2, "-o", "out.obj",
                       "--to"]
        self.apply = ["apply", "m.espb", "-o", "out.obj", "--to"]

    def report(self, *arguments):
        """The report, its stages by name, and their names in order."""
        report = json.loads(self.run_program(*arguments, "--report", "json").stdout)
        names = [stage["name"] for stage in report["stages"]]
        self.assertEqual(len(set(names)), len(names))
        for stage in report["stages"]:
            self.assertEqual(set(stage), {"name", "seconds", "bytes", "gigabytes_per_second"})
            self.assertGreater(stage["seconds"], 0)
            if stage["bytes"] is not None:
                # The same quotient, with roundings in another order.
                self.assertAlmostEqual(stage["gigabytes_per_second"] * 1e9 * stage["seconds"] /
                                       stage["bytes"], 1, delta=1e-14)
        return report, {stage["name"]: stage for stage in report["stages"]}, names

    def size(self, *names):
        return sum((self.path / name).stat().st_size for name in names)

    def test_bind_says_what_the_files_hold(self):
        report, stages, names = self.report(*self.bind)
        self.assertEqual(report["points"], {"inside": 500, "outside": 0, "not_converged": 0, "not_bound": 0})
        self.assertEqual(report["kept"], 0)
        self.assertLess(report["largest_residual"], 1e-12)
        # The header of the file contains the sizes: io/binding_file.h.
        rows, columns, entries = struct.unpack("<3q", self.bytes("m.espb")[32:56])
        matrix = report["matrix"]
        self.assertEqual([matrix["rows"], matrix["columns"], matrix["entries"]],
                         [rows, columns, entries])
        self.assertEqual([rows, columns], [500, 27])
        # Offsets take 8 bytes, columns 4, weights 8.
        self.assertEqual(matrix["bytes"], 8 * (rows + 1) + 12 * entries)
        self.assertEqual(names, [*BINDING, "writing"])
        self.assertEqual(stages["reading"]["bytes"], self.size("model.obj", "rest.vtu"))
        self.assertEqual(stages["binding"]["bytes"], matrix["bytes"])
        self.assertEqual(stages["writing"]["bytes"], self.size("m.espb"))
        self.assertGreater(report["peak_memory"], matrix["bytes"])

    def test_poses_add_up(self):
        matrix = self.report(*self.bind)[0]["matrix"]
        poses = ["a.ovm", "b.vtk", "c.vtu", "a.ovm", "b.vtk"]  # More than deform does without D.
        outputs = [f"out.{i:04}.obj" for i in range(5)]
        a_pose = matrix["bytes"] + (matrix["rows"] + matrix["columns"]) * POINT
        for command, inputs, first in [(self.apply, ["m.espb"], ["reading"]),
                                       (self.deform, ["model.obj", "rest.vtu"], BINDING)]:
            report, stages, names = self.report(*command, *poses)
            self.assertEqual(names, [*first, "applying", "writing"])
            self.assertEqual(stages["reading"]["bytes"], self.size(*inputs, *poses))
            self.assertEqual(stages["applying"]["bytes"], 5 * a_pose)
            self.assertEqual(stages["writing"]["bytes"], self.size(*outputs))
            self.assertEqual(report["matrix"], matrix)
            self.assertEqual(report["points"],
                             {"inside": 500, "outside": 0, "not_converged": 0, "not_bound": 0})
            self.assertEqual(self.report(*self.apply, "a.ovm")[1]["applying"]["bytes"], a_pose)

    def test_few_poses_need_no_matrix(self):
        matrix = self.report(*self.bind)[0]["matrix"]
        poses = ["a.ovm", "b.vtk", "c.vtu", "a.ovm"]
        self.run_program(*self.apply, *poses)
        expected = [self.bytes(f"out.{i:04}.obj") for i in range(4)]
        for count in [1, 4]:
            report, stages, names = self.report(*self.deform, *poses[:count])
            self.assertEqual(names, ["reading", "deforming", "writing"])
            self.assertEqual(stages["deforming"]["bytes"], count * 500 * POINT)
            self.assertEqual(report["matrix"], {**matrix, "bytes": None})
            self.assertEqual(report["kept"], 0)
        self.assertEqual([self.bytes(f"out.{i:04}.obj") for i in range(4)], expected)
        text = self.run_program(*self.deform, "a.ovm").stdout
        self.assertRegex(text, r"\nmatrix            500 points × 27 lattice vertices, [0-9.]+ "
                               r"weights for each point that moves, not stored\n")

    def test_text_says_the_same(self):
        self.write_model(icosphere_points(500) + [(1.5, 0.5, 0.5)])
        for command in [self.bind, [*self.deform, "a.ovm"], [*self.apply, "a.ovm"]]:
            text = self.run_program(*command).stdout
            report, _, names = self.report(*command)
            matrix, kept = report["matrix"], report["kept"]
            self.assertEqual(kept, 1)
            self.assertIn("left in place     1 point, whatever the pose\n", text)
            self.assertIn("matrix            %d points × %d lattice vertices, %.1f weights for each "
                          "point that moves, %s\n" % (
                matrix["rows"], matrix["columns"], matrix["entries"] / (matrix["rows"] - kept),
                "%.1f kB" % (matrix["bytes"] / 1000) if matrix["bytes"] else "not stored"), text)
            if "points" in report:
                self.assertIn("points            %(inside)d inside the lattice, %(outside)d outside, "
                              "%(not_converged)d could not be placed\n" % report["points"], text)
                self.assertEqual(report["points"]["outside"], 1)
                self.assertIn("placement error   %.2g: " % report["largest_residual"], text)
            stages = re.findall(r"^(.+?) +[0-9.]+ s  +([0-9.]+ k?B)  +[0-9.]+ GB/s$", text, re.M)
            self.assertEqual([name for name, _ in stages], names)
            for (_, shown), stage in zip(stages, report["stages"]):
                self.assertEqual(shown, "%.1f kB" % (stage["bytes"] / 1000))
            self.assertRegex(text, r"\npeak memory       [0-9.]+ MB\n$")

    def test_what_is_not_known_is_null(self):
        # The second pose goes into a pipe, which has no size: nor have the two together.
        os.mkfifo(self.path / "out.0001.obj")
        with subprocess.Popen(["cat", "out.0001.obj"], cwd=self.path,
                              stdout=subprocess.PIPE) as reader:
            _, stages, _ = self.report(*self.deform, "a.ovm", "b.vtk")
            self.assertTrue(reader.stdout.read().startswith(b"# a comment\nv "))
        self.assertIsNone(stages["writing"]["bytes"])
        self.assertIsNone(stages["writing"]["gigabytes_per_second"])
        self.assertIsNotNone(stages["deforming"]["bytes"])

    def test_quiet_wins_and_errors_leave_no_report(self):
        for command in [self.bind, [*self.deform, "a.ovm"], [*self.apply, "a.ovm"]]:
            result = self.run_program(*command, "--report", "json", "--quiet")
            self.assertEqual(result.stdout + result.stderr, "")
            result = self.run_program(*command[:-1], "none.ovm", "--report", "json", code=1)
            self.assertEqual(result.stdout, "")
            self.assertIn("got xml", self.error_of(*command, "--report", "xml", code=2))


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop())
    unittest.main()
