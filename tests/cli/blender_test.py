#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A cage that Blender imports, changes and exports is a pose. Skipped if there is no Blender.

    blender_test.py PATH_OF_ESPALIER
"""

import pathlib
import shutil
import subprocess
import sys
import unittest

import program
from program import CliTest

# Imports a cage, moves its last vertex by (0.5, 0.25, 0.125), and exports it.
SCRIPT = pathlib.Path(__file__).with_name("blender_round_trip.py")


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Blender(CliTest):
    def round_trip(self, cage, out):
        result = subprocess.run(
            ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
             SCRIPT, "--", cage, out],
            cwd=self.path, capture_output=True, text=True, timeout=250)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_blender_keeps_the_vertices_and_faces_of_a_cage(self):
        # Cells of several kinds, with faces inside the lattice, of three to six vertices.
        self.run_program("shape", "cylinder", "--sectors", 6, "--layers", 3, "-o", "rest.ovm")
        self.run_program("refine", "rest.ovm", "-n", 0, "-o", "cage.obj")
        rest = self.read_ovm_positions("rest.ovm")
        self.round_trip("cage.obj", "posed.obj")
        posed = self.read_points("posed.obj")
        expected = [*rest[:-1], tuple(a + b for a, b in zip(rest[-1], (0.5, 0.25, 0.125)))]
        # Blender writes six digits after the decimal point.
        self.assert_close(posed, expected, 1e-6)
        self.assertEqual(self.text("posed.obj").count("\nf "), self.text("cage.obj").count("\nf "))
        report = self.run_program("check", "posed.obj", "--rest", "rest.ovm").stdout
        self.assertIn("inverted by the pose    0", report)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
