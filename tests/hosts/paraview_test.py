#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The filter (hosts/vtk) as a plugin of ParaView gives what the program gives. Skipped without ParaView's Python modules.

    paraview_test.py PATH_OF_ESPALIER FOLDER_OF_THE_PYTHON_MODULE [FOLDER_OF_PARAVIEW]

FOLDER_OF_PARAVIEW may hold the files of Debian's package python3-paraview: it cannot be installed beside python3-vtk9.
"""

import os
import pathlib
import subprocess
import sys
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TOP / "tests/cli"), *sys.argv[2:3]]
import program  # noqa: E402
from program import CliTest  # noqa: E402

STEPS = TOP / "tests/hosts/paraview_steps.py"
MODULE, PARAVIEW = (pathlib.Path(path).resolve() for path in (*sys.argv[2:], "", "")[:2])


def run_python(*arguments, **options):
    """Runs Python with the modules of ParaView."""
    modules = PARAVIEW / "usr/lib/python3/dist-packages"
    return subprocess.run([sys.executable, *arguments], env={**os.environ, "PYTHONPATH": str(modules)},
                          stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", timeout=600, **options)


@unittest.skipIf(run_python("-c", "import paraview.simple").returncode, "ParaView's Python modules are not installed")
class ParaView(CliTest):
    def positions(self, name):
        import espalier
        return espalier.read_model(self.path / name).positions

    def expected(self, *options, model="model.vtu"):
        self.run_program("deform", model, "--rest", "rest.vtu", "--to", "pose.vtu", *options, "-o",
                         "expected_" + model, "--quiet")
        return self.positions("expected_" + model)

    def test_the_plugin_gives_what_the_program_gives(self):
        self.run_program("shape", "cylinder", "--sectors", 5, "--core", "polygon", "--layers", 2, "-o",
                         "rest.vtu")
        self.run_program("pose", "rest.vtu", "--twist", "z", 50, "--move", 0.1, 0.2, 0.3, "-o", "pose.vtu")
        self.run_program("refine", "rest.vtu", "-n", 2, "-o", "model.vtu")
        steps = run_python(STEPS, MODULE, cwd=self.path)
        self.assertEqual(steps.returncode, 0, steps.stderr + steps.stdout)

        for name, options in (("default", ["-n", 3]), ("nearest", ["-n", 1, "--outside", "nearest"]),
                              ("limit", ["--limit"]), ("again", ["--limit"])):
            # Kernels for different numbers of rows add in different orders.
            self.assertLess(abs(self.positions(name + ".vtu") - self.expected(*options)).max(), 1e-14, name)
        # The surface has floats of up to 2, which are rounded to 2e-7 at most.
        self.assertLess(abs(self.positions("surface_moved.ply") -
                            self.expected("-n", 3, model="surface.ply")).max(), 4e-7)


if __name__ == "__main__":
    program.ESPALIER = sys.argv[1]
    unittest.main(argv=sys.argv[:1])
