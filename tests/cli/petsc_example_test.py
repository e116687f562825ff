#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the example petsc_fit on one to three ranks with a dense solver on the D of espalier.

    petsc_example_test.py PATH_OF_ESPALIER PATH_OF_PETSC_FIT PATH_OF_MPIRUN
"""

import pathlib
import re
import subprocess
import sys
import unittest

import numpy
import scipy.sparse

import program
from program import CliTest, icosphere_points

PETSC_FIT = ""
MPIRUN = ""
ROOT = pathlib.Path(__file__).resolve().parents[2]


class PetscFit(CliTest):
    def setUp(self):
        super().setUp()
        self.rest = numpy.array(icosphere_points(150))
        self.rest[7] = [9, 8, 7]  # outside, so it stays
        self.write_model([tuple(p) for p in self.rest])
        self.run_program("shape", "cylinder", "--sectors", 5, "--from", 0.5, 0.5, -0.2,
                         "--to", 0.5, 0.5, 1.2, "--radius", 0.8, "-o", "c.ovm")

    def fit(self, ranks=2, wanted="wanted.obj", out="out.obj", pose="pose.ovm"):
        return subprocess.run([MPIRUN, "-n", str(ranks), PETSC_FIT, "model.obj", "c.ovm", wanted,
                               out, pose], cwd=self.path, text=True, capture_output=True,
                              timeout=60, check=False)

    def assert_refused(self, message, **arguments):
        result = self.fit(**arguments)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(message, result.stderr)
        self.assertFalse((self.path / "out.obj").exists())
        self.assertFalse((self.path / "pose.ovm").exists())

    def test_is_the_least_squares_fit(self):
        # No lattice reaches these targets exactly, so the result depends on the norm that is minimised.
        moves = numpy.random.default_rng(3).uniform(-0.1, 0.1, self.rest.shape)
        self.write_model([tuple(p) for p in self.rest + moves], "wanted.obj")
        self.run_program("stencils", "c.ovm", "--points", "model.obj", "-n", 2, "-o", "D.npz")
        matrix = scipy.sparse.load_npz(self.path / "D.npz").toarray()
        displacements = numpy.linalg.lstsq(matrix, moves, rcond=1e-10)[0]
        expected = self.rest + matrix @ displacements
        self.assertGreater(numpy.abs(expected - self.rest - moves).max(), 0.01)
        lattice = numpy.array(self.read_ovm_positions("c.ovm"))
        for ranks in [1, 2, 3]:
            result = self.fit(ranks)
            self.assertEqual(result.returncode, 0, result.stderr)
            out = self.read_points("out.obj")
            # LSQR stops at 1e-12 of the misses. The error can be larger by the condition number of D,
            # which is a few hundred.
            numpy.testing.assert_allclose(out, expected, rtol=0, atol=1e-9)
            self.assertEqual(list(out[7]), list(self.rest[7]))
            # This D is rank-deficient. The smallest of all solutions is expected.
            numpy.testing.assert_allclose(self.read_ovm_positions("pose.ovm"),
                                          lattice + displacements, rtol=0, atol=1e-9)
            # The program deforms the model in the same way, except for the order of sums.
            self.deform("model.obj", "c.ovm", "pose.ovm", "-n", 2, out="deformed.obj")
            numpy.testing.assert_allclose(self.read_points("deformed.obj"), out, rtol=0, atol=1e-14)
            (self.path / "out.obj").unlink()
            (self.path / "pose.ovm").unlink()

    def test_refuses_other_points(self):
        self.write_model([tuple(p) for p in self.rest[:-1]], "wanted.obj")
        self.assert_refused("wanted.obj: has 149 points; model.obj has 150")
        self.write_model([tuple(p) for p in [*self.rest, self.rest[0]]], "wanted.obj")
        self.assert_refused("wanted.obj: has 151 points; model.obj has 150")

    def test_refuses_malformed_files(self):
        for line, message in [("v 1 2", "wanted.obj:6: "), ("v 1 2 three", "wanted.obj:6: "),
                              ("v 1 2 nan", "wanted.obj: ")]:
            lines = self.text("model.obj").splitlines()
            lines[5] = line
            self.put("wanted.obj", "\n".join(lines))
            self.assert_refused(message)

    def test_says_what_cannot_be_written(self):
        self.assert_refused("/dev/full: cannot write", wanted="model.obj", out="/dev/full")
        self.assert_refused("pose.obj: ", wanted="model.obj", pose="pose.obj")
        result = self.fit(wanted="model.obj", pose="none/pose.ovm")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("none/pose.ovm: cannot ", result.stderr)

    def test_the_documentation_quotes_it(self):
        source = (ROOT / "examples/petsc_fit.cpp").read_text(encoding="utf-8")
        page = (ROOT / "docs/scaling.md").read_text(encoding="utf-8")
        quoted = re.search("```cpp\n(.*?)```", page, re.DOTALL)[1].splitlines()
        self.assertGreater(len(quoted), 3)
        lines = [line.strip() for line in source.splitlines()]
        self.assertEqual([line for line in quoted if line.strip() not in lines], [])


if __name__ == "__main__":
    MPIRUN = sys.argv.pop(3)
    PETSC_FIT = sys.argv.pop(2)
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
