#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier shape`: the inventory, and merges.

    shape_command_test.py PATH_OF_ESPALIER
"""

import sys
import unittest

import program
from program import CliTest


class Shapes(CliTest):
    def test_every_shape_is_written_in_every_format_and_reads_back(self):
        names = ["box", "cylinder", "torus", "star", "barbell", "arm", "tetrahedron", "cube",
                 "octahedron", "dodecahedron", "icosahedron", "prism", "pyramid", "bipyramid"]
        for name in names:
            levels = []
            for extension in ["ovm", "vtu", "vtk"]:
                file = f"{name}.{extension}"
                self.run_program("shape", name, "-o", file, "--quiet")
                report = self.info(file, "-n", 1)["levels"]
                self.assertEqual(report[0]["inverted_cells"], 0, name)
                # Volumes are sums over faces, and formats may change the order of faces.
                levels.append([{key: level[key] for key in level if "volume" not in key}
                               for level in report])
            self.assertEqual(levels[0], levels[1], name)
            self.assertEqual(levels[0], levels[2], name)

    def test_options_and_their_errors(self):
        self.run_program("shape", "box", "--cells", 4, 2, 1, "--min", -1, -1, -1, "-o", "b.ovm")
        report = self.info("b.ovm", "-n", 0)
        self.assertEqual(report["bounds"], [[-1, -1, -1], [1, 1, 1]])
        self.assertEqual(report["levels"][0]["counts"]["cells"], 8)
        for options, message in [
                (["box", "--cells", 0, 1, 1], "--cells[0]: expected 1 or more, got 0"),
                (["box", "--min", 1, 1, 1, "--max", 0, 0, 0],
                 "--max[0]: expected a number above --min[0] (1), got 0"),
                (["torus", "--minor-radius", 3],
                 "--minor-radius: expected a number below --major-radius (1), got 3"),
                (["torus", "--grid", 0], "--grid: expected 1 or more, got 0"),
                (["arm", "--joint", 0, 0, 0, 1, "--joint", 0, 0, 0, 1],
                 "--joint[1].position: expected a place other than the one of the joint before, "
                 "got (0, 0, 0)"),
                (["arm", "--joint", 0, 0, 0, 1], "--joint: expected 2 or more, got 1"),
                (["barbell", "--end-radius", 1e308],
                 "--end-radius: expected a radius whose square is finite, got 1e+308"),
                (["cylinder", "--to", 0, 0, 0],
                 "--to: expected a point other than --from, got (0, 0, 0)"),
                (["merge", "b.ovm", "b.ovm", "--tolerance", 1],
                 "--tolerance: expected a number from 0 to below 1, a fraction of the whole size, "
                 "got 1")]:
            self.assertEqual(self.error_of("shape", *options, "-o", "c.ovm", code=2),
                             f"espalier: {message}\n")
        self.assertFalse((self.path / "c.ovm").exists())
        self.assertIn(".foo", self.error_of("shape", "box", "-o", "c.foo"))
        self.error_of("shape", "nonsense", "-o", "c.ovm", code=2)
        self.error_of("shape", "arm", "--joint", "1,2,x,4", "-o", "c.ovm", code=2)

    def test_merge(self):
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", 1, 0, 0, "--max", 2, 1, 1, "-o", "b.ovm")
        self.assertEqual(self.run_program("shape", "merge", "a.ovm", "b.ovm", "-o", "ab.ovm").stdout,
                         "ab.ovm: 12 vertices, 2 cells; 4 vertices welded, 1 face shared\n")
        self.assertEqual(self.info("ab.ovm", "-n", 0)["levels"][0]["counts"],
                         {"vertices": 12, "edges": 20, "faces": 11, "cells": 2})

    def test_merges_of_parts_that_share_no_face_need_allow_separate(self):
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "two.ovm")
        self.run_program("shape", "box", "--cells", 3, 3, 2, "--min", 0, 0, 1, "--max", 1, 1, 2,
                         "-o", "three.ovm")
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", .5, .5, .5, "--max", 2, 2, 2, "-o", "over.ovm")
        for first, second, size, counts in [
                ("two.ovm", "three.ovm", "71 vertices, 26 cells", "4 vertices welded, 0 faces shared"),
                ("a.ovm", "over.ovm", "16 vertices, 2 cells", "0 vertices welded, 0 faces shared")]:
            error = self.error_of("shape", "merge", first, second, "-o", "m.ovm")
            self.assertRegex(error, rf"^espalier: {second}: is not joined to {first}: .*{counts}"
                                    ".*--allow-separate")
            self.assertFalse((self.path / "m.ovm").exists())
            self.assertEqual(self.run_program("shape", "merge", first, second, "--allow-separate",
                                              "-o", "m.ovm").stdout, f"m.ovm: {size}; {counts}\n")
            (self.path / "m.ovm").unlink()

    def test_refused_merges_name_the_files(self):
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", 5, 0, 0, "--max", 6, 1, 1, "-o", "far.ovm")
        self.run_program("shape", "merge", "far.ovm", "a.ovm", "--allow-separate",
                         "-o", "two.vtu")
        self.assertEqual(self.error_of("shape", "merge", "two.vtu", "a.ovm", "-o", "m.vtu"),
                         "espalier: cell 1 of two.vtu, cell 0 of a.ovm would become one cell; "
                         "each cell may be in one lattice only\n")
        self.run_program("shape", "box", "--cells", 2, 1, 1, "--max", 2, 1, 1, "-o", "row.ovm")
        self.assertRegex(self.error_of("shape", "merge", "row.ovm", "a.ovm", "-o", "m.vtu"),
                         r"^espalier: face \d+ of row.ovm, face \d of a.ovm would become one "
                         r"face of more than two cells\n$")
        self.assertRegex(self.error_of("shape", "merge", "far.ovm", "a.ovm", "--tolerance", 0.5,
                                       "-o", "m.vtu"),
                         r"^espalier: vertices \d and \d of cell 0 of far.ovm would become")
        self.assertFalse((self.path / "m.vtu").exists())

    def test_a_file_with_the_name_of_an_option_is_no_option(self):
        self.run_program("shape", "box", "-o", "output.vtu")
        self.run_program("shape", "box", "--min", 1, 0, 0, "--max", 2, 1, 1, "-o", "a.vtu")
        self.put("a.vtu", self.text("a.vtu").replace(
            "<PointData>", '<PointData><DataArray type="Float64" Name="t" format="ascii">'
                           "0 0 0 0 0 0 0 0</DataArray>"))
        for inputs in [("a.vtu", "output.vtu"), ("output.vtu", "a.vtu")]:
            self.assertEqual(self.error_of("shape", "merge", *inputs, "-o", "c.vtu"),
                             "espalier: output.vtu lacks attribute 't', which a.vtu has\n")

    def test_a_merge_does_not_replace_an_input(self):
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", 1, 0, 0, "--max", 2, 1, 1, "-o", "b.ovm")
        before = self.bytes("b.ovm")
        self.assertIn("b.ovm: is also an input",
                      self.error_of("shape", "merge", "a.ovm", "b.ovm", "-o", "b.ovm"))
        self.assertEqual(self.bytes("b.ovm"), before)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
