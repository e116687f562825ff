#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier deform`, `bind` and `apply`, and the example of the README.

    deform_command_test.py PATH_OF_ESPALIER PATH_OF_THE_EXAMPLE
"""

import os
import struct
import subprocess
import sys
import unittest

import program
from program import CliTest, icosphere_points


EXAMPLE = ""


class Deform(CliTest):
    POSE = "--min -1 -1 -1 --max 3 1 2".split()  # x' = 4x − 1, y' = 2y − 1, z' = 3z − 1

    def setUp(self):
        super().setUp()
        self.points = icosphere_points(500)
        self.write_model(self.points)
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "rest.vtu")
        self.run_program("shape", "box", "--cells", 2, 2, 2, *self.POSE, "-o", "pose.vtk")
        self.expected = [(4 * x - 1, 2 * y - 1, 3 * z - 1) for x, y, z in self.points]

    def test_affine_pose_moves_the_model_by_the_same_map(self):
        out = self.deform("model.obj", "rest.vtu", "pose.vtk", "-n", 2, out="out.obj").stdout
        self.assert_close(self.read_points("out.obj"), self.expected, 1e-13)
        self.assertIn("500 inside the lattice, 0 outside, 0 could not be placed", out)
        for word in ["placement error", "weights for each point", "peak memory", "deforming"]:
            self.assertIn(word, out)
        text = self.text("out.obj")
        self.assertTrue(text.startswith("# a comment\nv "))
        self.assertTrue(text.endswith("vt 0 0\nf 1/1 2/1 3/1\n"))

    def test_rest_pose_gives_the_model_back(self):
        self.deform("model.obj", "rest.vtu", "rest.vtu", out="out.obj")
        self.assertEqual(self.bytes("out.obj"), self.bytes("model.obj"))
        self.bind("model.obj", "rest.vtu", out="m.espb")
        self.run_program("apply", "m.espb", "--to", "rest.vtu", "-o", "applied.obj")
        self.assertEqual(self.bytes("applied.obj"), self.bytes("model.obj"))

    def test_points_that_no_moved_vertex_reaches_keep_their_text(self):
        # At level 2, the corner of 6 by 1 by 1 cells has no weight in the far half.
        self.run_program("shape", "box", "--cells", 6, 1, 1, "--max", 6, 1, 1, "-o", "long.vtu")
        self.run_program("pose", "long.vtu", "--select", "end", "+x", "--move", 1, 0, 0, "-o",
                         "longer.vtu")
        texts = ["v 0.348799 0.5 0.50", "v 1.10 0.1 0.3", "v 5.5 0.5 0.5"]
        self.put("texts.obj", "\n".join(texts) + "\n")
        self.deform("texts.obj", "long.vtu", "longer.vtu", "-n", 2, out="out.obj")
        lines = self.text("out.obj").splitlines()
        self.assertEqual(lines[:2], texts[:2])
        self.assertGreater(float(lines[2].split()[1]), 5.6)

    def test_example_of_the_readme_does_what_the_program_does(self):
        self.deform("model.obj", "rest.vtu", "pose.vtk", "-n", 3, out="out.obj")
        subprocess.run([EXAMPLE, "model.obj", "rest.vtu", "pose.vtk", "example.obj"],
                       cwd=self.path, check=True, timeout=120)
        self.assertEqual(self.bytes("example.obj"), self.bytes("out.obj"))

    def test_terminal_shows_progress(self):
        shown = self.shown_on_a_terminal("deform", "model.obj", "--rest", "rest.vtu", "--to",
                                         "pose.vtk", "-o", "out.obj")
        self.assertIn("deforming ...", shown)
        self.assertIn("deforming ... 100 %", shown)
        self.assertTrue(shown.endswith("\r\x1b[K"), "the line is cleared at the end")

    def test_quiet_is_silent(self):
        result = self.run_program("deform", "model.obj", "--rest", "rest.vtu", "--to", "pose.vtk",
                                  "-o", "out.obj", "--quiet")
        self.assertEqual(result.stdout + result.stderr, "")

    def test_bind_and_apply_do_what_deform_does(self):
        self.deform("model.obj", "rest.vtu", "pose.vtk", "-n", 2, out="deformed.obj")
        self.bind("model.obj", "rest.vtu", "-n", 2, out="m.espb")
        os.remove(self.path / "model.obj")
        self.run_program("apply", "m.espb", "--to", "pose.vtk", "-o", "applied.obj")
        self.assertEqual(self.bytes("applied.obj"), self.bytes("deformed.obj"))

    def test_normals_where_the_lattice_is_flat_are_counted(self):
        # A box without height: points on it move, but no gradient follows from it.
        self.run_program("shape", "box", "--cells", 1, 1, 2, "-o", "high.ovm")
        self.run_program("pose", "high.ovm", "--scale", 1, 1, 0, "-o", "flat.ovm")
        self.run_program("pose", "flat.ovm", "--move", 1, 0, 0, "-o", "moved.ovm")
        self.put("points.ply", "ply\nformat ascii 1.0\nelement vertex 2\n" +
                 "".join(f"property double {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz")) +
                 "end_header\n0.5 0.5 0.5 0 0 1\n0.4 0.3 0.5 0 0 1\n")
        result = self.run_program("deform", "points.ply", "--rest", "flat.ovm", "--to", "moved.ovm", "-n", 2,
                                  "-o", "out.ply")
        self.assertIn("2 normals turn with the model; those of 2 points where the lattice at rest is flat stay\n", result.stdout)

    def test_several_poses_are_numbered(self):
        for pattern, names in [("out.obj", ["out.0000.obj", "out.0001.obj"]),
                               ("p%02d.obj", ["p00.obj", "p01.obj"])]:
            self.deform("model.obj", "rest.vtu", "rest.vtu", "pose.vtk", "-n", 1, out=pattern)
            self.assert_close(self.read_points(names[0]), self.points, 1e-12)
            self.assert_close(self.read_points(names[1]), self.expected, 1e-12)

    def test_a_number_is_no_format(self):
        for pattern, poses, name in [("out.%04d", ["pose.vtk"], "out.0000"),
                                     ("out", ["rest.vtu", "pose.vtk"], "out.0001")]:
            result = self.deform("model.obj", "rest.vtu", *poses, "-n", 1, out=pattern)
            self.assertEqual(result.stderr, "")
            self.assertIn("\nv ", self.text(name))

    def test_numbered_outputs_that_are_one_file_are_refused(self):
        arguments = ["deform", "model.obj", "--rest", "rest.vtu", "--to", "rest.vtu", "pose.vtk",
                     "-n", 1, "-o", "out.obj"]
        link = self.path / "out.0001.obj"
        for target in ["out.0000.obj", str(self.path / "." / "out.0000.obj")]:
            link.symlink_to(target)  # first to a file that does not exist yet, then to an existing one
            error = self.error_of(*arguments)
            self.assertIn("out.0001.obj: is the same file as out.0000.obj, through a link", error)
            link.unlink()
            self.put("out.0000.obj", "kept")
        self.assertEqual(self.text("out.0000.obj"), "kept")
        # Links to another file, and to a device, which takes several outputs, are accepted.
        link.symlink_to("else.obj")
        self.run_program(*arguments)
        self.assert_close(self.read_points("else.obj"), self.expected, 1e-12)
        for name in ["out.0000.obj", "out.0001.obj"]:
            (self.path / name).unlink()
            (self.path / name).symlink_to("/dev/null")
        self.run_program(*arguments)

    def test_result_does_not_depend_on_the_number_of_threads(self):
        outputs = set()
        for threads in [1, 2, 5]:
            self.bind("model.obj", "rest.vtu", "--threads", threads, out="m.espb")
            outputs.add(self.bytes("m.espb"))
        self.assertEqual(len(outputs), 1)

    def test_points_outside_that_stay_are_warned_of(self):
        self.run_program("shape", "box", "-o", "rest.ovm")
        self.write_model([(.5, .5, .5), (.2, .2, .3), (2, 2, 2)])
        self.put("targets.txt", "0 .6 .5 .5\n2 2 2 2\n")
        bound = ["model.obj", "--rest", "rest.ovm", "-n", 1]
        commands = {"deform": ["deform", *bound, "--to", "rest.ovm", "-o", "out.obj"],
                    "bind": ["bind", *bound, "-o", "out.espb"],
                    "fit": ["fit", *bound, "--targets", "targets.txt", "-o", "fit.ovm"],
                    "stencils": ["stencils", "rest.ovm", "--points", "model.obj", "-o", "D.npz"]}
        for name, command in commands.items():
            count = 2 if name == "fit" else 3  # points with targets
            self.assertEqual(
                self.run_program(*command).stderr,
                f"espalier: warning: 1 of {count} points is outside the lattice and stays in place, "
                "so a pose may tear the model. Use --outside nearest to move them with the nearest "
                "cell, --outside keep if they should stay, or make a lattice around the whole model: "
                "espalier shape around\n")
            for option in [["--quiet"], ["--outside", "nearest"], ["--outside", "keep"]]:
                self.assertEqual(self.run_program(*command, *option).stderr, "")
        # Weights at (2, 2, 2) sum to 7 in absolute value: 1, and 2 for each axis. At (3, 3, 3) they
        # would sum to 13.
        self.write_model([(.5, .5, .5), (2, 2, 2), (3, 3, 3)])
        for option in [[], ["--limit"], ["--basis", "bezier"]]:
            level = [] if option else ["-n", 1]
            result = self.run_program("deform", "model.obj", "--rest", "rest.ovm", *level, *option,
                                      "--to", "rest.ovm", "-o", "out.obj", "--outside", "nearest")
            self.assertEqual(
                result.stderr,
                "espalier: warning: 1 of 2 points outside the lattice is too far away, or beside a "
                "cell that is too flat, to move with the nearest cell: the absolute values of its "
                "weights would sum to more than 8. It stays in place\n")
            self.assertIn("left in place     1 point, whatever the pose", result.stdout)
        self.write_model([(3, 3, 3), (4, 4, 4), (5, 5, 5)])
        self.assertIn("warning: 3 of 3 points are outside the lattice and stay in place. Use",
                      self.run_program(*commands["bind"]).stderr)
        self.write_model([(.3, .3, .3), (.4, .4, .4), (.5, .5, .5)])
        self.assertEqual(self.run_program(*commands["bind"]).stderr, "")

    def test_folds_of_the_lattice_at_rest_are_warned_of(self):
        # Three cells in a row, with planes at 0, 0.8, 2/3 and 1.
        self.run_program("shape", "box", "--cells", 3, 1, 1, "-o", "rest.ovm")
        self.write_pose("folded.ovm", "rest.ovm",
                        lambda p: (.8 if .3 < p[0] < .4 else p[0], p[1], p[2]))
        self.write_model([(.9, .5, .5), (.95, .2, .3)])
        warning = ("espalier: warning: 1 of 3 cells of 'folded.ovm' is flat, folded or inside out at "
                   "rest (first: cell 1). A point there may be in several cells or in none, and "
                   "neighbouring points may move apart\n")
        bound = ["model.obj", "--rest", "folded.ovm"]
        for command in (["bind", *bound, "-o", "out.espb"],
                        ["deform", *bound, "--limit", "--to", "rest.ovm", "-o", "out.obj"],
                        ["stencils", "folded.ovm", "--points", "model.obj", "-o", "D.npz"]):
            self.assertEqual(self.run_program(*command).stderr, warning)
            self.assertEqual(self.run_program(*command, "--quiet").stderr, "")
        self.assertIn("folds       1 of 3 cells are flat, folded or inside out after one refinement "
                      "(first: cell 1)", self.run_program("info", "folded.ovm").stdout)
        self.assertEqual(self.info("folded.ovm")["cells_bad_at_rest"], [1])
        self.assertEqual(self.info("rest.ovm")["cells_bad_at_rest"], [])
        self.assertNotIn("folds", self.run_program("info", "rest.ovm").stdout)

    def test_a_model_is_written_in_the_format_of_the_output(self):
        self.run_program("shape", "box", "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (p[0] + 1, p[1], p[2]))
        square = "v .25 .25 .5\nv .75 .25 .5\nv .75 .75 .5\nv .25 .75 .5\nvn 0 0 1\n"
        self.put("model.obj", square + "vt 0 0\nf 1/1/1 2/1/1 3/1/1 4/1/1\n")
        result = self.deform("model.obj", "rest.ovm", "pose.ovm", out="out.stl")
        self.assertEqual(
            result.stderr,
            "espalier: out.stl: the .obj has data that are not written: texture coordinates, "
            "normals (triangles have their own); 1 face is split into 2 triangles; coordinates are "
            "rounded to single precision\n")
        report = self.info("out.stl")
        self.assertEqual((report["faces"], report["distinct_points"]), (2, 4))
        self.assertEqual(report["bounds"], [[1.25, .25, .5], [1.75, .75, .5]])
        # A bound model, too; the normal goes along with --limit.
        self.write_pose("turned.ovm", "rest.ovm", lambda p: (p[0], -p[2], p[1]))
        self.bind("model.obj", "rest.ovm", "--limit", out="model.espb")
        result = self.run_program("apply", "model.espb", "--to", "turned.ovm", "-o", "out.ply")
        self.assertEqual(result.stderr, "espalier: out.ply: the .obj has data that are not written: "
                                        "texture coordinates\n")
        rows = self.text("out.ply").split("end_header\n")[1].splitlines()
        self.assert_close([tuple(map(float, row.split())) for row in rows[:4]],
                          [(x, -.5, y, 0, -1, 0) for x, y in ((.25, .25), (.75, .25), (.75, .75),
                                                              (.25, .75))], 1e-14)
        self.assertEqual(rows[4:], ["4 0 1 2 3"])
        # Each pose of several is converted.
        self.deform("model.obj", "rest.ovm", "pose.ovm", "--to", "rest.ovm", out="out%d.vtp")
        self.assertEqual(self.info("out1.vtp")["bounds"], [[.25, .25, .5], [.75, .75, .5]])
        # The cells of a volume have no place in a surface. Nothing is computed, nothing written.
        self.run_program("shape", "box", "-o", "volume.vtu")
        self.assertEqual(
            self.error_of("deform", "volume.vtu", "--rest", "rest.ovm", "--to", "pose.ovm", "-o",
                          "volume.obj"),
            "espalier: volume.obj: a .obj cannot hold 1 cell of VTK's type 12 (hexahedron) of the "
            "model; name the output volume.vtu, or extract the surface of the model first\n")
        self.assertFalse((self.path / "volume.obj").exists())

    def test_points_outside(self):
        self.write_model(self.points + [(1.5, 0.5, 0.5)])
        arguments = ["deform", "model.obj", "--rest", "rest.vtu", "--to", "pose.vtk", "-o",
                     "out.obj", "--outside"]
        out = self.run_program(*arguments, "keep").stdout
        self.assertIn("1 outside", out)
        self.assertIn("left in place     1 point, whatever the pose", out)
        self.assertEqual(self.read_points("out.obj")[-1], (1.5, 0.5, 0.5))
        self.run_program(*arguments, "nearest")
        self.assert_close(self.read_points("out.obj")[-1:], [(5, 0, 0.5)], 1e-12)
        before = self.bytes("out.obj")
        self.assertIn("point 500 at (1.5", self.error_of(*arguments, "error"))
        self.assertEqual(self.bytes("out.obj"), before, "the old file stays")

    def test_models_of_all_formats(self):
        stl = "solid s\n facet normal 0 0 1\n  outer loop\n   vertex .1 .1 .5\n" \
              "   vertex .9 .1 .5\n   vertex .1 .9 .5\n  endloop\n endfacet\nendsolid s\n"
        ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n" \
              "property float z\nend_header\n0.5 0.25 0.75\n"
        self.put("m.stl", stl)
        self.put("m.ply", ply)
        self.run_program("shape", "tetrahedron", "--radius", 0.1, "-o", "m.vtu")
        for extension in ["stl", "ply", "vtu"]:
            self.deform(f"m.{extension}", "rest.vtu", "pose.vtk", "--outside", "nearest",
                        out=f"out.{extension}")
            self.assertNotEqual(self.bytes(f"out.{extension}"), self.bytes(f"m.{extension}"))
        self.assertIn("1 -0.5 1.25", self.text("out.ply"))

    def add_unused_vertex(self, name, to):
        """Writes the same .ovm with one more vertex before the others, which no edge uses."""
        lines = self.text(name).splitlines()
        at, edges = lines.index("Vertices"), lines.index("Edges")
        count = int(lines[edges + 1])
        lines[edges + 2:edges + 2 + count] = [
            " ".join(str(int(end) + 1) for end in line.split())
            for line in lines[edges + 2:edges + 2 + count]]
        lines[at + 1:at + 2] = [str(int(lines[at + 1]) + 1), "9 9 9"]
        self.put(to, "\n".join(lines) + "\n")

    def test_unused_vertices_are_dropped_with_a_note(self):
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "rest.ovm")
        self.run_program("shape", "box", "--cells", 2, 2, 2, *self.POSE, "-o", "pose.ovm")
        for name in ["rest", "pose"]:
            self.add_unused_vertex(f"{name}.ovm", f"{name}+.ovm")

        def note(*names):
            return "".join(f"espalier: {name}: dropped 1 unused vertex (vertex 0)\n"
                           for name in names)

        def deform(rest, *poses, out="out.obj"):
            return self.run_program("deform", "model.obj", "--rest", rest, "--to", *poses, "-n", 2,
                                    "-o", out, "--quiet").stderr

        deform("rest.ovm", "pose.ovm", out="plain.obj")
        plain = self.bytes("plain.obj")
        for rest, pose in [("rest+.ovm", "pose+.ovm"), ("rest.ovm", "pose+.ovm"),
                           ("rest+.ovm", "pose.ovm")]:
            names = [name for name in [rest, pose] if "+" in name]
            self.assertEqual(deform(rest, pose), note(*names))
            self.assertEqual(self.bytes("out.obj"), plain)
        # If several poses have the same unused vertex, only the first one gets a note.
        self.assertEqual(deform("rest+.ovm", "pose+.ovm", "rest+.ovm", "pose.ovm", "pose+.ovm"),
                         note("rest+.ovm", "pose+.ovm", "pose+.ovm"))

        quiet = ["-n", 1, "--quiet"]
        self.run_program("shape", "box", "--min", 1, 0, 0, "--max", 2, 1, 1, "--cells", 2, 2, 2,
                         "-o", "other.ovm")
        for arguments in [["bind", "model.obj", "--rest", "rest+.ovm", "-n", 2, "-o", "m.espb",
                           "--quiet"],
                          ["refine", "rest+.ovm", "-o", "refined.ovm", *quiet],
                          ["stencils", "rest+.ovm", "-o", "S.mtx", *quiet],
                          ["shape", "merge", "rest+.ovm", "other.ovm", "-o", "merged.ovm"],
                          ["info", "rest+.ovm", "--json"]]:
            self.assertEqual(self.run_program(*arguments).stderr, note("rest+.ovm"), arguments)
        self.assertEqual(self.info("rest+.ovm", "-n", 0)["levels"][0]["counts"]["vertices"], 27)
        self.assertEqual(self.run_program("apply", "m.espb", "--to", "pose+.ovm", "-o", "out.obj",
                                          "--quiet").stderr, note("pose+.ovm"))
        self.assertEqual(self.bytes("out.obj"), plain)
        self.assertEqual(self.run_program("check", "pose+.ovm", "--rest", "rest+.ovm", *quiet).stderr,
                         note("rest+.ovm", "pose+.ovm"))
        # A written pose lacks the vertex, and is a pose of both lattices.
        result = self.run_program("fit", "model.obj", "--rest", "rest+.ovm", "--targets",
                                  "plain.obj", "-o", "fitted.ovm", *quiet)
        self.assertEqual(result.stderr, note("rest+.ovm"))
        self.assertEqual(len(self.read_ovm_positions("fitted.ovm")), 27)
        self.assertEqual(deform("rest+.ovm", "fitted.ovm"), note("rest+.ovm"))

    def test_pose_of_another_topology_is_refused(self):
        self.run_program("shape", "box", "--cells", 2, 2, 1, "-o", "other.ovm")
        self.bind("model.obj", "rest.vtu", out="m.espb")
        for arguments in [["deform", "model.obj", "--rest", "rest.vtu"], ["apply", "m.espb"]]:
            error = self.error_of(*arguments, "--to", "other.ovm", "-o", "out.obj")
            self.assertIn("other.ovm: is not a pose of", error)
            self.assertIn("18", error, "says what differs: 18 vertices, not 27")
            self.assertFalse((self.path / "out.obj").exists())

    def test_damaged_bindings_are_refused(self):
        self.bind("model.obj", "rest.vtu", out="m.espb")
        data = self.bytes("m.espb")
        (self.path / "cut.espb").write_bytes(data[:-100])
        (self.path / "bad.espb").write_bytes(data[:2000] + b"?" + data[2001:])
        for name, cause in [("cut", "truncated"), ("bad", "checksum")]:
            self.assertIn(cause, self.error_of("apply", f"{name}.espb", "--to", "pose.vtk", "-o",
                                               "out.obj"))

    def test_bad_files_are_named_with_line_and_cause(self):
        self.put("bad.obj", "v 0 0 0\nv 1 x 0\n")
        self.assertIn("bad.obj:2: ", self.error_of("deform", "bad.obj", "--rest", "rest.vtu",
                                                   "--to", "pose.vtk", "-o", "out.obj"))
        self.put("bad.ovm", "OVM ASCII\nVertices\n2\n0 0 0\n1 nonsense 0\n")
        self.assertIn("bad.ovm:5: ", self.error_of("info", "bad.ovm"))
        self.assertIn("none.vtu: ", self.error_of("info", "none.vtu"))
        self.assertIn("model.xyz", self.error_of("deform", "model.xyz", "--rest", "rest.vtu",
                                                 "--to", "pose.vtk", "-o", "out.obj"))

    def test_outputs_do_not_replace_inputs(self):
        self.bind("model.obj", "rest.vtu", out="m.espb")
        for arguments in [["stencils", "rest.vtu", "-o", "rest.vtu"],
                          ["refine", "rest.vtu", "-o", "./rest.vtu"],
                          ["bind", "model.obj", "--rest", "rest.vtu", "-o", "model.obj"],
                          ["bind", "model.obj", "--rest", "rest.vtu", "-o", "m.bin"],
                          ["apply", "m.espb", "--to", "pose.vtk", "-o", "m.espb"],
                          ["deform", "model.obj", "--rest", "rest.vtu", "--to", "pose.vtk", "-o",
                           "model.obj"]]:
            before = {name: self.bytes(name) for name in os.listdir(self.path)}
            self.error_of(*arguments)
            self.assertEqual(before, {name: self.bytes(name) for name in os.listdir(self.path)})

    def test_full_standard_output_is_an_error(self):
        with open("/dev/full", "w") as full:
            result = subprocess.run([program.ESPALIER, "info", "rest.vtu"], cwd=self.path,
                                    stdout=full, stderr=subprocess.PIPE, text=True, timeout=120)
        self.assertEqual(result.returncode, 1)
        self.assertIn("standard output", result.stderr)

    def test_float_models_come_back_within_their_precision(self):
        header = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(self.points)
        header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
        numbers = [x for point in self.points for x in point]
        (self.path / "m.ply").write_bytes(header.encode() + struct.pack(f"<{len(numbers)}f",
                                                                       *numbers))
        self.deform("m.ply", "rest.vtu", "rest.vtu", out="out.ply")
        self.assertEqual(self.bytes("out.ply"), self.bytes("m.ply"))

    def test_rules_without_smooth_triangles(self):
        self.run_program("shape", "cylinder", "--sectors", 5, "--layers", 2, "-o", "c.ovm")
        error = self.error_of("refine", "c.ovm", "-n", 1, "--rules", "mlca", "--triangles", "smooth",
                              "-o", "out.ovm")
        self.assertIn("c.ovm: the rules of MLCA do not have smooth triangles", error)

    def test_usage_errors(self):
        for arguments in [[], ["unknown"], ["deform"], ["info", "rest.vtu", "-n", "many"],
                          ["info", "rest.vtu", "--rules", "other"],
                          ["info", "rest.vtu", "--threads", -1],
                          ["bind", "model.obj", "--rest", "rest.vtu", "-o", "m.espb",
                           "--tolerance", "nan"],
                          ["deform", "model.obj", "--rest", "rest.vtu", "-n", 0, "--to",
                           "pose.vtk", "-o", "out.obj"]]:
            self.error_of(*arguments, code=2)
        self.assertIn("Usage", self.run_program("--help").stdout)
        self.run_program("--version")


if __name__ == "__main__":
    EXAMPLE = os.path.abspath(sys.argv.pop())
    program.ESPALIER = os.path.abspath(sys.argv.pop())
    unittest.main()
