#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A .vtk that Gmsh writes is a lattice. Skipped if there is no Gmsh.

    gmsh_test.py PATH_OF_ESPALIER
"""

import shutil
import subprocess
import sys
import unittest

import program
from program import CliTest

# A box of 2 × 1 × 1 hexahedra, and beside it a box of tetrahedra.
GEOMETRY = """
Point(1) = {0, 0, 0, 1};
line[] = Extrude {1, 0, 0} { Point{1}; Layers{2}; Recombine; };
face[] = Extrude {0, 1, 0} { Line{line[1]}; Layers{1}; Recombine; };
Extrude {0, 0, 1} { Surface{face[1]}; Layers{1}; Recombine; }
Point(100) = {5, 0, 0, 1};
line[] = Extrude {1, 0, 0} { Point{100}; };
face[] = Extrude {0, 1, 0} { Line{line[1]}; };
Extrude {0, 0, 1} { Surface{face[1]}; }
"""


@unittest.skipUnless(shutil.which("gmsh"), "Gmsh is not installed")
class Gmsh(CliTest):
    def test_a_mesh_of_gmsh_is_a_lattice(self):
        self.put("box.geo", GEOMETRY)
        for flags in ([], ["-bin"]):
            subprocess.run(["gmsh", "-3", *flags, "box.geo", "-o", "box.vtk"], cwd=self.path,
                           check=True, capture_output=True, timeout=60)
            result = self.run_program("info", "box.vtk", "-n", 0, "--json")
            self.assertRegex(result.stderr,
                             r"^espalier: box.vtk: skipped 16 vertex cells, \d+ lines and \d+ "
                             r"surface cells, which are not cells of a lattice\n$")
            # The volumes of the two boxes are 1 each.
            self.run_program("refine", "box.vtk", "-n", 1, "-o", "fine.ovm")
            self.assertIn("inverted by the pose    0",
                          self.run_program("check", "box.vtk", "--rest", "box.vtk").stdout)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
