#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Poses from mesh editors: `refine` writes an editor mesh as .obj or .ply, and `--to` reads it.

    editor_mesh_test.py PATH_OF_ESPALIER
"""

import sys
import unittest

import program
from program import CliTest, icosphere_points


class EditorMesh(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "rest.ovm")

    def refine(self, output, level=0):
        return self.run_program("refine", "rest.ovm", "-n", level, "-o", output).stdout

    def move_corner(self, mesh):
        """Moves the corner (1, 1, 1) of an editor mesh to (2, 2, 2), and writes the pose as pose.ovm too."""
        mark = "v " if mesh.endswith(".obj") else "\n"
        text = self.text(mesh)
        self.assertEqual(text.count(mark + "1 1 1\n"), 1)
        self.put(mesh, text.replace(mark + "1 1 1\n", mark + "2 2 2\n"))
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (2, 2, 2) if p == (1, 1, 1) else p)

    def test_a_cage_has_all_vertices_and_faces_of_a_level(self):
        self.assertEqual(self.refine("editor.obj"), "editor.obj: level 0, 27 vertices, 8 cells\n")
        self.assertEqual(self.read_points("editor.obj"), self.read_ovm_positions("rest.ovm"))
        self.assertEqual(self.text("editor.obj").count("\nf "), 36)
        self.refine("level.ovm", level=1)
        for name, level in (("editor.ply", 0), ("level.obj", 1), ("level.PLY", 1)):
            self.refine(name, level)
        self.assertIn("element vertex 27\n", self.text("editor.ply"))
        self.assertIn("element face 36\n", self.text("editor.ply"))
        self.assertEqual(self.read_points("level.obj"), self.read_ovm_positions("level.ovm"))
        self.assertEqual(self.text("level.obj").count("\nf "), 240)
        self.assertIn("element face 240\n", self.text("level.PLY"))

    def test_deform_apply_and_check_read_cages_as_they_read_lattices(self):
        self.write_model(icosphere_points(30))
        self.bind("model.obj", "rest.ovm", out="model.espb")
        for mesh in ("editor.obj", "editor.ply"):
            self.refine(mesh)
            self.move_corner(mesh)
            expected = self.deform("model.obj", "rest.ovm", "pose.ovm", out="expected.obj")
            self.deform("model.obj", "rest.ovm", mesh, out="moved.obj")
            self.run_program("apply", "model.espb", "--to", mesh, "-o", "applied.obj")
            self.assertNotEqual(self.bytes("moved.obj"), self.bytes("model.obj"))
            for name in ("moved.obj", "applied.obj"):
                self.assertEqual(self.bytes(name), self.bytes("expected.obj"), mesh)
            reports = [self.run_program("check", pose, "--rest", "rest.ovm").stdout
                       for pose in (mesh, "pose.ovm")]
            self.assertEqual(*reports)

    def test_a_cage_of_another_lattice_is_refused(self):
        self.write_model(icosphere_points(30))
        self.bind("model.obj", "rest.ovm", out="model.espb")
        self.run_program("shape", "box", "--cells", 2, 2, 1, "-o", "other.ovm")
        self.run_program("refine", "other.ovm", "-n", 0, "-o", "other.obj")
        self.assertRegex(
            self.error_of("deform", "model.obj", "--rest", "rest.ovm", "--to", "other.obj", "-o",
                          "out.obj"),
            "^espalier: other.obj: is not a pose of rest.ovm: it has 18 points; expected one for "
            "each of the 27 vertices")
        self.assertRegex(
            self.error_of("apply", "model.espb", "--to", "other.obj", "-o", "out.obj"),
            "^espalier: other.obj: is not a pose of the lattice of model.espb: it "
            "has 18 points")

    def test_triangles_are_refused_with_the_reason(self):
        self.refine("editor.obj")
        lines = []
        for line in self.text("editor.obj").splitlines():
            words = line.split()
            lines += [line] if words[0] == "v" else [f"f {words[1]} {words[i]} {words[i + 1]}"
                                                     for i in range(2, len(words) - 1)]
        self.put("editor.obj", "\n".join(lines) + "\n")
        self.write_model(icosphere_points(30))
        self.bind("model.obj", "rest.ovm", out="model.espb")
        for command in (["check", "editor.obj", "--rest", "rest.ovm"],
                        ["apply", "model.espb", "--to", "editor.obj", "-o", "out.obj"]):
            self.assertRegex(
                self.error_of(*command),
                "is a part of face 0 of the lattice, .* Export the mesh without splitting faces "
                "into triangles\n$")

    def test_a_model_deforms_by_a_cage_with_faces_of_any_direction(self):
        """Editors may begin a face at another vertex, turn it around, or leave faces out."""
        self.refine("editor.obj")
        lines = self.text("editor.obj").splitlines()
        faces = [line.split()[1:] for line in lines if line.startswith("f ")]
        turned = ["f " + " ".join(reversed(face[1:] + face[:1])) for face in faces[:-3]]
        self.put("turned.obj", "\n".join([l for l in lines if l.startswith("v ")] + turned) + "\n")
        self.assertEqual(self.run_program("check", "turned.obj", "--rest", "rest.ovm").stdout,
                         self.run_program("check", "rest.ovm", "--rest", "rest.ovm").stdout)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
