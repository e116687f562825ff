#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An editor mesh that Blender imports, changes and exports is a pose, and Blender reads models that Espalier
converts. Skipped if there is no Blender.

    blender_test.py PATH_OF_ESPALIER
"""

import json
import pathlib
import shutil
import subprocess
import sys
import unittest

import program
from program import CliTest

# Imports an editor mesh, moves its last vertex by (0.5, 0.25, 0.125), and exports it.
ROUND_TRIP = pathlib.Path(__file__).with_name("blender_round_trip.py")
# Imports files, and writes their parts as JSON.
READ = pathlib.Path(__file__).with_name("blender_read.py")

# A pentagon that is not convex, a square and a triangle, with one normal for each point.
FIGURE = """# vtk DataFile Version 3.0
a
ASCII
DATASET POLYDATA
POINTS 8 double
0 0 0 0.5 0.25 0 1 0 0 1 1 0 0 1 0 1 2 0 0 2 0 0.5 3 0.1
POLYGONS 3 15
5 0 1 2 3 4
4 4 3 5 6
3 6 5 7
POINT_DATA 8
NORMALS n double
0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0.6 0.8 0 0.6 0.8 0 0.6 0.8
"""
LOOPS = [[0, 1, 2, 3, 4], [4, 3, 5, 6], [6, 5, 7]]


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Blender(CliTest):
    def run_blender(self, script, *arguments):
        result = subprocess.run(
            ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
             script, "--", *arguments],
            cwd=self.path, capture_output=True, text=True, timeout=250)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_blender_keeps_the_vertices_and_faces_of_a_cage(self):
        # Cells of several kinds, with faces inside the lattice, of three to six vertices.
        self.run_program("shape", "cylinder", "--sectors", 6, "--layers", 3, "-o", "rest.ovm")
        self.run_program("refine", "rest.ovm", "-n", 0, "-o", "editor.obj")
        rest = self.read_ovm_positions("rest.ovm")
        self.run_blender(ROUND_TRIP, "editor.obj", "posed.obj")
        posed = self.read_points("posed.obj")
        expected = [*rest[:-1], tuple(a + b for a, b in zip(rest[-1], (0.5, 0.25, 0.125)))]
        # Blender writes six digits after the decimal point.
        self.assert_close(posed, expected, 1e-6)
        self.assertEqual(self.text("posed.obj").count("\nf "), self.text("editor.obj").count("\nf "))
        report = self.run_program("check", "posed.obj", "--rest", "rest.ovm").stdout
        self.assertIn("inverted by the pose    0", report)

    def test_blender_reads_models_that_are_converted(self):
        self.run_program("shape", "box", "--min", -9, -9, -9, "--max", 9, 9, 9, "-o", "rest.ovm")
        self.put("figure.vtk", FIGURE)
        files = ["a.obj", "a.ply", "a.stl"]
        for name in files:
            self.deform("figure.vtk", "rest.ovm", "rest.ovm", out=name)
        self.run_blender(READ, "read.json", *files)
        read = json.loads(self.text("read.json"))
        numbers = [float(word) for word in FIGURE.splitlines()[5].split()]
        points = [numbers[i:i + 3] for i in range(0, len(numbers), 3)]
        for name in ("a.obj", "a.ply"):
            with self.subTest(name=name):
                # Blender has floats.
                self.assert_close(read[name]["vertices"], points, 1e-6)
                self.assertEqual(read[name]["faces"], LOOPS)
        # Blender keeps the normals of corners of an .obj; its reader of .ply leaves them out. It
        # stores them in 16 bits.
        normals = [(0, 0, 1)] * 5 + [(0, 0, 1), (0, 0, 1), (0, .6, .8), (0, .6, .8)]
        self.assert_close(read["a.obj"]["normals"], normals + [(0, .6, .8)] * 3, 1e-4)
        # Blender joins the corners of facets. The pentagon has three triangles, the square two.
        self.assert_close(sorted(read["a.stl"]["vertices"]), sorted(points), 1e-6)
        self.assertEqual(sorted(map(len, read["a.stl"]["faces"])), [3] * 6)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
