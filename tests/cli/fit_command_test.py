#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier fit`: the pose of a lattice from targets of points of a model.

    fit_command_test.py PATH_OF_ESPALIER
"""

import json
import math
import sys
import unittest

import program
from program import CliTest, icosphere_points


class Fit(CliTest):
    def setUp(self):
        super().setUp()
        self.points = icosphere_points(400)
        self.write_model(self.points)
        self.run_program("shape", "cylinder", "--sectors", 5, "--from", 0.5, 0.5, -0.2,
                         "--to", 0.5, 0.5, 1.2, "--radius", 0.8, "-o", "rest.ovm")

    def fit(self, targets, *options, out="pose.ovm"):
        """Returns the report of a fit to targets, or by pulls if there are none."""
        some = [] if targets is None else ["--targets", targets]
        return json.loads(self.run_program("fit", "model.obj", "--rest", "rest.ovm", *some, *options, "-n", 2,
                                           "--report", "json", "-o", out).stdout)

    def error_of_fit(self, targets, *options, code=1):
        text = self.error_of("fit", "model.obj", "--rest", "rest.ovm", "--targets", targets,
                             *options, "-n", 2, "-o", "pose.ovm", code=code)
        self.assertFalse((self.path / "pose.ovm").exists())
        return text

    def make_tall_lattice(self):
        """Makes a lattice with layers that are far enough from the held part to move."""
        self.run_program("shape", "cylinder", "--sectors", 5, "--layers", 6, "--from", 0.5, 0.5, -0.2,
                         "--to", 0.5, 0.5, 1.2, "--radius", 0.8, "-o", "rest.ovm")

    def test_a_whole_model_gives_the_lattice_that_deformed_it(self):
        known = self.write_pose("known.ovm", "rest.ovm", lambda p: (
            p[0] + 0.2 * math.sin(3 * p[2]), p[1] + 0.1 * p[0] * p[2], 1.2 * p[2]))
        self.deform("model.obj", "rest.ovm", "known.ovm", "-n", 2, out="moved.obj")
        report = self.fit("moved.obj", "--undetermined", "refuse")
        self.assertEqual(report["targets"], 400)
        self.assertLess(report["largest_miss"], 1e-12)
        self.assert_close(self.read_ovm_positions("pose.ovm"), known, 1e-10)

    def test_a_pull_moves_the_nearest_point(self):
        nearest = min(range(400), key=lambda i: math.dist(self.points[i], (0.9, 0.5, 0.5)))
        out = self.run_program("fit", "model.obj", "--rest", "rest.ovm", "--pull", 0.9, 0.5, 0.5,
                               0.1, -0.2, 0, "-n", 2, "-o", "pose.ovm").stdout
        self.assertRegex(out, rf"^pulled +point {nearest} at ")
        self.assertRegex(out, r"rigid cells +\d+ iterations; \d+ of \d+ vertices stay")
        self.deform("model.obj", "rest.ovm", "pose.ovm", "-n", 2, out="moved.obj")
        moved = self.read_points("moved.obj")
        x, y, z = self.points[nearest]
        self.assert_close([moved[nearest]], [(x + 0.1, y - 0.2, z)], 1e-6)
        # The least movement of vertices, as the fit of targets with tikhonov.
        out = self.run_program("fit", "model.obj", "--rest", "rest.ovm", "--pull", 0.9, 0.5, 0.5,
                               0.1, -0.2, 0, "--stiff", "-n", 2, "-o", "pose.ovm").stdout
        # The smoothing determines all vertices.
        self.assertRegex(out, r"condition number +[0-9.]+(e\+\d+)?\n")
        self.deform("model.obj", "rest.ovm", "pose.ovm", "-n", 2, out="moved.obj")
        moved = self.read_points("moved.obj")
        stiff = (self.path / "pose.ovm").read_bytes()
        self.run_program("fit", "model.obj", "--rest", "rest.ovm", "--pull", 0.9, 0.5, 0.5, 0.1, -0.2, 0,
                         "--smoothing", "tikhonov", "-n", 2, "-o", "pose.ovm")
        self.assertEqual((self.path / "pose.ovm").read_bytes(), stiff)
        # The weight of the smoothing is 1e-6 of the targets' and more where a row is small.
        self.assert_close([moved[nearest]], [(x + 0.1, y - 0.2, z)], 1e-4)
        # With commas, and with targets for other points.
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        report = self.fit("t.txt", "--pull=0.9,0.5,0.5,0.1,-0.2,0")
        self.assertEqual(report["targets"], 2)
        self.assertIsNotNone(report["condition"])

    def test_pulls_and_pins_keep_cells_rigid(self):
        # One point carries the lattice along if all vertices may move.
        report = self.fit(None, "--pull", 0.9, 0.5, 0.5, 0.1, -0.2, 0.3, "--reach", 1)
        self.assertEqual(report["fixed_vertices"], 0)
        self.assertNotIn("condition", report)
        self.assert_close(self.read_ovm_positions("pose.ovm"),
                          [(x + 0.1, y - 0.2, z + 0.3) for x, y, z in self.read_ovm_positions("rest.ovm")], 1e-9)
        # Pinned points stay, and frozen vertices do.
        near = min(range(400), key=lambda i: math.dist(self.points[i], (0.1, 0.5, 0.5)))
        report = self.fit(None, "--pull", 0.9, 0.5, 0.5, 0.1, -0.2, 0, "--pin", 0.1, 0.5, 0.5, "--reach", 1,
                          "--freeze", 0)
        self.assertEqual((report["targets"], report["fixed_vertices"]), (2, 1))
        self.deform("model.obj", "rest.ovm", "pose.ovm", "-n", 2, out="moved.obj")
        self.assert_close([self.read_points("moved.obj")[near]], [self.points[near]], 1e-6)
        self.assertEqual(self.read_ovm_positions("pose.ovm")[0], self.read_ovm_positions("rest.ovm")[0])
        pull = ["--pull", 0.9, 0.5, 0.5, 0.1, 0, 0]
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        for options, message in [
                ([*pull, "--reach", 2], "--reach"), ([*pull, "--reach", 0.5, "--stiff"], "--reach"),
                (["--targets", "t.txt", "--stiff"], "--stiff"), (["--targets", "t.txt", "--reach", 1], "--reach"),
                ([*pull, "--reach", 1, "--smoothing", "laplacian"], "--reach"),
                ([*pull, "--pin", 1, 2], "--pin: expected the numbers X Y Z")]:
            with self.subTest(options):
                self.assertIn(message, self.error_of("fit", "model.obj", "--rest", "rest.ovm", *options, "-o",
                                                     "p.ovm", code=2))
        self.assertRegex(self.error_of("fit", "model.obj", "--rest", "rest.ovm", *pull, "--pin", 0.9, 0.5, 0.5, "-o",
                                       "p.ovm"), r"--pin 0.9 0.5 0.5: the nearest point is \d+, which has a target")

    def test_folds_are_counted(self):
        # The end of a bar is pushed through its middle; without rigid cells they fold.
        self.run_program("shape", "box", "--cells", 1, 1, 6, "--min", 0, 0, 0, "--max", 1, 1, 6, "-o", "bar.ovm")
        self.put("bar.obj", "v 0.5 0.5 5.8\nv 0.5 0.5 0.2\n")
        fit = ["fit", "bar.obj", "--rest", "bar.ovm", "-n", 2, "--pull", 0.5, 0.5, 6, 0, 0]
        out = self.run_program(*fit, -2.4, "-o", "pose.ovm").stdout
        self.assertRegex(out, r"held back +cells would fold: they stay open, [-0-9.e]+ of the way from a target; pull less")
        self.assertRegex(out, r"folded cells +0 of 384 of level 2\n")
        self.run_program("check", "pose.ovm", "--rest", "bar.ovm", "-n", 2)
        self.assertNotIn("held back", self.run_program(*fit, 0.5, "-o", "pose.ovm").stdout)
        report = json.loads(self.run_program(*fit, -2.4, "--report", "json", "-o", "pose.ovm").stdout)
        self.assertEqual((report["held_back"], report["folded_cells"]), (True, 0))
        stiff = [*fit, -5, "--stiff"]
        self.assertRegex(self.run_program(*stiff, "-o", "stiff.ovm").stdout,
                         r"folded cells +[1-9]\d* of 384 of level 2; pull less far")
        self.assertIn("--no-inverted: the pose turns",
                      self.error_of(*stiff, "--no-inverted", "-o", "refused.ovm", code=3))
        self.assertFalse((self.path / "refused.ovm").exists())

    def test_a_pull_from_far_away_is_refused(self):
        # From 1e16 sizes away, the distances of all points are equal: the difference is rounded away.
        for place in (1e16, 1e308):
            self.assertIn("--pull", self.error_of("fit", "model.obj", "--rest", "rest.ovm", "--pull", place,
                                                  0, 0, 0.1, 0, 0, "-o", "p.ovm"))
        # The points of this model are equally near from everywhere, so there is nothing to choose.
        self.put("one.obj", "v 0.5 0.5 0.5\n")
        self.assertIn("point 0 at 0.5 0.5 0.5", self.run_program(
            "fit", "one.obj", "--rest", "rest.ovm", "--pull", 0.9, 0, 0, 0.1, 0, 0, "-o", "p.ovm").stdout)

    def test_two_pulls_of_one_point_are_refused(self):
        pull = ["--pull", 0.9, 0.5, 0.5, 0.1, 0, 0]
        self.assertRegex(
            self.error_of("fit", "model.obj", "--rest", "rest.ovm", *pull, *pull, "-o", "p.ovm"),
            r"--pull 0.9 0.5 0.5: the nearest point is \d+, which has a target already")
        self.assertIn("--targets or --pull is required",
                      self.error_of("fit", "model.obj", "--rest", "rest.ovm", "-o", "p.ovm", code=2))

    def test_a_few_targets_are_reached(self):
        self.put("t.txt", "# where two points go\n7 0.5 0.5 1.1  # up\n\n30 0.2 0.2 0.2\n")
        report = self.fit("t.txt")
        self.assertEqual(report["targets"], 2)
        self.assertIsNone(report["condition"])
        self.deform("model.obj", "rest.ovm", "pose.ovm", "-n", 2, out="moved.obj")
        moved = self.read_points("moved.obj")
        self.assert_close([moved[7], moved[30]], [(0.5, 0.5, 1.1), (0.2, 0.2, 0.2)], 1e-12)
        # The whole lattice moves along, so the rest of the model moves more.
        smooth = self.fit("t.txt", "--smoothing", "laplacian", "--strength", 0.01, out="s.ovm")
        self.assertGreater(smooth["condition"], 1)
        self.assertGreater(smooth["largest_miss"], 1e-12)

    def test_frozen_vertices_stay(self):
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        self.fit("t.txt", "--freeze", "0,3,4")
        rest, pose = (self.read_ovm_positions(name) for name in ["rest.ovm", "pose.ovm"])
        for vertex in [0, 3, 4]:
            self.assertEqual(pose[vertex], rest[vertex])
        self.assertNotEqual(pose, rest)

    def test_what_is_held_stays(self):
        self.make_tall_lattice()
        rest = self.read_ovm_positions("rest.ovm")
        layer = [sum(p[2] < -0.2 + k * 1.4 / 6 + 1e-9 for p in rest) for k in range(3)]
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        # The box has no height and contains a cap of the cylinder.
        for continuity, count in [("c0", layer[0]), ("c1", layer[1]), ("c2", layer[1])]:
            report = self.fit("t.txt", "--hold", -9, -9, -0.2, 9, 9, -0.2, "--continuity", continuity)
            self.assertEqual(report["held_vertices"], count)
            pose = self.read_ovm_positions("pose.ovm")
            self.assertEqual([p for p, q in zip(pose, rest) if q[2] < -0.2 + 1e-9],
                             [q for q in rest if q[2] < -0.2 + 1e-9])
        # The box contains a part of the model.
        self.assertGreater(self.fit("t.txt", "--hold", 0, 0, 0, 1, 1, 0.3)["held_vertices"], layer[0])
        self.deform("model.obj", "rest.ovm", "pose.ovm", "-n", 2, out="moved.obj")
        moved = self.read_points("moved.obj")
        held = [i for i, p in enumerate(self.points) if p[2] <= 0.3]
        self.assert_close([moved[i] for i in held], [self.points[i] for i in held], 1e-14)
        self.assert_close([moved[7]], [(0.5, 0.5, 1.1)], 1e-12)

    def test_held_points_outside_that_are_carried_stay(self):
        self.make_tall_lattice()
        self.points[399] = (0.5, 0.6, -0.5)
        self.write_model(self.points)
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        box = ["--hold", 0, 0, -1, 1, 1, -0.3]
        counts = []
        for continuity in ["c0", "c1", "c2"]:
            counts.append(self.fit("t.txt", *box, "--continuity", continuity, "--outside",
                                   "nearest", "--smoothing", "laplacian")["held_vertices"])
            self.deform("model.obj", "rest.ovm", "pose.ovm", "-n", 2,
                             "--outside", "nearest", out="moved.obj")
            # The results are sums of some hundred products of numbers about 1.
            self.assert_close([self.read_points("moved.obj")[399]], [self.points[399]], 1e-14)
        self.assertGreater(counts[0], 0)
        self.assertGreater(counts[1], counts[0])
        self.assertEqual(counts[1], counts[2])
        # If one point of the box is inside the lattice, vertices are held. Points outside stay anyway.
        self.assertGreater(self.fit("t.txt", "--hold", 0, 0, -1, 1, 1, 0.2)["held_vertices"], 0)
        (self.path / "pose.ovm").unlink()
        self.assertIn("--hold: all points in the box, such as point 399 of model.obj, are outside the "
                      "lattice rest.ovm and stay without --hold", self.error_of_fit("t.txt", *box))
        for continuity in ["c0", "c2"]:
            self.assertIn("model.obj: point 399, in the box of --hold, lies outside the lattice rest.ovm",
                          self.error_of_fit("t.txt", "--hold", 0, 0, -1, 1, 1, 0.2, "--outside",
                                            "error", "--continuity", continuity))

    def test_what_is_held_does_not_depend_on_the_targets(self):
        self.make_tall_lattice()
        # None, one or all of the held points have a target.
        few = "7 0.5 0.5 1.1\n"
        self.put("few.txt", few)
        self.put("more.txt", few + "399 0.5 0.5 0.1\n")
        for continuity in ["c0", "c1"]:
            reports = [self.fit(targets, "--hold", 0, 0, 0, 1, 1, 0.11, "--continuity", continuity)
                       for targets in ["few.txt", "more.txt", "model.obj"]]
            self.assertEqual([r["targets"] for r in reports], [1, 2, 400])
            self.assertEqual(len({r["held_vertices"] for r in reports}), 1)
            self.assertGreater(reports[0]["held_vertices"], 0)

    def test_points_outside_that_did_not_move_are_left_out(self):
        known = self.write_pose("known.ovm", "rest.ovm",
                                lambda p: (p[0] + 0.1 * p[2], p[1], 1.2 * p[2]))
        self.points[7] = (9, 9, 9)
        self.points[8] = (9, -9, 9)
        self.write_model(self.points)
        self.deform("model.obj", "rest.ovm", "known.ovm", "-n", 2, out="moved.obj")
        report = self.fit("moved.obj", "--undetermined", "refuse")
        self.assertEqual((report["targets"], report["left_out"]), (398, 2))
        self.assert_close(self.read_ovm_positions("pose.ovm"), known, 1e-10)
        text = self.run_program("fit", "model.obj", "--rest", "rest.ovm", "--targets", "moved.obj",
                                "-o", "pose.ovm").stdout
        self.assertIn("targets left out      2: points outside the lattice that are to stay\n", text)
        (self.path / "pose.ovm").unlink()
        self.assertIn("model.obj: point 7 lies outside the lattice rest.ovm",
                      self.error_of_fit("moved.obj", "--outside", "error"))
        self.put("t.txt", "7 9 9 9\n8 9 -9 9\n")
        self.assertIn("t.txt: no target is left: all 2 points lie outside",
                      self.error_of_fit("t.txt"))
        self.put("t.txt", "7 9 9 9\n8 9 -9 9.5\n3 0.5 0.5 0.5\n")
        self.assertIn("t.txt:2: point 8 lies outside", self.error_of_fit("t.txt"))
        # The held vertices do not depend on the targets.
        self.make_tall_lattice()
        self.put("t.txt", "30 0.5 0.5 1.1\n")
        held = [self.fit(targets, "--hold", 0, 0, 0, 9, 9, 0.3) for targets in ["t.txt", "model.obj"]]
        self.assertEqual([report["left_out"] for report in held], [0, 2])
        self.assertEqual(held[0]["held_vertices"], held[1]["held_vertices"])

    def test_points_too_far_outside_cannot_be_carried(self):
        self.points[7] = (1e12, 2e12, -1e12)
        self.write_model(self.points)
        self.put("t.txt", "3 0.5 0.5 0.5\n7 0.5 0.5 1.1\n")
        for options in [["--outside", "nearest"], ["--outside", "nearest", "--limit"]]:
            error = self.error_of("fit", "model.obj", "--rest", "rest.ovm", "--targets", "t.txt",
                                  *options, "-o", "pose.ovm")
            self.assertEqual(
                "espalier: t.txt:2: point 7 lies outside the lattice rest.ovm, too far for the nearest "
                "cell to carry it; the lattice cannot carry it to its target\n", error)

    def test_terminal_shows_that_it_holds(self):
        self.make_tall_lattice()
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        shown = self.shown_on_a_terminal("fit", "model.obj", "--rest", "rest.ovm", "--targets",
                                         "t.txt", "--hold", 0, 0, 0, 1, 1, 0.3, "-o", "pose.ovm")
        self.assertIn("holding ...", shown)

    def test_help_says_that_two_of_the_choices_are_one(self):
        words = " ".join(self.run_program("fit", "--help").stdout.split())
        self.assertIn("c1 and c2 hold the same vertices", words)

    def test_a_full_disk(self):
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        self.assert_nothing_is_lost_on_a_full_disk(
            "fit", "model.obj", "--rest", "rest.ovm", "--targets", "t.txt", "-n", 2,
            output="pose.ovm", room=1024)

    def test_text_report(self):
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        out = self.run_program("fit", "model.obj", "--rest", "rest.ovm", "--targets", "t.txt",
                               "-o", "pose.vtu").stdout
        for word in ["targets", "largest distance", "largest displacement",
                     "undetermined          the targets leave vertices free"]:
            self.assertIn(word, out)

    def test_refusals(self):
        for text, why in [("", "t.txt: has no target"), ("7 1 2\n", "t.txt:"),
                          ("7 0 0 0\n400 0 0 0\n", "t.txt:2: there is no point 400"),
                          ("-1 0 0 0\n", "t.txt:1: there is no point -1"),
                          ("7 0 0 0\n7 1 1 1\n", "t.txt:2: point 7 has a target already, on line 1"),
                          ("7 0 nan 0\n", "t.txt:1: the coordinate is not finite"),
                          ("7 0 x 0\n", "t.txt:1:"),
                          ("0 5 5\n0 2 5\n5 0 3\n5 5 0\n", "t.txt:1: expected the number of a"),
                          ("7 0 0 0 8 1 1 1\n", "t.txt:1: expected one target on each line"),
                          ("7 1e308 -1e308 0\n8 1e308 0 0\n",
                           "t.txt:1: the target of point 7 is too far from the point"),
                          ("8 1 0 0\n7 1e308 -1e308 0\n",
                           "t.txt:2: the target of point 7 is too far from the point")]:
            self.put("t.txt", text)
            self.assertIn(why, self.error_of_fit("t.txt"))
        self.put("t.txt", "7 0.5 0.5 1.1\n")
        self.assertIn("undetermined", self.error_of_fit("t.txt", "--undetermined", "refuse"))
        self.assertIn("--freeze[1]: expected a vertex, 0 to 11, got 999",
                      self.error_of_fit("t.txt", "--freeze", "0,999", code=2))
        self.assertIn("--hold: the box contains no point of model.obj and no boundary face of rest.ovm",
                      self.error_of_fit("t.txt", "--hold", 5, 5, 5, 6, 6, 6))
        every = ",".join(str(v) for v in range(len(self.read_ovm_positions("rest.ovm"))))
        everything = ["--hold", -9, -9, -9, 9, 9, 9, "--continuity", "c1"]
        for options, who in [(everything, "--hold keeps"), (["--freeze", every], "--freeze keeps"),
                             (["--hold", -9, -9, -0.2, 9, 9, -0.2, "--freeze", every[every.index(",") + 1:]],
                              "--hold and --freeze keep")]:
            self.assertRegex(self.error_of_fit("t.txt", *options),
                             rf"{who} all \d+ vertices of rest.ovm: no vertex is left to move")
        self.assertIn("--hold: the box runs from 1 down to 0",
                      self.error_of_fit("t.txt", "--hold", 0, 1, 0, 1, 0, 1, code=2))
        self.assertIn("--hold", self.error_of_fit("t.txt", "--continuity", "c1", code=2))
        self.assertIn("--hold", self.error_of_fit("t.txt", "--hold", 0, 1, 0, code=2))
        for strength in (0, 1e-5, 1e308):
            self.assertEqual(self.error_of_fit("t.txt", "--strength", strength, code=2),
                             f"espalier: --strength: expected 0.0001 to 10000, got {strength}\n")
        self.write_model(self.points[:-1], "fewer.obj")
        self.assertIn("fewer.obj: has 399 points, but the model model.obj has 400",
                      self.error_of_fit("fewer.obj"))
        self.write_model(self.points[:7] + [(9, 1e200, 9)] + self.points[8:], "far.obj")
        self.assertIn("far.obj: the target of point 7 is too far from the point",
                      self.error_of_fit("far.obj"))
        self.write_model(self.points[:7] + [(9, 9, 9)] + self.points[8:])
        self.assertIn("t.txt:1: point 7 lies outside the lattice", self.error_of_fit("t.txt"))
        self.assertIn("t.txt:1: point 7 lies outside",
                      self.error_of_fit("t.txt", "--outside", "error"))
        self.error_of_fit("t.txt", "--smoothing", "much", code=2)
        self.assertIn("--basis", self.error_of_fit("t.txt", "--basis", "bezier", code=2))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
