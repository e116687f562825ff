#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks what bench measures, and that its figures are consistent. Speed is not checked.

    bench_command_test.py PATH_OF_ESPALIER
"""

import json
import os
import re
import sys
import unittest

import program
from program import CliTest, icosphere_points

BINDING = ["reading", "binding"]
COMPILING = ["rounding to float", "compiling float", "compiling double"]
FACTORS = ["compiling factors, float", "compiling factors, double"]
STAGES = [*BINDING, "binding in factors", *COMPILING, *FACTORS]
CASES = [("csr", "float", 1), ("csr", "double", 1), ("compiled", "float", 1),
         ("compiled", "double", 1), ("compiled", "float", 12)]
FACTORS_CASES = [("factors", *case) for _, *case in CASES[2:]]
REAL = {"float": 4, "double": 8}


class Bench(CliTest):
    def setUp(self):
        super().setUp()
        self.write_model(icosphere_points(500))
        self.run_program("shape", "cylinder", "--from", 0.5, 0.5, -0.5, "--to", 0.5, 0.5, 1.5,
                         "-o", "rest.ovm")
        self.command = ["bench", "model.obj", "--rest", "rest.ovm", "--seconds", 0.001]

    def report(self, *options):
        before = self.files()
        report = json.loads(self.run_program(*self.command, *options, "--report", "json").stdout)
        self.assertEqual(self.files(), before, "no file is written")
        return report

    def files(self):
        return {name: self.bytes(name) for name in os.listdir(self.path)}

    def assert_close_ratio(self, number, expected):
        # Each figure is a few products and quotients, rounded by 1.1e-16 each.
        self.assertAlmostEqual(number / expected, 1, delta=1e-14)

    def check(self, report, has_factors=True):
        """Every row is listed once, and each figure follows from the others."""
        threads = [triad["threads"] for triad in report["triad"]]
        rows = {(row["evaluator"], row["precision"], row["poses"], row["threads"]): row
                for row in report["apply"]}
        self.assertEqual(len(rows), len(report["apply"]))
        cases = CASES + FACTORS_CASES if has_factors else CASES
        self.assertEqual(set(rows), {(*case, count) for count in threads for case in cases})
        self.assertEqual([stage["name"] for stage in report["stages"]],
                         STAGES if has_factors else BINDING + COMPILING)
        points, entries = report["matrix"]["rows"], report["matrix"]["entries"]
        stages = {stage["name"]: stage["bytes"] for stage in report["stages"]}
        triads = {triad["threads"]: triad["gigabytes_per_second"] for triad in report["triad"]}
        self.assertEqual("factors" in report, has_factors)
        vertices = 0
        if has_factors:
            vertices = report["factors"]["vertices"]
            # Offsets take 8 bytes, columns 4, weights 8.
            self.assertEqual(stages["binding in factors"], 8 * (vertices + 1) + 8 * (points + 1) +
                             12 * report["factors"]["entries"])
        for (evaluator, precision, poses, count), row in rows.items():
            real = REAL[precision]
            table, between = {
                "csr": (8 * (points + 1) + (4 + real) * entries, 0),
                "compiled": (stages["compiling " + precision], 0),
                # The values of the vertices are written once and read once.
                "factors": (stages.get("compiling factors, " + precision), 2 * vertices),
            }[evaluator]
            self.assertGreater(row["milliseconds"], 0)
            self.assert_close_ratio(row["million_points_per_second"],
                                    points / row["milliseconds"] / 1e3)
            self.assert_close_ratio(row["bytes"], table / poses + 3 * real * (points + between))
            self.assert_close_ratio(row["gigabytes_per_second"],
                                    row["bytes"] / row["milliseconds"] / 1e6)
            self.assert_close_ratio(row["speedup"], rows["csr", precision, 1, 1]["milliseconds"] /
                                    row["milliseconds"])
            self.assertGreater(triads[count], 0)
            self.assert_close_ratio(row["share_of_triad"],
                                    row["gigabytes_per_second"] / triads[count])
        return threads

    def test_every_row_is_there(self):
        report = self.report("-n", 2)
        self.assertEqual(report["points"], {"inside": 500, "outside": 0, "not_converged": 0, "not_bound": 0})
        self.assertIn(report["kernels"], ["baseline", "avx2", "avx512"])
        threads = self.check(report)
        # On one core, and in a build without oneTBB, there is only one thread.
        cores = len(os.sched_getaffinity(0))
        self.assertIn(threads, [[1], *([1, most] for most in range(2, cores + 1))])
        stages = {stage["name"]: stage for stage in report["stages"]}
        # Offsets take 8 bytes, columns and weights 4.
        self.assertEqual(stages["rounding to float"]["bytes"],
                         8 * 501 + 8 * report["matrix"]["entries"])
        self.assertGreater(report["peak_memory"], report["matrix"]["bytes"])

    def test_binding_is_that_of_bind(self):
        self.write_model(icosphere_points(50) + [(9, 9, 9)])
        options = ["-n", 1, "--rules", "cse96", "--boundary", "edge-only"]
        report = self.report(*options, "--threads", 1)
        self.assertEqual(self.check(report), [1])
        bound = json.loads(self.run_program("bind", "model.obj", "--rest", "rest.ovm", *options,
                                            "-o", "m.espb", "--report", "json").stdout)
        for key in ["points", "kept", "largest_residual", "matrix"]:
            self.assertEqual(report[key], bound[key])
        self.assertEqual(report["kept"], 1)
        self.assertEqual([stage["bytes"] for stage in report["stages"][:2]],
                         [stage["bytes"] for stage in bound["stages"][:2]])

    def test_other_bases(self):
        self.run_program("shape", "box", "--cells", 3, 3, 3, "--min", -1, -1, -1, "--max", 2, 2, 2,
                         "-o", "rest.ovm")
        for basis in ["bezier", "bspline"]:
            self.check(self.report("--basis", basis, "--threads", 1), has_factors=False)

    def test_points_outside_alone(self):
        self.write_model([(9, 9, 9), (8, 8, 8)])
        report = self.report("--threads", 1)
        self.assertEqual(report["matrix"]["entries"], 0)
        self.assertEqual(report["factors"], {"vertices": 0, "entries": 0})
        self.check(report)
        # Far along the tangent, the weights of D and W are large and of both signs. Results are still
        # within the bound, which depends on the sizes of products, not on their sum.
        report = self.report("--outside", "nearest", "--threads", 1)
        self.assertGreater(report["factors"]["vertices"], 0)
        self.check(report)
        for far in [1e2, 1e4, 1e6]:
            self.write_model([(far, -far, 2 * far), *icosphere_points(50)])
            self.check(self.report("--outside", "nearest", "--threads", 1))

    def test_factors_of_many_points_are_small(self):
        # A row of W has 8 entries, a row of D up to 18, which are all vertices of the lattice.
        self.write_model(icosphere_points(5000))
        report = self.report("-n", 2, "--threads", 1)
        self.check(report)
        self.assertLess(report["factors"]["vertices"], 500)
        self.assertLess(report["factors"]["entries"], report["matrix"]["entries"] / 2)

    def test_lattices_of_all_sizes(self):
        # Also at the ends of the range of float: small numbers are rounded to multiples of the smallest.
        for scale in [1e-43, 1e-20, 1e20]:
            self.write_model([(x * scale, y * scale, z * scale)
                              for x, y, z in icosphere_points(20)])
            self.run_program("shape", "box", "--max", scale, scale, scale, "-o", "rest.ovm")
            self.check(self.report("-n", 1, "--threads", 1))
        self.run_program("shape", "box", "--max", 1e100, 1, 1, "-o", "rest.ovm")
        self.assertIn("rest.ovm: vertex 1 has the coordinate 1e+100", self.error_of(*self.command))

    def test_text(self):
        lines = self.run_program(*self.command, "-n", 1).stdout.splitlines()
        stages = [re.split("  +", line)[0] for line in lines]
        for stage in STAGES:
            self.assertEqual(stages.count(stage), 1, stage)
        # The column of labels is as wide as the longest label.
        matrix = next(line for line in lines if line.startswith("matrix"))
        self.assertEqual(len(matrix) - len(matrix[6:].lstrip()),
                         max(len(stage) for stage in STAGES) + 1)
        head = next(i for i, line in enumerate(lines) if line.startswith("evaluator"))
        for name in ["precision", "poses", "threads", "ms a pose", "Mpoints/s", "GB/s",
                     "speed-up", "of triad"]:
            self.assertIn(name, lines[head])
        rows = [line.split() for line in lines[head + 1:]]
        triads = [row for row in rows if row[0] == "triad"]
        self.assertIn(len(triads), [1, 2])
        for case in [[*map(str, case)] for case in CASES + FACTORS_CASES]:
            self.assertEqual(len([row for row in rows if row[:3] == case]), len(triads), case)
        self.assertEqual(len({len(line) for line in lines[head:-2 - len(triads)]}), 1, "aligned")

    def test_quiet_is_silent(self):
        for options in [[], ["--report", "json"]]:
            result = self.run_program(*self.command, "--threads", 1, *options, "--quiet")
            self.assertEqual(result.stdout + result.stderr, "")

    def test_refusals(self):
        for seconds in [0, -1, "nan", "inf", "long"]:
            self.assertIn("--seconds", self.error_of("bench", "model.obj", "--rest", "rest.ovm",
                                                     "--seconds", seconds, code=2))
        for options, text in [(["-o", "out.obj"], "-o"), (["--to", "rest.ovm"], "--to"),
                              (["--report", "xml"], "xml"), (["-n", 0], "--level"),
                              (["--basis", "bezier", "-n", 2], "--level"),
                              (["--rules", "rats"], "rats")]:
            self.assertIn(text, self.error_of(*self.command, *options, code=2))
        self.assertIn("--rest", self.error_of("bench", "model.obj", code=2))
        self.assertIn("none.obj: ", self.error_of("bench", "none.obj", "--rest", "rest.ovm"))
        self.write_model([(0.5, 0.5, 0.5), (9, 9, 9)])
        self.assertIn("point 1 at (9", self.error_of(*self.command, "--outside", "error"))
        self.assertEqual(sorted(os.listdir(self.path)), ["model.obj", "rest.ovm"])


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop())
    unittest.main()
