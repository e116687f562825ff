# SPDX-License-Identifier: Apache-2.0
"""Binds models to the limit volume of a lattice, and deforms them with it."""

import json
import math
import sys
import unittest

import program
from program import CliTest


def bend(p):
    """A smooth map that is far from affine."""
    x, y, z = p
    return (x + 0.3 * z * z, y - 0.2 * x * z, z)


def turn(p, angle=0.7):
    x, y, z = p
    return (math.cos(angle) * x - math.sin(angle) * y, math.sin(angle) * x + math.cos(angle) * y, z)


class LimitTest(CliTest):
    def write_model(self):
        """A quadrilateral inside, with the normals of a sphere at its corners."""
        points = [(0.2, 0.1, 0.3), (-0.2, 0.1, 0.2), (-0.1, -0.3, -0.1), (0.2, -0.2, 0.1)]
        lines = ["# a model", *(f"v {x} {y} {z}" for x, y, z in points)]
        for p in points:
            length = math.sqrt(sum(c * c for c in p))
            lines.append("vn " + " ".join(f"{c / length:.9f}" for c in p))
        lines.append("f 1//1 2//2 3//3 4//4")
        self.put("model.obj", "\n".join(lines) + "\n")

    def write_lattice(self):
        self.run_program("shape", "cylinder", "--sectors", 5, "--layers", 2, "--from", 0, 0, -1,
                         "--to", 0, 0, 1, "-o", "rest.ovm")

    def pose(self, move, name="pose.ovm"):
        """The lattice with each vertex moved."""
        self.write_pose(name, "rest.ovm", move)
        return name

    def vectors(self, name, word):
        return [[float(c) for c in line.split()[1:]]
                for line in self.text(name).splitlines() if line.startswith(word + " ")]

    def setUp(self):
        super().setUp()
        self.write_lattice()
        self.write_model()

    def deform(self, *arguments, to="pose.ovm", output="out.obj"):
        self.run_program("deform", "model.obj", "--rest", "rest.ovm", "--to", to, "-o", output,
                         *arguments)
        return self.vectors(output, "v")

    def assert_near(self, got, expected, tolerance):
        self.assertEqual(len(got), len(expected))
        for a, b in zip(got, expected):
            self.assertLess(math.dist(a, b), tolerance)

    def test_at_rest_the_model_stays(self):
        points = self.deform("--limit", to="rest.ovm")
        self.assert_near(points, self.vectors("model.obj", "v"), 1e-15)
        # Nothing moves: normals keep their text.
        lines = [[line for line in self.text(name).splitlines() if "v " not in line]
                 for name in ("out.obj", "model.obj")]
        self.assertEqual(lines[0], lines[1])

    def test_a_turn_turns_points_and_normals(self):
        self.pose(turn)
        for target in (["--limit"], ["-n", 1], ["-n", 3], []):
            points = self.deform(*target)
            # The files' digits: the lattice's and the model's are exact, nine are written of normals.
            self.assert_near(points, [turn(p) for p in self.vectors("model.obj", "v")], 1e-9)
            self.assert_near(self.vectors("out.obj", "vn"),
                             [turn(n) for n in self.vectors("model.obj", "vn")], 3e-9)
        self.run_program("shape", "box", "--cells", 3, 3, 3, "--min", -1, -1, -1, "--max", 1, 1, 1,
                         "-o", "rest.ovm")
        self.pose(turn)
        for basis in ("bezier", "bspline"):
            self.deform("--basis", basis)
            self.assert_near(self.vectors("out.obj", "vn"),
                             [turn(n) for n in self.vectors("model.obj", "vn")], 3e-9)

    def report(self, *arguments):
        """The report's line on normals and tangents; None if there is none."""
        text = self.run_program(*arguments).stdout
        lines = [line.split(maxsplit=1)[1] for line in text.splitlines()
                 if line.startswith("directions")]
        as_json = json.loads(self.run_program(*arguments, "--report", "json").stdout)
        self.assertEqual(as_json["directions"], lines[0] if lines else None)
        return as_json["directions"]

    def test_the_report_says_what_follows(self):
        self.models_with_directions()
        self.pose(turn)
        rest = ["--rest", "rest.ovm", "--outside", "keep"]
        deform = lambda model, output, *options: self.report(
            "deform", model, *rest, "--to", "pose.ovm", "-o", output, *options)
        self.assertEqual(deform("model.obj", "out.obj"), "4 normals turn with the model")
        self.assertEqual(deform("model.ply", "out.ply"),
                         "5 normals and 5 tangents turn with the model; those of 1 point left in "
                         "place stay")
        self.assertIsNone(deform("plain.obj", "out.obj"))
        self.put("one.obj", "v 0.2 0.1 0.3\nvn 0 0 1\n")
        self.assertEqual(deform("one.obj", "out.obj"), "1 normal turns with the model")
        self.assertEqual(deform("model.obj", "out.obj", "--keep-normals"),
                         "4 normals stay, as --keep-normals asks")
        self.assertEqual(self.vectors("out.obj", "vn"), self.vectors("model.obj", "vn"))
        self.assertEqual(deform("model.obj", "out.glb"), "4 normals turn with the model")
        self.assertEqual(deform("model.obj", "out.mdd"),
                         "4 normals are not in the animation, which holds points only")
        # A binding without gradients, and one with them.
        apply = ["apply", "bound.espb", "--to", "pose.ovm", "-o", "out.obj"]
        for options, gradients, said in (
                (["--keep-normals"], 0, "4 normals stay: the model was bound with --keep-normals"),
                ([], 1, "4 normals turn with the model")):
            self.run_program("bind", "model.obj", *rest, *options, "-o", "bound.espb")
            self.assertEqual(self.bytes("bound.espb")[12], gradients)
            self.assertEqual(self.report(*apply), said)
        self.assertEqual(self.report(*apply, "--keep-normals"),
                         "4 normals stay, as --keep-normals asks")
        self.assertEqual(self.vectors("out.obj", "vn"), self.vectors("model.obj", "vn"))

    def models_with_directions(self):
        """The points of model.obj with normals and tangents, in all formats that carry them, and
        one in which nothing is carried."""
        points, normals = self.vectors("model.obj", "v"), self.vectors("model.obj", "vn")
        points.append([9, 9, 9])  # outside: stays where it is
        normals.append([0, 0, 1])
        rows = ["%r %r %r %r %r %r 0 0.6 0.8" % (*p, *n) for p, n in zip(points, normals)]
        self.put("model.ply", "\n".join(
            ["ply", "format ascii 1.0", f"element vertex {len(rows)}",
             *(f"property double {name}" for name in "x y z nx ny nz tx ty tz".split()),
             "end_header", *rows, ""]))

        def array(values, attributes):
            text = " ".join("%r" % c for value in values for c in value)
            return (f'<DataArray type="Float64" NumberOfComponents="3" format="ascii" {attributes}>'
                    f'{text}</DataArray>')
        count = len(points)
        self.put("model.vtu",
            '<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">'
            f'<UnstructuredGrid><Piece NumberOfPoints="{count}" NumberOfCells="0">'
            f'<PointData Normals="n" Tangents="t">{array(normals, "Name=@n@")}'
            f'{array([[0, 0.6, 0.8]] * count, "Name=@t@")}</PointData>'.replace("@", '"') +
            f'<Points>{array(points, "")}</Points><Cells>'
            '<DataArray type="Int64" Name="connectivity" format="ascii"></DataArray>'
            '<DataArray type="Int64" Name="offsets" format="ascii"></DataArray>'
            '<DataArray type="UInt8" Name="types" format="ascii"></DataArray>'
            '</Cells></Piece></UnstructuredGrid></VTKFile>\n')
        self.put("plain.obj", "v 0.2 0.1 0.3\nv 9 9 9\n")
        return ["model.obj", "model.ply", "model.vtu", "plain.obj"]

    def lattices(self):
        """Commands of `shape` for lattices that hold the models."""
        yield ["cylinder", "--sectors", 5, "--layers", 2, "--from", 0, 0, -1, "--to", 0, 0, 1]
        yield ["box", "--cells", 2, 3, 2, "--min", -1, -1, -1, "--max", 1, 1, 1]
        yield ["cylinder", "--sectors", 7, "--layers", 1, "--radius", 1.5, "--from", 0, 0, -1,
               "--to", 0, 0, 1]

    def test_apply_writes_what_deform_writes(self):
        models = self.models_with_directions()
        for number, shape in enumerate(self.lattices()):
            self.run_program("shape", *shape, "-o", "rest.ovm")
            poses = [self.pose(bend, "bend.ovm"), "rest.ovm", self.pose(turn, "turn.ovm")]
            for model in models:
                for outside, target in (("keep", ["--limit"]), ("nearest", ["--limit"]),
                                        ("nearest", ["-n", 2])):
                    with self.subTest(f"{shape} {model} {outside} {target}"):
                        extension = model.split(".")[1]
                        options = [model, "--rest", "rest.ovm", *target, "--outside", outside]
                        self.run_program("deform", *options, "--to", *poses,
                                         "-o", f"deformed%d.{extension}")
                        self.run_program("bind", *options, "-o", "bound.espb")
                        self.run_program("apply", "bound.espb", "--to", *poses,
                                         "-o", f"applied%d.{extension}")
                        for i in range(len(poses)):
                            deformed, applied = (self.bytes(f"{name}{i}.{extension}")
                                                 for name in ("deformed", "applied"))
                            self.assertEqual(applied, deformed)
                        # Both files have deformed directions; the plain model has moved points only.
                        has_gradients = self.bytes("bound.espb")[12]
                        self.assertEqual(has_gradients, model != "plain.obj")

    def test_options_that_do_not_go_together_are_refused(self):
        command = ["bind", "model.obj", "--rest", "rest.ovm", "--limit", "-o", "bound.espb"]
        self.assertIn("--limit", self.error_of(*command, "-n", 3, code=2))
        self.assertIn("--limit", self.error_of(*command, "--basis", "bspline", code=2))
        self.assertEqual(self.error_of(*command, "--tolerance", 0.5, code=2),
                         "espalier: --tolerance: expected 1e-14 to 0.1, got 0.5\n")

    def test_smoothness_of_what_is_irregular(self):
        report = json.loads(self.run_program("info", "rest.ovm", "--smoothness", "--json").stdout)
        axis = [entry for entry in report["smoothness"]
                if "edge" in entry and entry["stratum"] == "interior"]
        # Two interior edges lie in five cells. Their eigenvalues are 0.55 across the edge, 1/2 along it.
        self.assertEqual(len(axis), 2)
        for entry in axis:
            self.assertAlmostEqual(sum(entry["limit_mask"]), 1, places=12)
            for (real, imaginary), expected in zip(entry["eigenvalues"], (0.55, 0.55, 0.5)):
                self.assertAlmostEqual(real, expected, places=4)
                self.assertAlmostEqual(imaginary, 0, places=9)
        text = self.run_program("info", "rest.ovm", "--smoothness").stdout
        self.assertRegex(text, r"edge +\d+  interior  eigenvalues of refinement 1 0.5500 0.5500 "
                               r"0.5000 0.3401 ")

    def test_rings_that_are_too_large_get_a_note(self):
        self.run_program("shape", "bipyramid", "--sides", 3000, "-o", "wide.ovm")
        arguments = ["info", "wide.ovm", "-n", 0, "--smoothness"]
        entries = json.loads(self.run_program(*arguments, "--json").stdout)["smoothness"]
        wide = [entry for entry in entries if entry["limit_mask"] is None]
        # The rings of the two apexes have 3,000 edges, 3,000 faces, the cell and the apex itself.
        self.assertEqual([entry["ring_points"] for entry in wide].count(6002), 2)
        for entry in wide:
            self.assertIsNone(entry["eigenvalues"])
            self.assertIn("eigenvalues are not computed: its ", entry["note"])
        for entry in entries:
            if entry["limit_mask"] is not None:
                self.assertNotIn("note", entry)
                self.assertAlmostEqual(sum(entry["limit_mask"]), 1, places=9)
        text = self.run_program(*arguments).stdout
        self.assertEqual(text.count("eigenvalues are not computed: its ring has 6002 points"), 2)

    def test_a_box_is_smooth_everywhere(self):
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "box.ovm")
        self.assertIn("everywhere", self.run_program("info", "box.ovm", "--smoothness").stdout)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
