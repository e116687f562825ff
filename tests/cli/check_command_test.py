#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier check`: cells that a pose of a lattice turns inside out.

    check_command_test.py PATH_OF_ESPALIER
"""

import json
import math
import sys
import unittest

import program
from program import CliTest


class Check(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "rest.ovm")

    def pose(self, move, rest="rest.ovm", name="pose.ovm"):
        self.write_pose(name, rest, lambda p: move(*p))

    def check(self, *options, code=0):
        result = self.run_program("check", "pose.ovm", "--rest", "rest.ovm", "--report", "json",
                                  *options, code=code)
        return json.loads(result.stdout), result.stderr

    def write_folded(self):
        """Writes a pose whose corner (1, 1, 1) is at (−2, −2, −2), beyond all other vertices."""
        self.pose(lambda *p: (-2, -2, -2) if p == (1, 1, 1) else p)

    def test_a_valid_pose(self):
        # The pose is twice as wide, so all volumes double. No step on this way folds a cell.
        self.pose(lambda x, y, z: (2 * x, y, z))
        report, errors = self.check("-n", 2, "--max-step", 10)
        self.assertEqual(errors, "")
        self.assertEqual((report["level"], report["cells"]), (2, 8 * 64))
        nothing = {"count": 0, "first": []}
        self.assertEqual((report["inverted"], report["bad_at_rest"]), (nothing, nothing))
        self.assertAlmostEqual(report["smallest_volume_ratio"]["volume_ratio"], 2, delta=1e-10)
        self.assertEqual(report["largest_step"],
                         {"length": 10, "max": 10, "limiting_cell": None, "is_tight": True})
        out = self.run_program("check", "pose.ovm", "--rest", "rest.ovm", "-n", 1).stdout
        for line in ["cells of level 1        64", "inverted by the pose    0",
                     "smallest volume ratio   2 (pose : rest), cell ",
                     "largest safe step       2 of the way from rest to pose, or more"]:
            self.assertIn(line, out)
        self.assertEqual(self.run_program("check", "pose.ovm", "--rest", "rest.ovm",
                                          "--quiet").stdout, "")

    def test_the_way_back_from_a_mirror_image_ends_half_way(self):
        # The volume ratio is 1 − 2t.
        self.pose(lambda x, y, z: (-x, y, z))
        report, _ = self.check("-n", 1, "--list", 100, code=3)
        self.assertEqual(report["inverted"]["count"], 64)
        self.assertEqual([cell["cell"] for cell in report["inverted"]["first"]], list(range(64)))
        self.assertAlmostEqual(report["largest_step"]["length"], 0.5, delta=1e-6)
        self.assertLessEqual(report["largest_step"]["length"], 0.5)

    def test_ratios_are_finite(self):
        """For a mirror image 1e240 times as large, the ratio is below the range of double."""
        self.pose(lambda x, y, z: (1e-80 * x, 1e-80 * y, 1e-80 * z), name="tiny.ovm")
        self.pose(lambda x, y, z: (-1e80 * x, 1e80 * y, 1e80 * z))
        report = json.loads(self.run_program(
            "check", "pose.ovm", "--rest", "tiny.ovm", "-n", 1, "--report", "json", "-o",
            "ratios.vtk", code=3).stdout)
        self.assertEqual(report["smallest_volume_ratio"]["volume_ratio"], -sys.float_info.max)
        self.assertNotIn("inf", self.text("ratios.vtk"))

    def test_a_folded_pose(self):
        self.write_folded()
        report, error = self.check("-n", 2, "--list", 512, code=3)
        inverted = report["inverted"]["first"]
        self.assertEqual(report["inverted"]["count"], len(inverted))
        self.assertGreater(len(inverted), 0)
        self.assertLess(len(inverted), report["cells"])
        self.assertIn("pose.ovm: this pose turns %d of 512 cells of level 2 inside out, the first "
                      "cell %d (in cell %d of the lattice)" %
                      (len(inverted), inverted[0]["cell"], inverted[0]["base_cell"]), error)
        for cell in inverted:
            self.assertLessEqual(cell["volume_ratio"], 0)
            self.assertEqual(len(cell["centre"]), 3)
        least = report["smallest_volume_ratio"]
        self.assertEqual(least["volume_ratio"], min(cell["volume_ratio"] for cell in inverted))
        # No cell is inverted up to the step; just beyond it, the named cell is.
        step = report["largest_step"]
        self.assertTrue(0 < step["length"] < 1)
        for part, code in [(1, 0), (1.001, 3)]:
            t = part * step["length"]
            self.pose(lambda x, y, z, t=t: (1 - 3 * t,) * 3
                            if (x, y, z) == (1, 1, 1) else (x, y, z))
            found, _ = self.check("-n", 2, "--list", 512, code=code)
            self.assertEqual(step["limiting_cell"]["cell"]
                             in [cell["cell"] for cell in found["inverted"]["first"]], code == 3)

    def test_text_names_the_first_few(self):
        self.write_folded()
        out = self.run_program("check", "pose.ovm", "--rest", "rest.ovm", "-n", 2, code=3).stdout
        self.assertRegex(out, r"  cell \d+ \(in cell \d of the lattice\) at \(.*\): volume ratio -")
        self.assertRegex(out, r"  and \d+ more\n")
        self.assertEqual(out.count("  cell "), 5)
        self.assertEqual(len(self.check("-n", 2, "--list", 2, code=3)[0]["inverted"]["first"]), 2)
        self.assertRegex(out, r"largest safe step       0\.\d+ of the way from rest to pose; then cell "
                              r"\d+ \(in cell \d of the lattice\) folds")

    def test_the_refined_pose_with_its_ratios(self):
        self.write_folded()
        for name in ["cells.vtu", "cells.ovm"]:
            self.check("-n", 1, "-o", name, code=3)
            self.assertEqual(self.info(name, "-n", 0)["attributes"],
                             ["volume_ratio", "bad_at_rest"])

    def test_steps_that_are_not_told(self):
        # The top turns by nearly half a turn. The search stops after a bounded amount of work, before
        # it can tell where the cell folds.
        self.run_program("shape", "box", "-o", "rest.ovm")
        a = math.radians(179.999)
        self.pose(lambda x, y, z: (x, y, z) if z == 0 else
                        (math.cos(a) * x - math.sin(a) * y, math.sin(a) * x + math.cos(a) * y, z))
        report, _ = self.check("-n", 1)
        self.assertEqual(report["inverted"]["count"], 0)
        self.assertFalse(report["largest_step"]["is_tight"])
        out = self.run_program("check", "pose.ovm", "--rest", "rest.ovm", "-n", 1).stdout
        self.assertRegex(out, r"largest safe step       at least 0\.\d+ of the way from rest to pose; "
                              r"then cell \d .* may fold")

    def test_the_limit(self):
        # The pinched bar of tests/solve/limit_validity_test.cpp: 1 - 5a/4 in the middle.
        self.run_program("shape", "box", "--cells", 3, 1, 1, "--max", 3, 1, 1, "-o", "rest.ovm")
        self.pose(lambda x, y, z: ({1: 2, 2: 1}.get(x, x), y, z))
        report, error = self.check("--limit", code=3)
        self.assertEqual((report["level"], report["limit_level"], report["cells"]), (0, 3, 3))
        self.assertEqual(report["inverted"]["first"][0]["cell"], 1)
        self.assertAlmostEqual(report["smallest_volume_ratio"]["volume_ratio"], -0.25, delta=1e-3)
        self.assertAlmostEqual(report["largest_step"]["length"], 0.8, delta=1e-5)
        self.assertIn("1 of 3 cells in the limit inside out, the first cell 1 of the lattice", error)
        out = self.run_program("check", "pose.ovm", "--rest", "rest.ovm", "--limit", "-o",
                               "cells.vtu", code=3).stdout
        self.assertIn("cells in the limit      3\n", out)
        self.assertRegex(out, r"largest safe step       0\.\d+ of the way from rest to pose; then cell 1 "
                              r"of the lattice folds")
        self.assertEqual(self.info("cells.vtu", "-n", 0)["attributes"],
                         ["volume_ratio", "bad_at_rest"])
        # The cells of levels approach the limit from below, so they fold earlier.
        self.assertIsNone(self.check("-n", 1, code=3)[0]["limit_level"])
        self.run_program("shape", "box", "-o", "rest.ovm")
        self.assertIn("the complex has no interior vertex", self.error_of(
            "check", "rest.ovm", "--rest", "rest.ovm", "--limit", "--boundary", "open"))

    def test_cells_bad_at_rest_do_not_count(self):
        # The upper layer of cells is flat at rest.
        self.pose(lambda x, y, z: (x, y, min(z, 0.5)), name="flat.ovm")
        text = self.run_program("check", "flat.ovm", "--rest", "flat.ovm", "-n", 1, "--boundary",
                                "sharp", "--report", "json").stdout
        report = json.loads(text)
        self.assertGreater(report["bad_at_rest"]["count"], 0)
        self.assertNotIn("volume_ratio", report["bad_at_rest"]["first"][0])
        self.assertEqual(report["inverted"]["count"], 0)
        self.assertEqual(report["largest_step"]["length"], 2)
        self.pose(lambda x, y, z: (x, y, 0), name="flat.ovm")
        self.assertIn("flat.ovm: all cells are flat or folded at rest",
                      self.error_of("check", "flat.ovm", "--rest", "flat.ovm"))

    def test_refusals(self):
        self.write_folded()
        self.run_program("shape", "cylinder", "-o", "other.ovm")
        for arguments, why in [(["pose.ovm", "--rest", "other.ovm"],
                                "pose.ovm: is not a pose of other.ovm (called the first,"),
                               (["pose.ovm", "--rest", "none.ovm"], "none.ovm"),
                               (["none.ovm", "--rest", "rest.ovm"], "none.ovm"),
                               (["pose.ovm", "--rest", "rest.ovm", "-o", "rest.ovm"],
                                "is also an input"),
                               (["pose.ovm", "--rest", "rest.ovm", "-o", "x.obj"], "x.obj")]:
            self.assertIn(why, self.error_of("check", *arguments))
        self.error_of("check", "pose.ovm", "--rest", "rest.ovm", "-n", 0, code=2)
        for step in (-1, 0, 1e7):
            self.error_of("check", "pose.ovm", "--rest", "rest.ovm", "--max-step", step, code=2)
        self.assertEqual(self.error_of("check", "pose.ovm", "--rest", "rest.ovm", "--list", -1, code=2),
                         "espalier: --list: expected a whole number, 0 to 2147483647, got -1\n")
        self.assertEqual(self.error_of("check", "pose.ovm", "--rest", "", code=2),
                         "espalier: --rest: expected the name of a file, got nothing\n")
        self.pose(lambda x, y, z: (1e95 * x, y, z), name="far.ovm")
        self.assertIn("far.ovm: the pose of vertex",
                      self.error_of("check", "far.ovm", "--rest", "rest.ovm"))
        self.assertIn("far.ovm: the rest of vertex",
                      self.error_of("check", "far.ovm", "--rest", "far.ovm"))
        self.error_of("check", "pose.ovm", code=2)
        self.assertIn("exit code 3", " ".join(self.run_program("check", "--help").stdout.split()))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
