#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The example deform_on_gpu, on a device that is the host, against espalier itself.

    gpu_example_test.py PATH_OF_ESPALIER PATH_OF_DEFORM_ON_GPU PATH_OF_THE_SAME_WITHOUT_A_GPU
"""

import subprocess
import sys
import unittest

import numpy

import program
from program import CliTest, icosphere_points

EXAMPLE = FAKE = ""


class DeformOnGpu(CliTest):
    def setUp(self):
        super().setUp()
        points = icosphere_points(200)
        points[7] = (9, 8, 7)  # outside: stays
        self.write_model(points)
        self.run_program("shape", "cylinder", "--sectors", 5, "--from", 0.5, 0.5, -0.2,
                         "--to", 0.5, 0.5, 1.2, "--radius", 0.8, "-o", "rest.ovm")
        for name, radius in [("wide.ovm", 1.1), ("narrow.ovm", 0.5)]:
            self.run_program("shape", "cylinder", "--sectors", 5, "--from", 0.5, 0.5, -0.1,
                             "--to", 0.5, 0.5, 2, "--radius", radius, "-o", name)

    def run_example(self, path, *arguments):
        return subprocess.run([path, *arguments], cwd=self.path, text=True, capture_output=True,
                              timeout=60, check=False)

    def assert_deformed(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)
        self.deform("model.obj", "rest.ovm", "narrow.ovm", "-n", 3, out="expected.obj")
        expected = numpy.array(self.read_points("expected.obj"))
        self.assertEqual(list(expected[7]), [9, 8, 7])
        # In float: some roundings of 1e-7, of numbers up to 9.
        numpy.testing.assert_allclose(self.read_points("out.obj"), expected, rtol=0, atol=2e-6)

    def test_does_what_the_program_does(self):
        self.assert_deformed(self.run_example(FAKE, "model.obj", "rest.ovm", "wide.ovm",
                                              "narrow.ovm", "out.obj"))

    def test_without_a_device_says_so(self):
        result = self.run_example(EXAMPLE, "model.obj", "rest.ovm", "narrow.ovm", "out.obj")
        if result.returncode == 0:
            self.assert_deformed(result)
        else:
            self.assertRegex(result.stderr, r"^deform_on_gpu: cudaGetDevice has failed: .*\n$")
            self.assertFalse((self.path / "out.obj").exists())


if __name__ == "__main__":
    FAKE = sys.argv.pop(3)
    EXAMPLE = sys.argv.pop(2)
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
