#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the program espalier, and the example of the README, as their users do.

    cli_test.py PATH_OF_ESPALIER PATH_OF_THE_EXAMPLE
"""

import math
import os
import struct
import subprocess
import sys
import unittest

import program
from program import CliTest, icosphere_points

EXAMPLE = ""


class Shapes(CliTest):
    def test_every_shape_is_written_in_every_format_and_reads_back(self):
        names = ["box", "cylinder", "torus", "star", "barbell", "arm", "tetrahedron", "cube",
                 "octahedron", "dodecahedron", "icosahedron", "prism", "pyramid", "bipyramid"]
        for name in names:
            levels = []
            for extension in ["ovm", "vtu", "vtk"]:
                file = f"{name}.{extension}"
                self.run_program("shape", name, "-o", file, "--quiet")
                report = self.info(file, "-n", 1)["levels"]
                self.assertEqual(report[0]["inverted_cells"], 0, name)
                # Volumes are sums over faces, and formats may change the order of faces.
                levels.append([{key: level[key] for key in level if "volume" not in key}
                               for level in report])
            self.assertEqual(levels[0], levels[1], name)
            self.assertEqual(levels[0], levels[2], name)

    def test_options_and_their_errors(self):
        self.run_program("shape", "box", "--cells", 4, 2, 1, "--min", -1, -1, -1, "-o", "b.ovm")
        report = self.info("b.ovm", "-n", 0)
        self.assertEqual(report["bounds"], [[-1, -1, -1], [1, 1, 1]])
        self.assertEqual(report["levels"][0]["counts"]["cells"], 8)
        for options, message in [
                (["box", "--cells", 0, 1, 1], "--cells[0] is 0; allowed: 1 or more"),
                (["box", "--min", 1, 1, 1, "--max", 0, 0, 0],
                 "--max[0] is 0; allowed: numbers above --min[0], which is 1"),
                (["torus", "--minor-radius", 3],
                 "--minor-radius is 3; allowed: numbers below --major-radius, which is 1"),
                (["torus", "--grid", 0], "--grid is 0; allowed: 1 or more"),
                (["arm", "--joint", 0, 0, 0, 1, "--joint", 0, 0, 0, 1],
                 "--joint[1].position is (0, 0, 0); allowed: a position other than the one of the "
                 "joint before")]:
            self.assertEqual(self.error_of("shape", *options, "-o", "c.ovm", code=2),
                             f"espalier: {message}\n")
        self.assertFalse((self.path / "c.ovm").exists())
        self.assertIn(".foo", self.error_of("shape", "box", "-o", "c.foo"))
        self.error_of("shape", "nonsense", "-o", "c.ovm", code=2)
        self.error_of("shape", "arm", "--joint", "1,2,x,4", "-o", "c.ovm", code=2)

    def test_merge(self):
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", 1, 0, 0, "--max", 2, 1, 1, "-o", "b.ovm")
        self.assertEqual(self.run_program("shape", "merge", "a.ovm", "b.ovm", "-o", "ab.ovm").stdout,
                         "ab.ovm: 12 vertices, 2 cells; 4 vertices welded, 1 face shared\n")
        self.assertEqual(self.info("ab.ovm", "-n", 0)["levels"][0]["counts"],
                         {"vertices": 12, "edges": 20, "faces": 11, "cells": 2})

    def test_merges_of_parts_that_share_no_face_need_allow_separate(self):
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "two.ovm")
        self.run_program("shape", "box", "--cells", 3, 3, 2, "--min", 0, 0, 1, "--max", 1, 1, 2,
                         "-o", "three.ovm")
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", .5, .5, .5, "--max", 2, 2, 2, "-o", "over.ovm")
        for first, second, size, counts in [
                ("two.ovm", "three.ovm", "71 vertices, 26 cells", "4 vertices welded, 0 faces shared"),
                ("a.ovm", "over.ovm", "16 vertices, 2 cells", "0 vertices welded, 0 faces shared")]:
            error = self.error_of("shape", "merge", first, second, "-o", "m.ovm")
            self.assertRegex(error, rf"^espalier: {second}: is not joined to {first}: .*{counts}"
                                    ".*--allow-separate")
            self.assertFalse((self.path / "m.ovm").exists())
            self.assertEqual(self.run_program("shape", "merge", first, second, "--allow-separate",
                                              "-o", "m.ovm").stdout, f"m.ovm: {size}; {counts}\n")
            (self.path / "m.ovm").unlink()

    def test_refused_merges_name_the_files(self):
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", 5, 0, 0, "--max", 6, 1, 1, "-o", "far.ovm")
        self.run_program("shape", "merge", "far.ovm", "a.ovm", "--allow-separate",
                         "-o", "two.vtu")
        self.assertEqual(self.error_of("shape", "merge", "two.vtu", "a.ovm", "-o", "m.vtu"),
                         "espalier: cell 1 of two.vtu, cell 0 of a.ovm would become one cell; "
                         "each cell may be in one lattice only\n")
        self.run_program("shape", "box", "--cells", 2, 1, 1, "--max", 2, 1, 1, "-o", "row.ovm")
        self.assertRegex(self.error_of("shape", "merge", "row.ovm", "a.ovm", "-o", "m.vtu"),
                         r"^espalier: face \d+ of row.ovm, face \d of a.ovm would become one "
                         r"face of more than two cells\n$")
        self.assertRegex(self.error_of("shape", "merge", "far.ovm", "a.ovm", "--tolerance", 0.5,
                                       "-o", "m.vtu"),
                         r"^espalier: vertices \d and \d of cell 0 of far.ovm would become")
        self.assertFalse((self.path / "m.vtu").exists())

    def test_a_file_with_the_name_of_an_option_is_no_option(self):
        self.run_program("shape", "box", "-o", "output.vtu")
        self.run_program("shape", "box", "--min", 1, 0, 0, "--max", 2, 1, 1, "-o", "a.vtu")
        self.put("a.vtu", self.text("a.vtu").replace(
            "<PointData>", '<PointData><DataArray type="Float64" Name="t" format="ascii">'
                           "0 0 0 0 0 0 0 0</DataArray>"))
        for inputs in [("a.vtu", "output.vtu"), ("output.vtu", "a.vtu")]:
            self.assertEqual(self.error_of("shape", "merge", *inputs, "-o", "c.vtu"),
                             "espalier: output.vtu lacks attribute 't', which a.vtu has\n")

    def test_a_merge_does_not_replace_an_input(self):
        self.run_program("shape", "box", "-o", "a.ovm")
        self.run_program("shape", "box", "--min", 1, 0, 0, "--max", 2, 1, 1, "-o", "b.ovm")
        before = self.bytes("b.ovm")
        self.assertIn("b.ovm: is also an input",
                      self.error_of("shape", "merge", "a.ovm", "b.ovm", "-o", "b.ovm"))
        self.assertEqual(self.bytes("b.ovm"), before)


class Info(CliTest):
    def test_counts_strata_and_types(self):
        self.run_program("shape", "bipyramid", "--sides", 5, "-o", "b.ovm")
        report = self.info("b.ovm", "-n", 2)
        types = [level["cell_types"] for level in report["levels"]]
        # There are two apexes of valence 5 and five vertices of valence 4 around the middle. The number
        # of cells of each type doubles at each level.
        self.assertEqual(types, [{"4": 5, "5": 2}, {"4": 5, "5": 2},
                                 {"3": 5 * 8 + 2 * 10, "4": 10, "5": 4}])
        self.assertEqual(report["levels"][0]["strata"]["vertices"]["corner"], 7)
        self.assertIn("type-5: 4", self.run_program("info", "b.ovm", "-n", 2).stdout)

    def test_interior_edges_of_two_faces_are_reported(self):
        # A folded wall cuts a box in two. The edge of the fold, from vertex 5 to 12, lies in the two halves
        # of the wall only.
        plan = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (1.3, 1), (1, 2)]
        points = [(x, y, z) for z in (0, 1) for x, y in plan]
        cells = []
        for outline in [[0, 4, 5, 6, 3], [4, 1, 2, 6, 5]]:
            cells.append([outline, [v + 7 for v in outline]] +
                         [[a, b, b + 7, a + 7] for a, b in zip(outline, outline[1:] + outline[:1])])
        self.write_polyhedra(points, cells, "folded.vtk")
        self.assertEqual(self.info("folded.vtk", "-n", 1)["interior_edges_of_two_faces"], 1)
        self.assertIn("negative weight", self.run_program("info", "folded.vtk").stdout)
        for rules in ["cse96", "mlca"]:
            text = self.run_program("info", "folded.vtk", "--rules", rules).stdout
            self.assertNotIn("negative weight", text)
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "b.ovm")
        self.assertEqual(self.info("b.ovm", "-n", 0)["interior_edges_of_two_faces"], 0)

    def write_polyhedra(self, points, cells, name):
        streams = []
        for faces in cells:
            stream = [len(faces)] + [n for face in faces for n in [len(face)] + face]
            streams.append([len(stream)] + stream)
        lines = ["# vtk DataFile Version 3.0", "polyhedra", "ASCII",
                 "DATASET UNSTRUCTURED_GRID", f"POINTS {len(points)} double"]
        lines += [" ".join(map(str, point)) for point in points]
        lines += [f"CELLS {len(cells)} {sum(map(len, streams))}"]
        lines += [" ".join(map(str, stream)) for stream in streams]
        lines += [f"CELL_TYPES {len(cells)}"] + ["42"] * len(cells)
        self.put(name, "\n".join(lines) + "\n")

    def test_rules_and_boundary_are_heard(self):
        self.run_program("shape", "cylinder", "--sectors", 6, "-o", "c.ovm")
        sharp = self.info("c.ovm", "-n", 0)["levels"][0]["strata"]["edges"]["sharp"]
        literal = self.info("c.ovm", "-n", 0, "--sharp-edges", "literal")
        self.assertEqual(sharp, 12)
        self.assertEqual(literal["levels"][0]["strata"]["edges"]["sharp"], 18)
        self.assertIn("c.ovm", self.error_of("info", "c.ovm", "--boundary", "open"))


class RefineAndStencils(CliTest):
    def test_rows_of_stencils_and_vertices_of_refine_are_in_one_order(self):
        self.run_program("shape", "octahedron", "-o", "o.ovm")
        self.run_program("refine", "o.ovm", "-n", 2, "-o", "r.ovm")
        self.run_program("stencils", "o.ovm", "-n", 2, "-o", "s.mtx")
        base = self.read_ovm_positions("o.ovm")
        refined = self.read_ovm_positions("r.ovm")
        lines = [line for line in self.text("s.mtx").splitlines() if not line.startswith("%")]
        rows, columns, entries = map(int, lines[0].split())
        self.assertEqual((rows, columns, entries), (len(refined), len(base), len(lines) - 1))
        self.assert_close(self.product("s.mtx", base), refined, 1e-15)

    def test_meshes_are_refined_like_lattices(self):
        creases = ["t crease 2/1/0 5 6 2.5", "t corner 1/1/0 10 0.5"]
        self.write_mesh(creases)
        self.run_program("refine", "mesh.obj", "-n", 2, "-o", "r2.obj")
        self.run_program("stencils", "mesh.obj", "-n", 2, "-o", "s.mtx")
        refined = self.read_points("r2.obj")
        self.assertEqual(len(refined), 13 * 13)
        self.assert_close(self.product("s.mtx", self.read_points("mesh.obj")), refined, 1e-15)
        # The sharpness that remains is used in the next step.
        self.run_program("refine", "mesh.obj", "-n", 1, "-o", "r1.obj")
        self.assertIn("t crease 2/1/0 5 ", self.text("r1.obj"))
        self.run_program("refine", "r1.obj", "-n", 1, "-o", "r11.obj")
        self.assert_close(sorted(self.read_points("r11.obj")), sorted(refined), 1e-14)
        # Without sharpness the mesh is different.
        self.write_mesh()
        self.run_program("refine", "mesh.obj", "-n", 2, "-o", "smooth.obj")
        self.assertGreater(max(map(math.dist, refined, self.read_points("smooth.obj"))), 1e-3)

    def test_refining_twice_keeps_corners_under_every_boundary_mode(self):
        # Vertex 0 is marked as sharp. With edge-only, nothing else makes it sharp.
        self.put("cube.ovm", "".join([
            "OVM ASCII\nVertices\n8\n", *(f"{i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8)),
            "Edges\n12\n0 1\n1 3\n3 2\n2 0\n4 5\n5 7\n7 6\n6 4\n0 4\n1 5\n2 6\n3 7\n",
            "Faces\n6\n4 0 2 4 6\n4 8 10 12 14\n4 0 18 9 17\n4 2 22 11 19\n4 4 20 13 23\n"
            "4 6 16 15 21\n",
            "Polyhedra\n1\n6 1 2 4 6 8 10\n",
            "VProp double \"espalier:vertex_sharpness\"\n10\n", "-1\n" * 7,
            "EProp double \"espalier:edge_sharpness\"\n", "0\n" * 12]))
        options = ["--boundary", "edge-only"]
        self.run_program("refine", "cube.ovm", "-n", 2, "-o", "r2.ovm", *options)
        self.run_program("refine", "cube.ovm", "-n", 1, "-o", "r1.ovm", *options)
        self.run_program("refine", "r1.ovm", "-n", 1, "-o", "r11.ovm", *options)
        corner = min(self.read_ovm_positions("r2.ovm"))
        self.assertEqual(corner, (0, 0, 0))
        self.assert_close(sorted(self.read_ovm_positions("r11.ovm")),
                          sorted(self.read_ovm_positions("r2.ovm")), 1e-14)

    def test_tags_win_over_the_default_and_options_over_tags(self):
        def corner_of(*options):
            """Returns how far the corner at the origin has moved."""
            self.run_program("refine", "mesh.obj", "-n", 1, "-o", "r.obj", *options)
            return min(math.dist(p, (0, 0, 0)) for p in self.read_points("r.obj"))
        self.write_mesh()
        self.assertEqual(corner_of(), 0)
        self.assertGreater(corner_of("--boundary", "edge-only"), 0.1)
        self.write_mesh(["t interpolateboundary 1/0/0 2"])
        self.assertGreater(corner_of(), 0.1)
        self.assertEqual(corner_of("--boundary", "sharp"), 0)
        self.assertGreater(corner_of("--boundary", "open"), 0.5)

        creases = ["t crease 2/1/0 4 5 1.5", "t crease 2/1/0 5 6 3.5"]
        def points_of(tags, *options):
            self.write_mesh([*creases, *tags])
            self.run_program("refine", "mesh.obj", "-n", 2, "-o", "r.obj", *options)
            return self.read_points("r.obj")
        chaikin = points_of(["t creasemethod 0/0/1 chaikin"])
        self.assertNotEqual(chaikin, points_of([]))
        self.assertEqual(chaikin, points_of([], "--creasing", "chaikin"))
        self.assertEqual(points_of([]),
                         points_of(["t creasemethod 0/0/1 chaikin"], "--creasing", "uniform"))

        self.put("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                         "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        self.run_program("refine", "t.obj", "-n", 1, "-o", "a.obj")
        self.run_program("refine", "t.obj", "-n", 1, "-o", "b.obj", "--triangles", "smooth")
        self.assertNotEqual(self.read_points("a.obj"), self.read_points("b.obj"))

    def test_meshes_are_for_some_commands_and_formats(self):
        self.write_mesh()
        self.assertIn("out.ovm", self.error_of("refine", "mesh.obj", "-n", 1, "-o", "out.ovm"))
        self.assertFalse((self.path / "out.ovm").exists())
        self.run_program("shape", "box", "-o", "b.ovm")
        self.assertIn("b.stl", self.error_of("refine", "b.ovm", "-n", 1, "-o", "b.stl"))
        self.write_mesh(["t crease 2/1/0 0 9 1"])
        error = self.error_of("refine", "mesh.obj", "-n", 1, "-o", "out.obj")
        self.assertIn("mesh.obj:26", error)
        self.assertIn("(0, 9)", error)

    def test_texture_coordinates_of_a_mesh_are_refined(self):
        corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
        self.put("quad.obj", "".join(f"v {x} {y} 0\nvt {x} {y}\n" for x, y in corners) +
                 "f 1/1 2/2 3/3 4/4\n")

        def refined(*options):
            self.run_program("refine", "quad.obj", "-n", 1, *options, "-o", "out.obj")
            lines = self.text("out.obj").splitlines()
            self.assertEqual(sum(line.startswith("f ") and "/" in line for line in lines), 4)
            return {tuple(map(float, line.split()[1:])) for line in lines if line[:3] == "vt "}
        grid = {(x / 2, y / 2) for x in range(3) for y in range(3)}
        self.assertEqual(refined(), grid)  # the default, all: bilinear
        self.assertEqual(refined("--face-varying", "corners-only"), grid)
        # The crease mask of a corner that is not sharp: 3/4 of itself, 1/8 of each neighbour. The
        # corner of the mesh, which is sharp by default, must be smooth too.
        self.assertIn((0, 0), refined("--face-varying", "none"))
        smooth = refined("--face-varying", "none", "--boundary", "edge-only")
        self.assertIn((0.125, 0.125), smooth)
        self.assertIn((0.5, 0), smooth)

        # A corner without a texture coordinate: a note says how many are dropped.
        self.put("part.obj", self.text("quad.obj").replace("4/4", "4"))
        result = self.run_program("refine", "part.obj", "-n", 1, "-o", "out.obj")
        self.assertIn("part.obj: dropped 4 texture coordinates", result.stderr)
        self.assertNotIn("vt", self.text("out.obj"))

    def test_attributes_are_refined_with_the_positions(self):
        # The attribute is the z coordinate of a cube, so on the refined lattice it is z again.
        self.run_program("shape", "box", "-o", "b.vtk")
        text = self.text("b.vtk")
        points = text.split("double\n")[1].split("CELLS")[0].split()
        self.assertEqual(len(points), 24)
        with open(self.path / "b.vtk", "a") as file:
            file.write("POINT_DATA 8\nSCALARS height double 1\nLOOKUP_TABLE default\n" +
                       "\n".join(points[2::3]) + "\n")
        self.run_program("refine", "b.vtk", "-n", 2, "-o", "r.ovm")
        lines = self.text("r.ovm").splitlines()
        at = next(i for i, line in enumerate(lines) if "height" in line)
        heights = [float(line) for line in lines[at + 1:at + 1 + 125]]
        self.assertEqual(heights, [p[2] for p in self.read_ovm_positions("r.ovm")])

    def test_integers_are_carried_and_never_averaged(self):
        # The identifiers exceed 2^53, so a double could not hold them, and unsigned types have no −1.
        gids = [2**53 + 1 + 2 * i for i in range(8)]
        large = [2**64 - 2 - i for i in range(8)]
        self.run_program("shape", "box", "-o", "b.vtk")
        with open(self.path / "b.vtk", "a") as file:
            file.write("POINT_DATA 8\nSCALARS material unsigned_char 1\nLOOKUP_TABLE default\n" +
                       "1 2 3 4 5 6 7 8\nFIELD f 3\n" +
                       "gid 1 8 vtktypeint64\n" + " ".join(map(str, gids)) + "\n" +
                       "heat 1 8 float\n1 2 3 4 5 6 7 8\n" +
                       "large 1 8 vtktypeuint64\n" + " ".join(map(str, large)) + "\n")
        self.run_program("refine", "b.vtk", "-n", 0, "-o", "b.vtu")
        for source in ("b.vtk", "b.vtu"):
            self.run_program("refine", source, "-n", 1, "-o", "r.vtk")
            text = self.text("r.vtk")
            for name, type_, values, none in (
                    ("gid", "vtktypeint64", gids, -1),
                    ("large", "vtktypeuint64", large, 2**64 - 1),
                    ("material", "unsigned_char", list(range(1, 9)), 255)):
                head = f"\n{name} 1 27 {type_}\n"
                self.assertIn(head, text)
                got = list(map(int, text.split(head)[1].split()[:27]))
                self.assertEqual(got, values + [none] * 19)
            self.assertIn("\nheat 1 27 double\n", text)
            self.assertEqual(self.info(source, "-n", 0)["attributes"],
                             ["heat", "material", "gid", "large"])
        self.run_program("refine", "b.vtu", "-n", 2, "-o", "r.ovm")
        text = self.text("r.ovm")
        self.assertEqual(list(map(int, text.split('VProp long "gid"\n')[1].split()[:125])),
                         gids + [-1] * 117)

    def test_attributes_that_are_not_finite_are_named(self):
        self.run_program("shape", "box", "-o", "b.vtk")
        plain = self.text("b.vtk")
        self.put("b.vtk",
            plain + "POINT_DATA 8\nFIELD f 4\n"
            "fine 1 8 double\n1 2 3 4 5 6 7 8\n"
            "heat 1 8 double\n1 2 3 nan 5 6 -inf 8\n"
            "uv 2 8 double\n0 0 0 0 0 0 0 0 0 0 0 inf 0 0 0 0\n"
            "%1B[2Jbad 1 8 float\nnan 2 3 4 5 6 7 8\n")
        for quiet in ([], ["--quiet"]):
            lines = self.run_program("refine", "b.vtk", "-n", 1, "-o", "r.vtk",
                                     *quiet).stderr.splitlines()
            self.assertEqual(len(lines), 3, lines)
            self.assertIn("b.vtk: the attribute 'heat' has 2 values that are not finite, the first "
                          "at vertex 3 (nan)", lines[0])
            self.assertIn("'uv' has 1 value that is not finite, the first at vertex 5 (inf)",
                          lines[1])
            self.assertIn("at vertex 0 (nan)", lines[2])
            self.assertNotIn("\x1b", lines[2])
        self.put("b.vtk", plain.replace("double\n0", "double\nnan", 1))
        self.assertIn("b.vtk: ", self.error_of("refine", "b.vtk", "-n", 1, "-o", "r.vtu"))

    def test_marks_keep_the_strata_of_a_refined_lattice(self):
        self.run_program("shape", "cylinder", "-o", "c.vtu")
        self.run_program("refine", "c.vtu", "-n", 1, "--sharp-edges", "literal", "-o", "r.vtu")
        direct = self.info("c.vtu", "-n", 1, "--sharp-edges", "literal")["levels"][1]
        again = self.info("r.vtu", "-n", 0)["levels"][0]
        self.assertEqual(direct["strata"], again["strata"])

    def test_refining_twice_is_refining_by_two_levels(self):
        self.run_program("shape", "torus", "-o", "t.ovm")
        self.run_program("refine", "t.ovm", "-n", 2, "-o", "r2.ovm")
        self.run_program("refine", "t.ovm", "-n", 1, "-o", "r1.ovm")
        self.run_program("refine", "r1.ovm", "-n", 1, "-o", "r11.ovm")
        twice = sorted(self.read_ovm_positions("r11.ovm"))
        self.assert_close(twice, sorted(self.read_ovm_positions("r2.ovm")), 1e-14)


class Compare(CliTest):
    def setUp(self):
        super().setUp()
        result = subprocess.run([program.ESPALIER, "compare"], capture_output=True, text=True)
        if "without OpenSubdiv" in result.stderr:
            self.skipTest("espalier was built without OpenSubdiv")

    def test_meshes_and_lattices_agree_with_opensubdiv(self):
        self.write_mesh(["t crease 2/1/0 5 6 2.5", "t interpolateboundary 1/0/0 2"])
        self.run_program("shape", "star", "-o", "star.vtu")
        output = self.run_program("compare", "mesh.obj", "star.vtu", "-n", 2).stdout
        lines = output.splitlines()
        self.assertEqual(len(lines), 5, output)
        for line, name, level in zip(lines, ["mesh.obj"] * 2 + ["star.vtu"] * 2, [1, 2, 1, 2]):
            self.assertTrue(line.startswith(name), line)
            self.assertIn(f"level {level}", line)
            self.assertTrue(line.endswith("agrees"), line)
        self.assertIn("2 of 2 files agree with OpenSubdiv", lines[-1])
        self.assertEqual(self.run_program("compare", "mesh.obj", "--quiet").stdout, "")

    def test_every_boundary_mode(self):
        self.write_mesh()
        for options in [["--boundary", "edge-only"], ["--boundary", "open"],
                        ["--creasing", "chaikin"], ["--triangles", "smooth"]]:
            self.run_program("compare", "mesh.obj", "-n", 2, *options)

    def test_report(self):
        self.write_mesh()
        self.run_program("shape", "torus", "-o", "torus.ovm")
        self.run_program("compare", "mesh.obj", "torus.ovm", "-n", 2, "--html", "report.html")
        report = self.text("report.html")
        for text in ["<!DOCTYPE html>", "mesh.obj", "torus.ovm", "<svg"]:
            self.assertIn(text, report)
        for outside in ["<script src", "<link", "@import", "src=\"http"]:
            self.assertNotIn(outside, report)
        self.assertIn("mesh.obj", self.error_of("compare", "mesh.obj", "--html", "mesh.obj"))

    def write_creased_octahedron(self, name):
        """Where semi-sharp edges meet, OpenSubdiv and we add up their sharpness in single precision,
        in different orders: weights differ by some 1e-9, more than the bound of 1e-14."""
        positions = ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1"]
        faces = ["1 3 5", "3 2 5", "2 4 5", "4 1 5", "3 1 6", "2 3 6", "4 2 6", "1 4 6"]
        sharpness = {(0, 2): 2.8, (0, 3): 1.8, (0, 4): 1.9, (0, 5): 2.4, (1, 2): 3.8, (1, 3): 1.8,
                     (1, 4): 2.9, (1, 5): 1.4, (2, 4): 2.3, (2, 5): 1.1, (3, 4): 3.4, (3, 5): 1.7}
        lines = [f"v {position}" for position in positions] + [f"f {face}" for face in faces]
        lines += [f"t crease 2/1/0 {a} {b} {value}" for (a, b), value in sharpness.items()]
        self.put(name, "\n".join(lines) + "\n")

    def test_differences_have_an_exit_code_of_their_own(self):
        self.write_mesh()
        self.write_creased_octahedron("creased.obj")
        arguments = ["mesh.obj", "creased.obj", "-n", 3, "--creasing", "chaikin"]
        result = self.run_program("compare", *arguments, "--html", "report.html", code=3)
        self.assertRegex(result.stderr, r"^espalier: creased.obj: differs from OpenSubdiv \S+ at level "
                                        r"[23]\n$")
        lines = result.stdout.splitlines()
        self.assertEqual([line.split()[-1] for line in lines if line.startswith("mesh.obj")],
                         ["agrees"] * 3)
        self.assertRegex(result.stdout, r"\ncreased.obj  level 3 [^\n]* DIFFERS\n")
        self.assertIn("note: OpenSubdiv adds three or more semi-sharp values", result.stdout)
        self.assertNotIn("files agree", result.stdout)
        self.assertIn("differs", self.text("report.html"))
        self.assertEqual(self.run_program("compare", *arguments, "--quiet", code=3).stdout, "")
        # A file that cannot be compared decides the exit code.
        self.run_program("compare", *arguments, "none.obj", "--quiet", code=1)
        # The tags cause the difference: without them both agree.
        text = self.text("creased.obj")
        self.put("creased.obj", text.split("t crease")[0])
        self.run_program("compare", *arguments)

    def test_what_cannot_be_compared_is_named_and_fails(self):
        self.write_mesh()
        self.run_program("shape", "box", "--cells", 3, 3, 3, "-o", "box.ovm")
        result = self.run_program("compare", "none.obj", "mesh.obj", "-n", 1, code=1)
        self.assertIn("none.obj  could not be compared", result.stdout)
        self.assertIn("agrees", result.stdout)
        self.assertIn("none.obj: cannot open", result.stderr)
        error = self.error_of("compare", "none.obj", "neither.obj", "mesh.obj", "--quiet")
        self.assertIn("none.obj: cannot open", error)
        self.assertIn("1 more of 3", error)
        error = self.error_of("compare", "box.ovm", "--boundary", "open")
        self.assertIn("box.ovm: with the boundary mode 'open'", error)
        # With the boundary mode open, nothing is left of such a small mesh.
        self.put("small.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        self.error_of("compare", "small.obj", "--boundary", "open")
        self.assertIn("no folder", self.error_of("compare", "mesh.obj", "--html", "none/r.html"))


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
        for word in ["placement error", "weights for each point", "peak memory", "binding"]:
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
        self.assertIn("binding ...", shown)
        self.assertIn("binding ... 100 %", shown)
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
        self.write_model([(.5, .5, .5), (.2, .2, .3), (3, 3, 3)])
        self.put("targets.txt", "0 .6 .5 .5\n2 3 3 3\n")
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
        self.write_model([(3, 3, 3), (4, 4, 4), (5, 5, 5)])
        self.assertIn("warning: 3 of 3 points are outside the lattice and stay in place. Use",
                      self.run_program(*commands["bind"]).stderr)
        self.write_model([(.3, .3, .3), (.4, .4, .4), (.5, .5, .5)])
        self.assertEqual(self.run_program(*commands["bind"]).stderr, "")

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

    def test_rules_reach_the_weights(self):
        # Five wedges meet at the axis of a pentagonal cylinder, where all rules differ.
        self.run_program("shape", "cylinder", "--sectors", 5, "--layers", 2, "-o", "c.ovm")
        outputs = set()
        for rules in ["siggraph96", "cse96", "mlca"]:
            self.run_program("stencils", "c.ovm", "-n", 1, "--rules", rules, "-o", "s.mtx")
            outputs.add(self.text("s.mtx"))
        self.assertEqual(len(outputs), 3)
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
