#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier info` of models and lattices.

    info_command_test.py PATH_OF_ESPALIER
"""

import math
import pathlib
import subprocess
import sys
import unittest

import program
from program import CliTest

# Models that are not part of the repository: tried where they are there.
MODELS = pathlib.Path(__file__).resolve().parents[3] / "shared/data/models"

# Two tetrahedra without common points, 3 wide in x, and a point in no face.
TWO = """v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 1\nv 2 0 0\nv 3 0 0\nv 2 1 0\nv 2 0 6\nv 1 1 1
f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 5 7 6\nf 5 6 8\nf 6 7 8\nf 7 5 8\n"""


class ModelInfo(CliTest):
    def test_the_surface_of_a_model_is_described(self):
        self.put("two.obj", TWO)
        report = self.info("two.obj")
        self.assertAlmostEqual(report.pop("diagonal"), 7, delta=1e-15)
        self.assertEqual(report, {
            "model": "two.obj", "points": 9, "faces": 8, "points_in_no_face": 1, "components": 2,
            "closed": True, "boundary_edges": 0, "nonmanifold_edges": 0,
            "bounds": [[0, 0, 0], [3, 2, 6]], "size": [3, 2, 6], "attributes": [], "groups": [], "notes": [],
            "precision": "text"})
        self.assertEqual(self.run_program("info", "two.obj").stdout, (
            "two.obj\n"
            "points      9, of which 1 in no face\n"
            "faces       8\n"
            "surface     2 components, closed\n"
            "bounds      (0, 0, 0) to (3, 2, 6)\n"
            "size        3 × 2 × 6, diagonal 7\n"
            "precision   text\n"))

    def test_the_parts_of_a_model_are_named(self):
        self.put("two.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\ng upper arm\nusemtl red\nf 1 2 3\n")
        report = self.info("two.obj")
        self.assertEqual((report["attributes"], report["groups"]),
                         (["red", "green", "blue"], ["upper", "arm", "red"]))
        self.assertTrue(self.run_program("info", "two.obj").stdout.endswith(
            "precision   text\nattributes  red, green, blue\ngroups      upper, arm, red\n"))

    def test_open_and_nonmanifold_surfaces_are_not_closed(self):
        # Without one face, its three edges are in one face; a fin on an edge gives it three.
        self.put("open.obj", TWO.replace("f 7 5 8\n", "f 1 2 9\n"))
        report = self.info("open.obj")
        self.assertEqual((report["closed"], report["boundary_edges"], report["nonmanifold_edges"]),
                         (False, 3 + 2, 1))
        self.assertIn("surface     2 components, not closed: 5 edges in one face, 1 in more than "
                      "two\n", self.run_program("info", "open.obj").stdout)
        self.put("points.obj", "v 1 2 3\n")
        report = self.info("points.obj")
        self.assertEqual((report["closed"], report["faces"], report["components"]), (False, 0, 0))
        self.assertEqual(self.run_program("info", "points.obj").stdout,
                         "points.obj\npoints      1\nfaces       0\n"
                         "bounds      (1, 2, 3) to (1, 2, 3)\nsize        0 × 0 × 0, diagonal 0\n"
                         "precision   text\n")

    def test_corners_of_an_stl_at_one_place_are_one_point(self):
        points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        facets = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
        lines = ["solid a"]
        for facet in facets:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex %g %g %g" % points[corner] for corner in facet]
            lines += ["endloop", "endfacet"]
        self.put("a.stl", "\n".join([*lines, "endsolid"]) + "\n")
        report = self.info("a.stl")
        self.assertEqual((report["points"], report["components"], report["closed"]), (12, 1, True))
        self.assertEqual((report["distinct_points"], report["points_in_no_face"]), (4, 0))
        self.assertIn("points      12, at 4 places\nfaces       4\n",
                      self.run_program("info", "a.stl").stdout)

    def test_a_bound_model_is_described_as_its_model(self):
        self.put("two.obj", TWO)
        self.run_program("shape", "around", "two.obj", "-o", "rest.vtu")
        self.bind("two.obj", "rest.vtu", out="two.espb")
        expected = self.info("two.obj")
        expected["model"] = "two.espb"
        self.assertEqual(self.info("two.espb"), expected)

    def test_a_vtu_is_a_lattice_if_it_has_volumes(self):
        self.run_program("shape", "box", "--max", 1, 2, 4, "-o", "box.vtu")
        report = self.info("box.vtu", "-n", 0)
        self.assertEqual(report["size"], [1, 2, 4])
        self.assertAlmostEqual(report["diagonal"], math.sqrt(21), delta=1e-15)
        self.assertIn("bounds      (0, 0, 0) to (1, 2, 4)\nsize        1 × 2 × 4, diagonal 4.583\n",
                      self.run_program("info", "box.vtu", "-n", 0).stdout)
        report = self.info("box.vtu", "--model")
        self.assertEqual((report["model"], report["points"], report["faces"], report["precision"]),
                         ("box.vtu", 8, 0, "double"))
        self.put("surface.vtu", """<VTKFile type="UnstructuredGrid" version="1.0"
            byte_order="LittleEndian"><UnstructuredGrid><Piece NumberOfPoints="3" NumberOfCells="1">
            <Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
            0 0 0 1 0 0 0 1 0</DataArray></Points><Cells>
            <DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
            <DataArray type="Int64" Name="offsets" format="ascii">3</DataArray>
            <DataArray type="UInt8" Name="types" format="ascii">5</DataArray>
            </Cells></Piece></UnstructuredGrid></VTKFile>""")
        report = self.info("surface.vtu")
        self.assertEqual((report["points"], report["faces"], report["precision"]), (3, 1, "float"))

    def test_options_of_lattices_are_refused_for_models(self):
        self.put("two.obj", TWO)
        self.assertEqual(self.error_of("info", "two.obj", "--smoothness"),
                         "espalier: two.obj: is a model; --smoothness needs a lattice\n")

    def test_shared_models_are_described(self):
        # Points by `grep -c '^v '`, faces by `grep -c '^f '`.
        for name, counts in (("spot.obj", (2930, 5856, 1, True)),
                             ("rocker-arm.obj", (10044, 20088, 1, True)),
                             ("stanford-bunny.obj", (35947, 69451, 1, False))):
            with self.subTest(name):
                if not (MODELS / name).exists():
                    self.skipTest(f"{MODELS / name} is absent")
                report = self.info(MODELS / name)
                self.assertEqual(tuple(report[key] for key in
                                       ("points", "faces", "components", "closed")), counts)


    def test_bounds_far_from_the_origin_are_told_apart(self):
        # A survey in metres: 4 digits would print 5.432e+06 twice.
        self.put("far.obj", "v 432122 5432197 120\nv 432124 5432199.5 122\n")
        self.assertIn("bounds      (432122, 5432197, 120) to (432124, 5432199.5, 122)\n",
                      self.run_program("info", "far.obj").stdout)

    def test_an_unknown_format_lists_all(self):
        self.put("x.unknown", "1 2 3\n")
        error = self.error_of("info", "x.unknown")
        self.assertTrue(error.startswith("espalier: x.unknown: is not of a known format; expected a "
                                         "model: .obj, .ply, .stl, "), error)
        self.assertIn("; or a lattice: .ovm, .vtu or .vtk, or ", error)


class Notes(CliTest):
    """What a reader of models does not understand: each command says it, and --strict refuses it."""

    NOTE = "kept 1 line whose first word no OBJ has ('foo' in line 5)"

    def setUp(self):
        super().setUp()
        self.put("a.obj", "v 0.2 0.2 0.2\nv 0.8 0.2 0.3\nv 0.2 0.8 0.4\nv 0.4 0.4 0.8\nfoo bar\n"
                          "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        self.run_program("shape", "box", "-o", "box.vtu")
        self.put("targets.txt", "0 0.2 0.2 0.25\n")
        self.run_program("bind", "a.obj", "--rest", "box.vtu", "-o", "bound.espb")
        self.put("page.html", '<script type="application/json" id="espalier-files"></script>')

    def test_all_commands_tell_them(self):
        for arguments in (
                ["info", "a.obj"],
                ["info", "bound.espb"],
                ["deform", "a.obj", "--rest", "box.vtu", "--to", "box.vtu", "-o", "out.obj"],
                ["bind", "a.obj", "--rest", "box.vtu", "-o", "out.espb"],
                ["apply", "bound.espb", "--to", "box.vtu", "-o", "out.obj"],
                ["stencils", "box.vtu", "--points", "a.obj", "-o", "out.mtx"],
                ["fit", "a.obj", "--rest", "box.vtu", "--targets", "targets.txt", "-o", "out.vtu"],
                ["page", "a.obj", "--page", "page.html", "-o", "out.html"],
                ["bench", "a.obj", "--rest", "box.vtu", "--seconds", "0.001"],
                ["shape", "around", "a.obj", "-o", "out.vtu"],
                ["shape", "cage", "a.obj", "-o", "out.vtu"]):
            with self.subTest(command=arguments):
                name = next(word for word in arguments if word in ("a.obj", "bound.espb"))
                errors = self.run_program(*arguments, "--quiet").stderr
                self.assertIn(f"espalier: {name}: {self.NOTE}\n", errors)
                self.assertEqual(self.error_of(*arguments, "--strict"),
                                 f"espalier: {name}: is not understood in full: {self.NOTE}\n")

    def test_a_file_without_notes_is_not_refused(self):
        self.put("b.obj", "v 1 2 3\n")
        self.assertEqual(self.run_program("info", "b.obj", "--strict").stderr, "")

    def test_json_has_them(self):
        self.assertEqual(self.info("a.obj")["notes"], [self.NOTE])

    def test_targets_are_wanted_themselves(self):
        self.put("cloud.obj", "v 0.2 0.2 0.2\nv 0.3 0.3 0.3\n")
        self.put("wanted.obj", "v nan 0 0\nv 0.2 0.2 0.2\n")
        result = subprocess.run([program.ESPALIER, "fit", "cloud.obj", "--rest", "box.vtu", "--targets",
                                 "wanted.obj", "-o", "out.vtu"], cwd=self.path, encoding="utf-8",
                                capture_output=True, timeout=120, check=False)
        self.assertEqual((result.returncode, result.stderr.splitlines()), (1, [
            "espalier: wanted.obj: kept 1 point that is not finite and in no face (point 0)",
            "espalier: wanted.obj: point 0 is not finite"]))


class LatticeInfo(CliTest):
    def test_counts_strata_and_types(self):
        self.run_program("shape", "bipyramid", "--sides", 5, "-o", "b.ovm")
        report = self.info("b.ovm", "-n", 2)
        types = [level["cell_types"] for level in report["levels"]]
        # There are two apexes of valence 5 and five vertices of valence 4 around the middle. From
        # level 1 to level 2, the number of cells of type 5 doubles, and so does the number of cells of type 4.
        self.assertEqual(types, [{"4": 5, "5": 2}, {"4": 5, "5": 2},
                                 {"3": 5 * 8 + 2 * 10, "4": 10, "5": 4}])
        self.assertEqual(report["levels"][0]["strata"]["vertices"]["corner"], 7)
        self.assertIn("type-5: 4", self.run_program("info", "b.ovm", "-n", 2).stdout)

    def test_interior_edges_of_two_faces_are_reported(self):
        # A folded wall cuts a box in two. The edge of the fold, from vertex 5 to 12, has only two
        # faces: the two halves of the wall.
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


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
