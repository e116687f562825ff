#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the options that let a part of a model follow the lattice: --weights, --only and --falloff."""

import math
import sys
import unittest

import program
from program import CliTest

GRID = 21


def smooth(x):
    x = min(max(x, 0), 1)
    return x * x * (3 - 2 * x)


class Part(CliTest):
    """A square with a painted weight in a box, which is lifted by 1 at its upper end or twisted."""

    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 4, 4, 4, "-o", "box.ovm")
        self.run_program("pose", "box.ovm", "--move", 0, 0, 1, "-o", "up.ovm")
        self.run_program("pose", "box.ovm", "--twist", "x", 60, "-o", "twisted.ovm")
        self.points = [(i / (GRID - 1), j / (GRID - 1), 0.5) for i in range(GRID) for j in range(GRID)]
        rows = ["%.17g %.17g %.17g 0 0 1 %.17g %d" % (*p, smooth(2 * p[0] - 0.5), 255 * (p[1] > 0.5))
                for p in self.points]
        faces = ["4 %d %d %d %d" % (i * GRID + j, (i + 1) * GRID + j, (i + 1) * GRID + j + 1, i * GRID + j + 1)
                 for i in range(GRID - 1) for j in range(GRID - 1)]
        self.put("square.ply", "\n".join([
            "ply", "format ascii 1.0", f"element vertex {len(rows)}",
            *(f"property double {name}" for name in ("x", "y", "z", "nx", "ny", "nz", "bend")), "property uchar red",
            f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", *rows, *faces, ""]))

    def deform(self, *options, model="square.ply", to="up.ovm", out="out.ply"):
        return self.run_program("deform", model, "--rest", "box.ovm", "--to", to, "-o", out, *options)

    def rows_of(self, name="out.ply"):
        lines = self.text(name).split("end_header\n")[1].splitlines()[:len(self.points)]
        return [[float(word) for word in line.split()] for line in lines]

    def test_weights_multiply_the_displacement(self):
        report = self.deform("--weights", "bend").stdout
        self.assertIn("126 with the weight 0 or beyond the falloff\n", report)
        for before, after in zip(self.points, self.rows_of()):
            self.assertAlmostEqual(after[2] - 0.5, smooth(2 * before[0] - 0.5), delta=1e-12)
        self.deform("--weights", "red", "--quiet")
        for before, after in zip(self.points, self.rows_of()):
            self.assertAlmostEqual(after[2] - 0.5, before[1] > 0.5, delta=1e-12)

    def test_normals_stand_on_the_surface_that_the_weights_make(self):
        self.deform("--weights", "bend")
        for before, after in zip(self.points, self.rows_of()):
            x = 2 * before[0] - 0.5
            slope = 12 * x * (1 - x) if 0 < x < 1 else 0
            # The slope of the weight is taken from the ends of the edges, whose length is 1/20. Its third derivative is
            # 96, so that it is off by 96 / 20^2 / 6; at the ends, where the second derivative jumps by 24, by
            # 24 / 20 / 4.
            normal = [-slope / math.hypot(slope, 1), 0, 1 / math.hypot(slope, 1)]
            for c in range(3):
                self.assertAlmostEqual(after[3 + c], normal[c], delta=0.31 if x in (0, 1) else 0.05)
            if smooth(x) == 0:
                self.assertEqual(after[3:6], [0, 0, 1])

    def test_bind_apply_and_stencils_have_the_same_weights(self):
        options = ("--weights", "bend", "--falloff", 0.25)
        self.deform(*options, to="twisted.ovm")
        self.run_program("bind", "square.ply", "--rest", "box.ovm", *options, "-o", "a.espb")
        self.run_program("apply", "a.espb", "--to", "twisted.ovm", "-o", "applied.ply")
        self.assertEqual(self.text("applied.ply"), self.text("out.ply"))
        self.run_program("stencils", "box.ovm", "--points", "square.ply", *options, "-n", 3, "-o", "d.mtx")
        sums = [0.0] * len(self.points)
        entries = [line.split() for line in self.text("d.mtx").splitlines() if not line.startswith("%")]
        for row, _, weight in entries[1:]:
            sums[int(row) - 1] += float(weight)
        for i, point in enumerate(self.points):
            self.assertAlmostEqual(sums[i], smooth(2 * point[0] - 0.5), delta=1e-12)

    def test_a_part_without_points_is_the_model_at_rest(self):
        self.put("none.obj", "v .1 .1 .5 0 0 0\nv .9 .1 .5 0 0 0\nv .9 .9 .5 0 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n")
        for options in ((), ("--limit",), ("--basis", "bezier"), ("--falloff", 1), ("-n", 1)):
            result = self.deform("--weights", "red", *options, model="none.obj", to="twisted.ovm", out="out.obj")
            self.assertIn("3 with the weight 0", result.stdout)
            self.assertEqual(self.text("out.obj"), self.text("none.obj"))
        self.run_program("stencils", "box.ovm", "--points", "none.obj", "--weights", "red", "--gradients", "-o", "d.npz")

    def test_stencils_warn_of_points_beyond_the_nearest_cell(self):
        self.put("line.obj", "".join(f"v 0.5 0.5 {z}\n" for z in (0.5, 99)))
        result = self.run_program("stencils", "box.ovm", "--points", "line.obj", "--falloff", 1000, "-o", "d.npz")
        self.assertIn("too far away", result.stderr)

    def test_only_some_groups_move(self):
        self.put("two.obj", "v .1 .1 .5\nv .9 .1 .5\nv .9 .9 .5\nv .1 .9 7\no left arm\ng a\nusemtl red\nf 1 2 3\n"
                            "g b c\nusemtl blue\nf 1 3 4\n")
        for options, moved in ((("--only", "a"), "011"), (("--only", "blue", "--outside", "error"), None),
                               (("--only", "a", "--outside", "error"), "111"), (("--only", "left arm"), "111"),
                               (("--only", "a", "--only", "c"), "111")):
            if moved is None:
                error = self.error_of("deform", "two.obj", "--rest", "box.ovm", "--to", "up.ovm", "-o", "out.obj",
                                      *options)
                self.assertIn("point 3 at (0.1, 0.9, 7) is outside the lattice", error)
                continue
            result = self.deform(*options, model="two.obj", out="out.obj")
            z = [float(line.split()[3]) for line in self.text("out.obj").splitlines()[:4]]
            for got, expected in zip(z, (1.5, 1.5, 1.5, 7)):
                self.assertAlmostEqual(got, expected, delta=1e-12)
            outside = "--outside" not in options and options != ("--only", "a")
            self.assertEqual("1 of 4 points is outside" in result.stderr, outside)

    def test_a_falloff_leaves_no_edge(self):
        heights = [i / 100 for i in range(100, 200)]
        self.put("line.obj", "".join(f"v 0.5 0.5 {z}\n" for z in heights))
        result = self.deform("--falloff", 0.5, model="line.obj", out="out.obj")
        self.assertIn("50 with the weight 0 or beyond", result.stdout)
        self.assertEqual(result.stderr, "")
        for z, line in zip(heights, self.text("out.obj").splitlines()):
            self.assertAlmostEqual(float(line.split()[3]) - z, 1 - smooth((z - 1) / 0.5), delta=1e-12)

    def test_points_too_far_away_for_their_cell_are_warned_of(self):
        # Weights sum to more than 8 beyond 3.5 cells of 0.25.
        self.put("line.obj", "".join(f"v 0.5 0.5 {z}\n" for z in (0.5, 1.5, 2.5, 3.5, 99)))
        result = self.deform("--falloff", 3, model="line.obj", out="out.obj")
        self.assertIn("warning: 2 of 3 points outside the lattice are too far away", result.stderr)
        self.assertIn("1 with the weight 0", result.stdout)

    def test_splats_have_no_slope_of_the_weight(self):
        names = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "bend"]
        self.put("splats.ply", "\n".join(["ply", "format ascii 1.0", "element vertex 2",
                                          *(f"property float {name}" for name in names), "end_header",
                                          ".5 .5 .5 -1 -2 -3 1 0 0 0 .5", ".5 .5 .75 -1 -2 -3 1 0 0 0 1", ""]))
        result = self.deform("--weights", "bend", model="splats.ply")
        self.assertIn("note: splats.ply has no faces, so the normals, tangents and splats of its 2 points turn as if",
                      result.stderr)
        self.assertEqual(self.deform("--weights", "bend", "--quiet", model="splats.ply").stderr, "")

    def test_mistakes_name_the_way_out(self):
        for options, message in (
                (("--weights", "bond"), "square.ply: has no attribute 'bond' of points; it has 'nx', 'ny', 'nz', "
                                        "'bend', 'red'"),
                (("--weights", "nz", "--only", "a"), "square.ply: has no group 'a' of points; there are none")):
            error = self.error_of("deform", "square.ply", "--rest", "box.ovm", "--to", "up.ovm", "-o", "out.ply",
                                  *options)
            self.assertIn(message, error)
        self.assertIn("--outside excludes --falloff",
                      self.error_of("deform", "square.ply", "--rest", "box.ovm", "--to", "up.ovm", "-o", "out.ply",
                                    "--outside", "keep", "--falloff", 1, code=2))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
