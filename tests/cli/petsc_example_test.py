#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The example petsc_fit over one and two ranks, against a dense solver on the same D.

    petsc_example_test.py PATH_OF_ESPALIER PATH_OF_PETSC_FIT PATH_OF_MPIRUN
"""

import subprocess
import sys
import unittest

import numpy
import scipy.sparse

import program
from program import CliTest, icosphere_points

PETSC_FIT = ""
MPIRUN = ""


class PetscFit(CliTest):
    def setUp(self):
        super().setUp()
        self.rest = numpy.array(icosphere_points(150))
        self.rest[7] = [9, 8, 7]  # outside: stays
        self.write_model([tuple(p) for p in self.rest])
        self.run_program("shape", "cylinder", "--sectors", 5, "--from", 0.5, 0.5, -0.2,
                         "--to", 0.5, 0.5, 1.2, "--radius", 0.8, "-o", "c.ovm")
        for name in ["D.petsc", "D.npz"]:
            self.run_program("stencils", "c.ovm", "--points", "model.obj", "-n", 2, "-o", name)
        numpy.savetxt(self.path / "rest.txt", self.rest, fmt="%.17g")

    def fit(self, ranks, wanted):
        numpy.savetxt(self.path / "wanted.txt", wanted, fmt="%.17g")
        return subprocess.run([MPIRUN, "-n", str(ranks), PETSC_FIT, "D.petsc", "rest.txt",
                               "wanted.txt", "out.txt"], cwd=self.path, text=True,
                              capture_output=True, timeout=60)

    def test_is_the_least_squares_fit(self):
        # No lattice reaches these, so that all depends on what least means.
        moves = numpy.random.default_rng(3).uniform(-0.1, 0.1, self.rest.shape)
        matrix = scipy.sparse.load_npz(self.path / "D.npz").toarray()
        displacements = numpy.linalg.lstsq(matrix, moves, rcond=1e-10)[0]
        expected = self.rest + matrix @ displacements
        self.assertGreater(numpy.abs(expected - self.rest - moves).max(), 0.01)
        for ranks in [1, 2]:
            result = self.fit(ranks, self.rest + moves)
            self.assertEqual(result.returncode, 0, result.stderr)
            out = numpy.loadtxt(self.path / "out.txt")
            # LSQR stops at 1e-12 of the misses, times the condition of D, some hundreds.
            numpy.testing.assert_allclose(out, expected, rtol=0, atol=1e-9)
            self.assertEqual(list(out[7]), list(self.rest[7]))
            (self.path / "out.txt").unlink()

    def test_too_few_points(self):
        self.assertNotEqual(self.fit(2, self.rest[:-1]).returncode, 0)
        self.assertFalse((self.path / "out.txt").exists())


if __name__ == "__main__":
    MPIRUN = sys.argv.pop(3)
    PETSC_FIT = sys.argv.pop(2)
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
