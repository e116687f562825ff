#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier deform` on the mesh of a volume: the check of its cells, --no-inverted, --largest-step.

    mesh_test.py PATH_OF_ESPALIER
"""

import fractions
import json
import os
import resource
import shutil
import struct
import subprocess
import sys
import unittest

import program
from program import CliTest

# A tetrahedron whose tip is at z = 1, in the formats of simulations.
POINTS = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"]
SU2 = ("NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 4\n" + "\n".join(POINTS) + "\nNMARK= 0\n")
MSH = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n%s$EndNodes\n$Elements\n%d\n%s$EndElements\n"
HEADER = "FoamFile { version 2.0; format ascii; class %s; object x; }\n"
FOAM = {"points": HEADER % "vectorField" + "4(" + "".join(f"({p})" for p in POINTS) + ")\n",
        "faces": HEADER % "faceList" + "4(3(0 2 1)3(0 1 3)3(1 2 3)3(2 0 3))\n",
        "owner": HEADER % "labelList" + "4{0}\n",
        "neighbour": HEADER % "labelList" + "0()\n"}


def numbered(points):
    return "".join(f"{i + 1} {p}\n" for i, p in enumerate(points))


class Mesh(CliTest):
    def setUp(self):
        super().setUp()
        self.put("a.su2", SU2)
        # A lattice of one cell, a level of which is trilinear: z = 0 stays, z = 1 goes to z = -1.
        self.run_program("shape", "box", "--min", -1, -1, 0, "--max", 2, 2, 1, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (p[0], p[1], -p[2]))

    def put_case(self, name):
        folder = self.path / name / "constant/polyMesh"
        folder.mkdir(parents=True)
        for file, text in FOAM.items():
            (folder / file).write_text(text)
        return folder

    def deform_mesh(self, *options, pose="pose.ovm", model="a.su2", out="out.su2", code=0):
        return self.run_program("deform", model, "--rest", "rest.ovm", "--to", pose, "-n", 1, "-o", out,
                                *options, code=code)

    def report(self, *options, **arguments):
        return json.loads(self.deform_mesh("--report", "json", *options, **arguments).stdout)

    def test_an_inverted_cell_is_reported(self):
        result = self.deform_mesh()
        for line in ["mesh of pose.ovm\n", "  cells             1 tetrahedra\n",
                     "  inverted          1, the first cell 0\n",
                     "  worst ratio       -1 (volume in the pose : at rest), cell 0\n",
                     "  largest step      0.499999999999 of the pose inverts no cell; then cell 0 folds\n",
                     "  for a solver      1 errors; 0.499 of the pose has none\n",
                     "    volumes not above 0         0          1  cells"]:
            self.assertIn(line, result.stdout)
        self.assertIn("warning: pose.ovm turns 1 of 1 cells of the mesh inside out, the first cell 0.",
                      result.stderr)
        mesh, = self.report()["meshes"]
        self.assertEqual(mesh["pose"], "pose.ovm")
        self.assertEqual(mesh["cells"], {"tetrahedra": 1, "pyramids": 0, "wedges": 0, "hexahedra": 0,
                                         "polyhedra": 0, "triangles": 0, "quadrilaterals": 0})
        self.assertEqual(mesh["inverted"], {"count": 1, "first": 0})
        self.assertEqual(mesh["bad_at_rest"], {"count": 0, "first": None})
        self.assertAlmostEqual(mesh["smallest_ratio"]["volume_ratio"], -1, delta=1e-12)
        # The determinant is 1 - 2t.
        self.assertAlmostEqual(mesh["largest_step"]["length"], 0.5, delta=1e-12)
        self.assertEqual(mesh["largest_step"]["limiting_cell"], 0)
        self.assertEqual(mesh["written"], 1)
        before, after = mesh["quality"]["before"], mesh["quality"]["after"]
        # At the corners of the other three points, edges have angles of 45 and 60 degrees.
        self.assertAlmostEqual(before["scaled_jacobian"], 0.5 * 2 ** 0.5, delta=1e-12)
        self.assertAlmostEqual(before["smallest_volume"], 1 / 6, delta=1e-15)
        self.assertAlmostEqual(after["smallest_volume"], -1 / 6, delta=1e-15)
        self.assertEqual((before["non_positive_volumes"], after["non_positive_volumes"]), (0, 1))
        self.assertIsNone(after["non_orthogonality"])  # There is no internal face.

    def test_no_inverted_writes_nothing(self):
        error = self.deform_mesh("--no-inverted", code=3).stderr
        self.assertRegex(error, r"^espalier: pose.ovm: this pose turns 1 of 1 cells of a.su2 inside out, the "
                                r"first cell 0; nothing was written. --largest-step goes 0.499999 of the way\n$")
        self.assertFalse((self.path / "out.su2").exists())
        # A good pose before it is not written either.
        self.write_pose("good.ovm", "rest.ovm", lambda p: (p[0], p[1], 2 * p[2]))
        self.run_program("deform", "a.su2", "--rest", "rest.ovm", "--to", "good.ovm", "pose.ovm", "-n", 1,
                         "-o", "out%d.su2", "--no-inverted", code=3)
        self.assertFalse((self.path / "out0.su2").exists())
        self.deform_mesh("--no-inverted", "--quiet", pose="good.ovm")
        self.assertIn("\n0 0 2\n", self.text("out.su2"))

    def test_the_largest_step_is_written(self):
        mesh, = self.report("--largest-step")["meshes"]
        self.assertAlmostEqual(mesh["written"], 0.5, delta=1e-12)
        self.assertEqual(mesh["quality"]["after"]["non_positive_volumes"], 0)
        tip = float(self.text("out.su2").splitlines()[7].split()[2])
        self.assertTrue(0 < tip < 1e-11, tip)
        self.assertEqual(self.text("out.su2").splitlines()[:7], SU2.splitlines()[:7])
        # A pose that inverts nothing is written as it is.
        self.write_pose("good.ovm", "rest.ovm", lambda p: (p[0], p[1], 2 * p[2]))
        mesh, = self.report("--largest-step", pose="good.ovm")["meshes"]
        self.assertEqual((mesh["written"], mesh["largest_step"]["length"]), (1, 1))
        self.assertIn("\n0 0 2\n", self.text("out.su2"))
        self.assertIn("excludes", self.deform_mesh("--largest-step", "--no-inverted", code=2).stderr)

    def test_the_largest_step_allows_for_single_precision(self):
        # At x = 1000, floats are 6e-5 apart.
        self.put("a.vtk", "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
                          "1000 0 0 1000 1 0 1000 0 1 1001 0 0.25\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n")
        self.run_program("shape", "box", "--min", 999, -1, -1, "--max", 1002, 2, 2, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (2000 - p[0], p[1], p[2] + 0.3 * p[0]))
        mesh, = self.report("--largest-step", model="a.vtk", out="out.vtk")["meshes"]
        self.assertLess(mesh["written"], 1)
        self.run_program("deform", "out.vtk", "--rest", "rest.ovm", "--to", "rest.ovm", "-n", 1, "-o",
                         "same.vtk", "--no-inverted")
        report = json.loads(self.run_program("deform", "out.vtk", "--rest", "rest.ovm", "--to", "rest.ovm",
                                             "-o", "same.vtk", "--report", "json").stdout)
        self.assertEqual(report["meshes"][0]["bad_at_rest"]["count"], 0)
        self.assertGreater(report["meshes"][0]["quality"]["before"]["smallest_volume"], 0)

    def test_the_largest_step_allows_for_the_floats_of_an_animation(self):
        # The text could hold any number, but the floats of an animation are 6e-5 apart at x = 1000.
        self.put("a.su2", "NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 4\n1000 0 0\n1000 1 0\n1000 0 1\n"
                          "1001 0 0.25\nNMARK= 1\nMARKER_TAG= a\nMARKER_ELEMS= 4\n5 0 2 1\n5 0 1 3\n"
                          "5 1 2 3\n5 2 0 3\n")
        self.run_program("shape", "box", "--min", 999, -1, -1, "--max", 1002, 2, 2, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (2000 - p[0], p[1], p[2] + 0.3 * p[0]))
        mesh, = self.report("--largest-step", out="out.pc2")["meshes"]
        self.assertTrue(0 < mesh["written"] < mesh["largest_step"]["length"], mesh["written"])
        self.assertGreater(mesh["quality"]["after"]["smallest_volume"], 0)
        a, b, c, d = (struct.unpack_from("<3f", (self.path / "out.pc2").read_bytes(), 32 + 12 * i)
                      for i in range(4))
        u, v, w = ([fractions.Fraction(q) - fractions.Fraction(p) for p, q in zip(a, x)] for x in (b, c, d))
        self.assertGreater(sum(u[i] * (v[i - 2] * w[i - 1] - v[i - 1] * w[i - 2]) for i in range(3)), 0)
        for out in ("out.mdd", "out.glb"):
            mesh, = self.report("--largest-step", out=out)["meshes"]
            self.assertGreater(mesh["quality"]["after"]["smallest_volume"], 0)
        # A pose that is valid in doubles, and flat in floats.
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (1000 + 1e-6 * (p[0] - 1000), p[1], p[2]))
        self.deform_mesh("--no-inverted")
        self.assertIn("turns 1 of 1 cells of a.su2 inside out",
                      self.deform_mesh("--no-inverted", out="out.mdd", code=3).stderr)

    def test_the_step_is_rounded_down(self):
        # The determinant is 1 - t (1 + 2e-13), so the step is just below 1.
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (p[0], p[1], -2e-13 * p[2]))
        result = self.deform_mesh()
        self.assertIn("  inverted          1, the first cell 0\n", result.stdout)
        self.assertIn("  largest step      0.99999999999", result.stdout)
        self.assertIn("0.999999 of the way", result.stderr)

    def test_a_mesh_whose_cells_cannot_be_read_is_refused(self):
        self.put("a.su2", SU2.replace("10 0 1 2 3", "10 0 1 2 9"))
        for option in ([], ["--no-inverted"], ["--largest-step"]):
            self.assertIn("espalier: a.su2:3: an element names point 9",
                          self.deform_mesh(*option, code=1).stderr)
        self.assertFalse((self.path / "out.su2").exists())

    def test_a_check_that_nobody_asked_for_does_not_stop_the_deformation(self):
        # The bounds of the check are ±1e90, so this mesh is whole, but cannot be checked.
        self.put("a.su2", SU2.replace("\n0 0 1\n", "\n0 0 1e91\n"))
        result = self.deform_mesh()
        self.assertIn("warning: cells not checked: a.su2: ", result.stderr)
        for option in ("--no-inverted", "--largest-step"):
            self.deform_mesh(option, code=1)
        # A pose beyond the bounds names its file.
        self.put("a.su2", SU2)
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (1e92 * p[0], p[1], p[2]))
        far = "pose.ovm: the pose of vertex 1 is too far from the origin"
        self.assertIn("warning: cells not checked: " + far, self.deform_mesh().stderr)
        self.assertIn("espalier: " + far, self.deform_mesh("--no-inverted", code=1).stderr)
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (p[0], p[1], -p[2]))
        # Elements of unknown types are counted.
        self.put("a.su2", SU2.replace("NELEM= 1\n", "NELEM= 3\n22 0 1 2 3\n22 0 1 2 3\n"))
        self.assertIn("  not checked       2 elements of unknown types\n", self.deform_mesh().stdout)
        mesh, = self.report()["meshes"]
        self.assertEqual((mesh["not_checked"], mesh["inverted"]["count"]),
                         ({"elements of unknown types": 2}, 1))

    def test_cells_of_second_order(self):
        points = POINTS + [".5 0 0", ".5 .5 0", "0 .5 0", "0 0 .5", "0 .5 .5", ".5 0 .5"]
        self.put("q.msh", MSH % (len(points), numbered(points), 1, "1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n"))
        result = self.deform_mesh(model="q.msh", out="out.msh")
        self.assertIn("  cells             1 tetrahedra; 1 of second order\n  inverted          1, the first cell 0\n",
                      result.stdout)
        mesh, = self.report(model="q.msh", out="out.msh")["meshes"]
        self.assertEqual((mesh["second_order"], mesh["not_checked"]), (1, {}))
        # Only the middle of the edge from corner 0 to 1 moves, to corner 0: the cell folds at a half of the way.
        self.run_program("shape", "box", "--cells", 4, 4, 4, "--min", -1, -1, -1, "--max", 1, 1, 1, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (p[0] - 0.5 * (tuple(p) == (0.5, 0, 0)), p[1], p[2]))
        mesh, = self.report("--outside", "nearest", model="q.msh", out="out.msh")["meshes"]
        self.assertEqual(mesh["inverted"]["count"], 0)
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (p[0] - 3 * (tuple(p) == (0.5, 0, 0)), p[1], p[2]))
        mesh, = self.report(model="q.msh", out="out.msh")["meshes"]
        self.assertEqual(mesh["inverted"]["count"], 1)
        # The corners alone are valid.
        self.assertEqual(mesh["quality"]["after"]["non_positive_volumes"], 0)

    def test_what_is_not_checked_is_said(self):
        points = POINTS + ["2 2 2"] * 16
        self.put("q.msh", MSH % (20, numbered(points), 4, "1 29 2 0 1 " + " ".join(map(str, range(1, 21))) +
                                 "\n2 4 2 0 1 1 2 3 4\n3 2 2 0 1 1 2 3\n4 2 2 0 1 5 6 7\n"))
        result = self.deform_mesh("--outside", "nearest", model="q.msh", out="out.msh")
        self.assertIn("  cells             1 tetrahedra\n"
                      "  not checked       1 cells of third order and above or of an unknown order of points\n"
                      "  not checked       1 faces of surfaces that are no faces of cells\n", result.stdout)
        self.put("q.msh", MSH % (20, numbered(points), 1, "1 29 2 0 1 " + " ".join(map(str, range(1, 21))) + "\n"))
        self.assertIn("mesh of pose.ovm\n  not checked       1 cells of third order",
                      self.deform_mesh(model="q.msh", out="out.msh").stdout)
        for option in ("--no-inverted", "--largest-step"):
            self.assertIn("q.msh: has 1 cells of third order and above or of an unknown order of points, which "
                          f"{option} cannot check, and no other cells",
                          self.deform_mesh(option, model="q.msh", out="out.msh", code=1).stderr)

    def test_faces_of_a_mesh_of_two_dimensions(self):
        self.put("a.su2", "NDIME= 2\nNELEM= 2\n5 0 1 2\n9 1 3 4 2\nNPOIN= 5\n0 0\n1 0\n0 1\n1.5 0.5\n0.5 1.5\n"
                          "NMARK= 0\n")
        self.run_program("shape", "box", "--min", 0, 0, -1, "--max", 2, 2, 1, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (-p[0], p[1], p[2]))
        result = self.deform_mesh()
        self.assertIn("  faces             1 triangles, 1 quadrilaterals\n  inverted          2, the first face 0\n",
                      result.stdout)
        self.assertIn("turns 2 of 2 faces of the mesh inside out, the first face 0", result.stderr)
        self.assertIn("    areas not above 0           0          2  faces\n", result.stdout)
        self.assertNotIn("skewness", result.stdout)
        self.deform_mesh("--no-inverted", code=3)
        mesh, = self.report("--largest-step")["meshes"]
        self.assertAlmostEqual(mesh["written"], 0.5, delta=1e-9)
        self.assertEqual((mesh["cells"]["triangles"], mesh["cells"]["quadrilaterals"]), (1, 1))

    def test_the_criterion_of_solvers(self):
        # A corner of a cube goes through the opposite faces. At 1/9 of the way the cube folds at this corner;
        # a solver that looks at the volume accepts a larger share.
        cube = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1", "1 1 1", "0 1 1"]
        self.put("a.su2", "NDIME= 3\nNELEM= 1\n12 0 1 2 3 4 5 6 7\nNPOIN= 8\n" + "\n".join(cube) + "\nNMARK= 0\n")
        self.run_program("shape", "box", "--min", 0, 0, 0, "--max", 1, 1, 1, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (-2, -2, -2) if min(p) == 1 else tuple(p))
        exact, = self.report("--largest-step")["meshes"]
        solver, = self.report("--largest-step", "--criterion", "solver")["meshes"]
        self.assertAlmostEqual(exact["written"], 1 / 9, delta=1e-9)
        self.assertGreater(solver["written"], 0.2)
        self.assertEqual(solver["written"], solver["solver"]["largest_step"])
        self.assertEqual(solver["quality"]["after"]["non_positive_volumes"], 0)
        self.assertEqual(exact["solver"], solver["solver"])
        self.assertIn("a solver finds 1 errors more than at rest",
                      self.deform_mesh("--no-inverted", "--criterion", "solver", code=3).stderr)
        # Half of the solver's share: the exact criterion refuses it, and the solver accepts it.
        half = solver["written"] / 2 * 3
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (1 - half,) * 3 if min(p) == 1 else tuple(p))
        self.deform_mesh("--no-inverted", code=3)
        result = self.deform_mesh("--no-inverted", "--criterion", "solver")
        self.assertIn("  for a solver      0 errors in the whole pose\n", result.stdout)
        self.assertIn("(a solver accepts the whole pose)", result.stderr)
        self.assertIn("expected exact|solver, got best", self.deform_mesh("--criterion", "best", code=2).stderr)

    def test_frame_rates_are_above_0(self):
        for rate in ("0", "-1", "inf", "nan", "x"):
            error = self.deform_mesh("--frame-rate", rate, out="out.mdd", code=2).stderr
            self.assertIn(f"--frame-rate: expected a number above 0, got {rate}", error)

    def test_volumes_of_vtk(self):
        self.run_program("refine", "rest.ovm", "-n", 2, "-o", "m.vtu")
        self.run_program("refine", "rest.ovm", "-n", 2, "-o", "m.vtk")
        for name in ("m.vtu", "m.vtk"):
            mesh, = self.report(model=name, out="out" + name[1:])["meshes"]
            self.assertEqual(mesh["cells"]["hexahedra"], 64)
            self.assertEqual(mesh["inverted"]["count"], 64)

    def test_models_without_cells(self):
        self.write_model([(0, 0, 0.5), (1, 0, 0.5), (0, 1, 0.5)], "m.obj")
        self.assertNotIn("meshes", self.report(model="m.obj", out="out.obj"))
        for option in ("--no-inverted", "--largest-step"):
            self.assertIn(f"m.obj: has no cells of a volume, so there is nothing to check for {option}",
                          self.deform_mesh(option, model="m.obj", out="out.obj", code=1).stderr)

    def test_cells_that_are_folded_at_rest_do_not_count(self):
        self.put("a.su2", SU2.replace("NELEM= 1\n10 0 1 2 3\n", "NELEM= 2\n10 0 1 2 3\n10 0 1 2 2\n"))
        self.write_pose("good.ovm", "rest.ovm", lambda p: (p[0], p[1], 2 * p[2]))
        result = self.deform_mesh("--no-inverted", pose="good.ovm")
        self.assertIn("  folded at rest    1, the first cell 1; they do not count below\n", result.stdout)
        self.assertIn("  inverted          0\n", result.stdout)

    def test_a_case_of_openfoam(self):
        self.put_case("case")
        info = self.run_program("info", "case", "--model").stdout
        self.assertIn("points      4", info)
        self.assertIn("faces       4", info)
        self.assertEqual(self.info("case", "-n", 0)["levels"][0]["counts"]["cells"], 1)
        (self.path / "copy").mkdir()
        self.assertIn("copy: is a folder without a mesh",
                      self.deform_mesh(model="case", out="copy", code=1).stderr)
        shutil.rmtree(self.path / "copy")
        self.assertIn("written to a file of the name 'points'",
                      self.deform_mesh(model="case", out="copy", code=1).stderr)
        shutil.copytree(self.path / "case", self.path / "copy")
        mesh, = self.report(model="case", out="copy")["meshes"]
        self.assertEqual(mesh["inverted"]["count"], 1)
        self.assertEqual(self.text("copy/constant/polyMesh/points"),
                         FOAM["points"].replace("(0 0 1)", "(0 0 -1)"))
        self.assertIn("is also an input", self.deform_mesh(model="case", out="case", code=1).stderr)
        for folder in ("case/0/polyMesh", "case/1/polyMesh"):
            (self.path / folder).mkdir(parents=True)
        self.run_program("deform", "case", "--rest", "rest.ovm", "--to", "rest.ovm", "pose.ovm", "-n", 1,
                         "-o", "case/%d/polyMesh/points", "--quiet")
        self.assertEqual(self.text("case/0/polyMesh/points"), FOAM["points"])
        self.assertIn("(0 0 -1)", self.text("case/1/polyMesh/points"))
        # Its cells are beside its points, so a binding does not have them.
        self.run_program("bind", "case", "--rest", "rest.ovm", "-n", 1, "-o", "m.espb")
        self.run_program("apply", "m.espb", "--to", "pose.ovm", "-o", "copy")
        self.assertIn("(0 0 -1)", self.text("copy/constant/polyMesh/points"))
        self.assertIn("m.espb: has no cells of a volume, so there is nothing to check for --largest-step; the faces",
                      self.error_of("apply", "m.espb", "--to", "pose.ovm", "-o", "copy", "--largest-step"))

    def test_constraint_patches(self):
        folder = self.put_case("case")
        (folder / "boundary").write_text(
            HEADER % "polyBoundaryMesh" + "2\n(\n bottom\n {\n type symmetryPlane;\n inGroups List<word> 1(symmetry);\n"
            " nFaces 1;\n startFace 0;\n }\n walls { type wall; nFaces 3; startFace 1; }\n)\n")
        info = self.run_program("info", "case").stdout
        self.assertIn("cells       1 tetrahedra\npatch       bottom (symmetryPlane): 1 faces, 3 points\n"
                      "patch       walls (wall): 3 faces, 4 points\n", info)
        report = json.loads(self.run_program("info", "case", "--json").stdout)
        self.assertEqual(report["patches"][1], {"name": "walls", "type": "wall", "faces": 3, "points": 4})
        self.assertEqual((report["cells"]["tetrahedra"], report["groups"]), (1, ["bottom", "walls"]))
        shutil.copytree(self.path / "case", self.path / "copy")
        # z = 0 stays; then it moves by 0.5.
        self.write_pose("good.ovm", "rest.ovm", lambda p: (p[0], p[1] + p[2], 2 * p[2]))
        mesh, = self.report(model="case", out="copy", pose="good.ovm")["meshes"]
        self.assertEqual((mesh["patches"][0]["name"], mesh["patches"][0]["broken"]), ("bottom", False))
        result = self.deform_mesh("--no-inverted", model="case", out="copy", pose="good.ovm")
        self.assertIn("  constraints       1 of 1 symmetry, wedge, empty and periodic patches are kept\n", result.stdout)
        self.write_pose("bad.ovm", "rest.ovm", lambda p: (p[0], p[1], p[2] + 0.5))
        result = self.deform_mesh(model="case", out="copy", pose="bad.ovm")
        text = "the patch bottom (symmetryPlane) leaves its plane by 0.5, point 0"
        self.assertIn(f"  broken            {text}\n", result.stdout)
        self.assertIn(f"warning: in bad.ovm, {text}. --no-inverted refuses it", result.stderr)
        self.assertIn(f"bad.ovm: in this pose, {text} of case; nothing was written",
                      self.deform_mesh("--no-inverted", model="case", out="copy", pose="bad.ovm", code=3).stderr)
        # A plane that is bent at rest is named.
        (folder / "points").write_text(FOAM["points"])
        (folder / "boundary").write_text((folder / "boundary").read_text()
                                         .replace("nFaces 1;", "nFaces 2;").replace("nFaces 3; startFace 1;", "nFaces 2; startFace 2;"))
        self.assertIn("  not checked       the patch bottom, which breaks its constraint at rest\n",
                      self.deform_mesh(model="case", out="copy").stdout)
        (folder / "boundary").write_text((folder / "boundary").read_text().replace("startFace 2;", "startFace 1;"))
        self.assertIn("the patch 'walls' has 2 faces from face 1 on; expected faces of 2 to 3",
                      self.deform_mesh("--no-inverted", model="case", out="copy", code=1).stderr)

    def test_patches_by_name(self):
        self.put("a.su2", SU2.replace("NMARK= 0\n", "NMARK= 2\nMARKER_TAG= y_symmetry\nMARKER_ELEMS= 1\n5 0 2 1\n"
                                      "MARKER_TAG= tip\nMARKER_ELEMS= 2\n5 0 1 3\n5 1 2 3\n"))
        self.put("m.msh", MSH.replace("$Nodes", '$PhysicalNames\n2\n2 1 "low"\n3 7 "fluid"\n$EndPhysicalNames\n$Nodes') %
                 (4, numbered(POINTS), 3, "1 4 2 7 1 1 2 3 4\n2 2 2 1 1 1 3 2\n3 2 2 5 1 1 2 4\n"))
        self.assertEqual([patch["name"] for patch in json.loads(
            self.run_program("info", "m.msh", "--json").stdout)["patches"]], ["fluid", "low", "surface 5"])
        self.write_pose("bad.ovm", "rest.ovm", lambda p: (p[0], p[1], p[2] + 0.5))
        mesh, = self.report(pose="bad.ovm")["meshes"]
        self.assertEqual([(patch["name"], patch["broken"]) for patch in mesh["patches"]], [("y_symmetry", True)])
        # Only the points of a patch move.
        self.deform_mesh("--only", "y_symmetry", pose="bad.ovm")
        self.assertEqual(self.text("out.su2").splitlines()[4:8], ["0 0 0.5", "1 0 0.5", "0 1 0.5", "0 0 1"])

    def test_the_points_of_another_openfoam_case_are_kept(self):
        self.put_case("case")
        other = self.put_case("other")
        (other / "owner").write_text(FOAM["owner"].replace("4{0}", "4(0 1 0 1)"))
        for out in ("other", "other/constant/polyMesh/points"):
            self.assertIn("belongs to another mesh, whose faces, owner and neighbour are not those of case",
                          self.deform_mesh("--quiet", model="case", out=out, code=1).stderr)
        (other / "faces").unlink()
        self.assertIn("other: has a folder polyMesh without a file of faces",
                      self.deform_mesh(model="case", out="other", code=1).stderr)
        self.assertEqual((other / "points").read_text(), FOAM["points"])
        # Other bytes with the same faces and cells, and a slash.
        (self.put_case("copy") / "owner").write_text(FOAM["owner"].replace("4{0}", "4 ( 0 0 0 0 )"))
        self.deform_mesh(model="case", out="copy/")
        self.assertIn("(0 0 -1)", self.text("copy/constant/polyMesh/points"))
        # A binding has no faces: it knows the number of points.
        self.run_program("bind", "case", "--rest", "rest.ovm", "-n", 1, "-o", "case.espb")
        self.run_program("apply", "case.espb", "--to", "rest.ovm", "-o", "copy/")
        self.assertEqual(self.text("copy/constant/polyMesh/points"), FOAM["points"])
        more = FOAM["points"].replace("4(", "5((7 7 7)")
        self.put("copy/constant/polyMesh/points", more)
        self.assertIn("belongs to another mesh, which has 5 points, and not 4",
                      self.run_program("apply", "case.espb", "--to", "rest.ovm", "-o", "copy", code=1).stderr)
        self.assertEqual(self.text("copy/constant/polyMesh/points"), more)

    def test_a_small_file_of_openfoam_takes_little_memory(self):
        # The lists claim 8 GB: more than the program may take here, and far more than it needs.
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
        for name, faces in (("owner", "4 faces"), ("neighbour", "4 faces"), ("faces", r"\d+ bytes")):
            folder = self.put_case(name)
            (folder / name).write_text(HEADER % "faceCompactList" + "2147483647{0}\n")
            result = subprocess.run(
                [program.ESPALIER, "deform", name, "--rest", "rest.ovm", "--to", "pose.ovm", "-n", "1",
                 "-o", "/dev/stdout"], cwd=self.path, encoding="utf-8", capture_output=True, timeout=120,
                preexec_fn=limit)
            self.assertRegex(result.stderr, rf"polyMesh/{name}:2: has 2147483647 labels, but there are {faces}$")
            self.assertEqual(result.returncode, 1)
            self.assertNotIn("FoamFile", result.stdout)

    def test_a_pipe_in_an_openfoam_case_is_refused(self):
        for name in FOAM:
            file = self.put_case(name) / name
            file.unlink()
            os.mkfifo(file)
            for command in (["info", name, "-n", 0],
                            ["deform", name, "--rest", "rest.ovm", "--to", "pose.ovm", "-o", "/dev/null"]):
                self.assertIn(f"polyMesh/{name}: is not a regular file", self.error_of(*command))

    def test_apply_checks_on_request(self):
        self.run_program("bind", "a.su2", "--rest", "rest.ovm", "-n", 1, "-o", "m.espb")
        report = self.run_program("apply", "m.espb", "--to", "pose.ovm", "-o", "out.su2").stdout
        self.assertNotIn("inverted", report)
        self.assertIn("inside out", self.error_of("apply", "m.espb", "--to", "pose.ovm", "-o", "no.su2",
                                                  "--no-inverted", code=3))
        self.assertFalse((self.path / "no.su2").exists())

    def test_a_lattice_of_a_simulation(self):
        self.put("lattice.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n" + "\n".join(
            f"{i + 1} {5 * float(p.split()[0]) - 1} {5 * float(p.split()[1]) - 1} {5 * float(p.split()[2]) - 1}"
            for i, p in enumerate(POINTS)) + "\n$EndNodes\n$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n")
        self.run_program("pose", "lattice.msh", "--move", 1, 2, 3, "-o", "moved.vtu")
        self.run_program("deform", "a.su2", "--rest", "lattice.msh", "--to", "moved.vtu", "-n", 2, "-o",
                         "out.su2", "--no-inverted")
        for point in ("1 2 3", "2 2 3", "1 3 3", "1 2 4"):
            values = [tuple(round(float(c), 9) for c in line.split())
                      for line in self.text("out.su2").splitlines()[4:8]]
            self.assertIn(tuple(map(float, point.split())), values)
        self.assertIn("a lattice cannot be written in this format; expected .ovm, .vtu or .vtk",
                      self.error_of("refine", "lattice.msh", "-o", "x.msh"))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
