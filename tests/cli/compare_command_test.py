#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier compare`.

    compare_command_test.py PATH_OF_ESPALIER
"""

import subprocess
import sys
import unittest

import program
from program import CliTest


class Compare(CliTest):
    def setUp(self):
        super().setUp()
        result = subprocess.run([program.ESPALIER, "compare"], capture_output=True, text=True)
        if "without OpenSubdiv" in result.stderr:
            self.skipTest("espalier was built without OpenSubdiv")

    def test_meshes_and_lattices_agree_with_opensubdiv(self):
        self.write_mesh(["t crease 2/1/0 5 6 2.5", "t interpolateboundary 1/0/0 2"])
        self.run_program("shape", "star", "-o", "star.vtu")
        output = self.run_program("compare", "mesh.obj", "star.vtu", "-n", 2).stdout
        lines = output.splitlines()
        self.assertEqual(len(lines), 5, output)
        for line, name, level in zip(lines, ["mesh.obj"] * 2 + ["star.vtu"] * 2, [1, 2, 1, 2]):
            self.assertTrue(line.startswith(name), line)
            self.assertIn(f"level {level}", line)
            self.assertTrue(line.endswith("agrees"), line)
        self.assertIn("2 of 2 files agree with OpenSubdiv", lines[-1])
        self.assertEqual(self.run_program("compare", "mesh.obj", "--quiet").stdout, "")

    def test_every_boundary_mode(self):
        self.write_mesh()
        for options in [["--boundary", "edge-only"], ["--boundary", "open"],
                        ["--creasing", "chaikin"], ["--triangles", "smooth"]]:
            self.run_program("compare", "mesh.obj", "-n", 2, *options)

    def test_report(self):
        self.write_mesh()
        self.run_program("shape", "torus", "-o", "torus.ovm")
        self.run_program("compare", "mesh.obj", "torus.ovm", "-n", 2, "--html", "report.html")
        report = self.text("report.html")
        for text in ["<!DOCTYPE html>", "mesh.obj", "torus.ovm", "<svg"]:
            self.assertIn(text, report)
        for outside in ["<script src", "<link", "@import", "src=\"http"]:
            self.assertNotIn(outside, report)
        self.assertIn("mesh.obj", self.error_of("compare", "mesh.obj", "--html", "mesh.obj"))

    def write_creased_octahedron(self, name):
        """Where semi-sharp edges meet, OpenSubdiv and we add up their sharpness in single precision,
        in different orders: weights differ by some 1e-9, more than the bound of 1e-14."""
        positions = ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1"]
        faces = ["1 3 5", "3 2 5", "2 4 5", "4 1 5", "3 1 6", "2 3 6", "4 2 6", "1 4 6"]
        sharpness = {(0, 2): 2.8, (0, 3): 1.8, (0, 4): 1.9, (0, 5): 2.4, (1, 2): 3.8, (1, 3): 1.8,
                     (1, 4): 2.9, (1, 5): 1.4, (2, 4): 2.3, (2, 5): 1.1, (3, 4): 3.4, (3, 5): 1.7}
        lines = [f"v {position}" for position in positions] + [f"f {face}" for face in faces]
        lines += [f"t crease 2/1/0 {a} {b} {value}" for (a, b), value in sharpness.items()]
        self.put(name, "\n".join(lines) + "\n")

    def test_differences_have_an_exit_code_of_their_own(self):
        self.write_mesh()
        self.write_creased_octahedron("creased.obj")
        arguments = ["mesh.obj", "creased.obj", "-n", 3, "--creasing", "chaikin"]
        result = self.run_program("compare", *arguments, "--html", "report.html", code=3)
        self.assertRegex(result.stderr, r"^espalier: creased.obj: differs from OpenSubdiv \S+ at level "
                                        r"[23]\n$")
        lines = result.stdout.splitlines()
        self.assertEqual([line.split()[-1] for line in lines if line.startswith("mesh.obj")],
                         ["agrees"] * 3)
        self.assertRegex(result.stdout, r"\ncreased.obj  level 3 [^\n]* DIFFERS\n")
        self.assertIn("note: OpenSubdiv adds three or more semi-sharp values", result.stdout)
        self.assertNotIn("files agree", result.stdout)
        self.assertIn("differs", self.text("report.html"))
        self.assertEqual(self.run_program("compare", *arguments, "--quiet", code=3).stdout, "")
        # A file that cannot be compared decides the exit code.
        self.run_program("compare", *arguments, "none.obj", "--quiet", code=1)
        # The tags cause the difference: without them both agree.
        text = self.text("creased.obj")
        self.put("creased.obj", text.split("t crease")[0])
        self.run_program("compare", *arguments)

    def test_what_cannot_be_compared_is_named_and_fails(self):
        self.write_mesh()
        self.run_program("shape", "box", "--cells", 3, 3, 3, "-o", "box.ovm")
        result = self.run_program("compare", "none.obj", "mesh.obj", "-n", 1, code=1)
        self.assertIn("none.obj  could not be compared", result.stdout)
        self.assertIn("agrees", result.stdout)
        self.assertIn("none.obj: cannot open", result.stderr)
        error = self.error_of("compare", "none.obj", "neither.obj", "mesh.obj", "--quiet")
        self.assertIn("none.obj: cannot open", error)
        self.assertIn("1 more of 3", error)
        error = self.error_of("compare", "box.ovm", "--boundary", "open")
        self.assertIn("box.ovm: with the boundary mode 'open'", error)
        # With the boundary mode open, nothing is left of such a small mesh.
        self.put("small.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        self.error_of("compare", "small.obj", "--boundary", "open")
        self.assertIn("no folder", self.error_of("compare", "mesh.obj", "--html", "none/r.html"))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
