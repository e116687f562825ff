#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Surfaces and meshes that OpenFOAM writes for VTK are models, and OpenFOAM reads them back after they
were deformed. Skipped if there is no OpenFOAM.

    openfoam_test.py PATH_OF_ESPALIER
"""

import math
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

import program
from program import CliTest

HEADER = "FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n"

# A cube of 3 x 3 x 3 cells, and a field.
CASE = {
    "system/controlDict": "application none; startFrom startTime; startTime 0; stopAt endTime; "
                          "endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; "
                          "writeFormat ascii; writePrecision 10;",
    "system/fvSchemes": "ddtSchemes {} gradSchemes { default Gauss linear; } divSchemes {} "
                        "laplacianSchemes {} interpolationSchemes { default linear; } "
                        "snGradSchemes {}",
    "system/fvSolution": "",
    "system/blockMeshDict": "vertices ((0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 1) (1 0 1) (1 1 1) "
                            "(0 1 1)); blocks (hex (0 1 2 3 4 5 6 7) (3 3 3) "
                            "simpleGrading (1 1 1)); boundary (walls { type wall; faces "
                            "((0 3 2 1) (4 5 6 7) (0 4 7 3) (1 2 6 5) (0 1 5 4) (3 7 6 2)); });",
    "0/T": "dimensions [0 0 0 1 0 0 0]; internalField uniform 1; "
           "boundaryField { walls { type zeroGradient; } }",
}

# Samples a cut through the cube and its skin.
SAMPLES = """type surfaces; libs (sampling); writeControl writeTime; surfaceFormat vtk; fields (T);
interpolationScheme cellPoint; formatOptions {{ vtk {{ legacy {}; format {}; }} }}
surfaces (cut {{ type cuttingPlane; planeType pointAndNormal;
                 pointAndNormalDict {{ point (0.5 0.5 0.5); normal (1 1 1); }} interpolate true; }}
          skin {{ type patch; patches (walls); }});
"""

SETTINGS = pathlib.Path("/usr/share/openfoam")


@unittest.skipUnless(shutil.which("foamToVTK") and SETTINGS.exists(), "OpenFOAM is not installed")
class OpenFoam(CliTest):
    def foam(self, *command):
        environment = dict(os.environ, WM_PROJECT_DIR=str(SETTINGS), FOAM_ETC=str(SETTINGS / "etc"))
        result = subprocess.run(command, cwd=self.path, env=environment, capture_output=True,
                                text=True, timeout=60)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def write_case(self):
        for name, text in CASE.items():
            (self.path / name).parent.mkdir(exist_ok=True)
            kind = "volScalarField" if name == "0/T" else "dictionary"
            self.put(name, HEADER.format(kind, pathlib.Path(name).name) + text + "\n")
        (self.path / "constant").mkdir()
        self.foam("blockMesh")

    def deformed(self, model, out):
        """Makes a box around a model, twists it, and deforms the model."""
        self.run_program("shape", "around", model, "-o", "rest.vtu")
        self.run_program("pose", "rest.vtu", "--twist", "z", 90, "-o", "posed.vtu")
        return self.deform(model, "rest.vtu", "posed.vtu", out=out)

    def test_surfaces_are_models(self):
        self.write_case()
        self.foam("foamToVTK")
        self.foam("foamToVTK", "-legacy", "-ascii")
        self.foam("surfaceMeshExtract", "extracted.vtk")
        # foamToVTK names its folders after the folder of the case.
        walls = next(self.path.glob("VTK/*/boundary/walls.vtp")).relative_to(self.path)
        surfaces = [(str(walls), 54), ("VTK/walls/walls_0.vtk", 54), ("extracted.vtk", 54)]
        for name, legacy, coding in (("new", "false", "ascii"), ("newBinary", "false", "binary"),
                                     ("old", "true", "ascii"), ("oldBinary", "true", "binary")):
            self.put("system/" + name, SAMPLES.format(legacy, coding))
            self.foam("postProcess", "-func", name)
            extension = "vtk" if legacy == "true" else "vtp"
            surfaces += [(f"postProcessing/{name}/0/skin.{extension}", 54),
                         (f"postProcessing/{name}/0/cut.{extension}", 84)]
        for model, faces in surfaces:
            with self.subTest(model=model):
                report = self.info(model)
                self.assertEqual((report["faces"], report["bounds"], report["closed"]),
                                 (faces, [[0, 0, 0], [1, 1, 1]], faces == 54))
                out = "out" + pathlib.Path(model).suffix
                self.assertEqual(self.deformed(model, out).stderr, "")
                moved = self.info(out)
                self.assertEqual((moved["faces"], moved["points"]), (faces, report["points"]))
                # OpenFOAM reads .obj and ASCII .vtk; both have the deformed points.
                self.deformed(model, "out.obj")
                points = self.read_points("out.obj")
                for readable in ["out.obj"] + [out] * (out == "out.vtk" and "Binary" not in model):
                    self.foam("surfaceConvert", readable, "again.obj")
                    # OpenFOAM writes six digits, and may drop and reorder points.
                    again = self.read_points("again.obj")
                    for point in points:
                        self.assertLess(min(math.dist(point, other) for other in again), 1e-5)
                    self.assertLessEqual(len(again), len(points))
                result = self.deformed(model, "out.stl")
                self.assertIn("54 faces are split into 108 triangles" if faces == 54
                              else "data that are not written", result.stderr)
                self.foam("surfaceCheck", "out.stl")

    def test_a_mesh_is_a_model_and_a_lattice(self):
        self.write_case()
        self.foam("foamToVTK")
        self.foam("foamToVTK", "-legacy")
        for mesh in [*self.path.glob("VTK/*/internal.vtu"), *self.path.glob("VTK/*_0.vtk")]:
            mesh = str(mesh.relative_to(self.path))
            with self.subTest(mesh=mesh):
                out = "out" + pathlib.Path(mesh).suffix
                self.assertEqual(self.deformed(mesh, out).stderr, "")
                self.assertIn("inverted by the pose    0",
                              self.run_program("check", out, "--rest", mesh).stdout)
                self.assertIn("cannot hold 27 cells of VTK's type 12 (hexahedron)",
                              self.error_of("deform", mesh, "--rest", "rest.vtu", "--to",
                                            "posed.vtu", "-o", "out.stl"))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
