#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier refine` and `espalier stencils`: lattices and meshes, their attributes and marks.

    refine_command_test.py PATH_OF_ESPALIER
"""

import math
import sys
import unittest

import program
from program import CliTest


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


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
