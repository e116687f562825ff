# SPDX-License-Identifier: Apache-2.0
"""Deforms PLY files of Gaussian splats."""

import json
import math
import random
import struct
import sys
import unittest

import program
from program import CliTest

NAMES = ("x y z nx ny nz f_dc_0 f_dc_1 f_dc_2".split() + [f"f_rest_{i}" for i in range(9)] +
         "opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split())
ANGLE = 0.7


def turn(p):
    x, y, z = p
    return (math.cos(ANGLE) * x - math.sin(ANGLE) * y, math.sin(ANGLE) * x + math.cos(ANGLE) * y, z)


def turned(splat):
    """The splat in a scene that turns about z."""
    new = dict(splat)
    new["x"], new["y"], new["z"] = turn([splat[axis] for axis in "xyz"])
    # The product of the quaternion (c, 0, 0, s) and that of the splat.
    c, s = math.cos(ANGLE / 2), math.sin(ANGLE / 2)
    w, x, y, z = (splat[f"rot_{i}"] for i in range(4))
    for i, number in enumerate((c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)):
        new[f"rot_{i}"] = number
    # The harmonics of degree 1 are those of -y, z and -x: a vector (-h2, -h0, h1).
    for colour in range(3):
        h = [splat[f"f_rest_{3 * colour + i}"] for i in range(3)]
        vector = turn((-h[2], -h[0], h[1]))
        for i, number in enumerate((-vector[1], vector[2], -vector[0])):
            new[f"f_rest_{3 * colour + i}"] = number
    return new


class SplatsTest(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 3, 3, 3, "--min", -1, -1, -1,
                         "--max", 1, 1, 1, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", turn)
        generator = random.Random(1)
        self.splats = [{name: 0 if name[0] == "n" else generator.uniform(-0.3, 0.3)
                        for name in NAMES} for _ in range(300)]
        self.write("splats.ply", self.splats)

    def header(self, names):
        return ("ply\nformat binary_little_endian 1.0\nelement vertex 300\n" +
                "".join(f"property float {name}\n" for name in names) + "end_header\n").encode()

    def write(self, file, splats, names=NAMES):
        rows = [struct.pack(f"<{len(names)}f", *(splat[name] for name in names))
                for splat in splats]
        (self.path / file).write_bytes(self.header(names) + b"".join(rows))

    def read(self, file):
        rows = self.bytes(file)[len(self.header(NAMES)):]
        return [dict(zip(NAMES, row)) for row in struct.iter_unpack(f"<{len(NAMES)}f", rows)]

    def said(self, *arguments):
        text = self.run_program(*arguments).stdout
        lines = [line.split(maxsplit=1)[1] for line in text.splitlines()
                 if line.startswith("directions")]
        as_json = json.loads(self.run_program(*arguments, "--report", "json").stdout)
        self.assertEqual([as_json["directions"]], lines)
        return lines[0]

    def deform(self, *options, model="splats.ply", to="pose.ovm", output="out.ply"):
        return self.said("deform", model, "--rest", "rest.ovm", "--to", to, "-o", output, *options)

    def assert_turned(self, file):
        for got, splat in zip(self.read(file), self.splats, strict=True):
            want = turned(splat)
            for name in NAMES:
                self.assertLess(abs(got[name] - want[name]), 1e-6, name)

    def test_a_turn_turns_splats_and_colours(self):
        for options in ([], ["-n", 2], ["--limit"], ["--basis", "bezier"], ["--basis", "bspline"]):
            self.assertEqual(self.deform(*options), "300 splats turn with the model")
            self.assert_turned("out.ply")

    def test_a_binding_turns_them(self):
        self.run_program("bind", "splats.ply", "--rest", "rest.ovm", "-o", "bound.espb")
        said = self.said("apply", "bound.espb", "--to", "pose.ovm", "-o", "out.ply")
        self.assertEqual(said, "300 splats turn with the model")
        self.assert_turned("out.ply")

    def test_at_rest_the_file_stays(self):
        self.deform(to="rest.ovm")
        self.assertEqual(self.bytes("out.ply"), self.bytes("splats.ply"))

    def test_splats_stay_if_asked(self):
        self.assertEqual(self.deform("--keep-normals"), "300 splats stay, as --keep-normals asks")
        for got, splat in zip(self.read("out.ply"), self.read("splats.ply"), strict=True):
            self.assertEqual({name: got[name] for name in NAMES[3:]},
                             {name: splat[name] for name in NAMES[3:]})
        self.assertEqual(self.deform(output="out.mdd"),
                         "300 splats are not in the animation, which holds points only")

    def test_the_report_names_all_that_turns(self):
        names = NAMES + ["tx", "ty", "tz"]
        for splat in self.splats:
            splat.update(nx=1, tx=0, ty=1, tz=0)
        self.write("all.ply", self.splats, names)
        self.assertEqual(self.deform(model="all.ply"),
                         "300 normals, 300 tangents and 300 splats turn with the model")
        # Harmonics of no degree stay.
        names = [name for name in NAMES if name != "f_rest_8"]
        self.write("eight.ply", self.splats, names)
        self.assertEqual(self.deform(model="eight.ply"),
                         "300 normals and 300 splats turn with the model; harmonics f_rest stay, "
                         "because there are 8, not 9, 24 or 45")

    def test_another_format_names_what_it_lacks(self):
        note = self.run_program("deform", "splats.ply", "--rest", "rest.ovm", "--to", "pose.ovm",
                                "-o", "out.obj").stderr
        self.assertIn("the .ply has data that are not written: splats, properties of points "
                      "'f_dc_0', 'f_dc_1', 'f_dc_2', 'opacity'", note)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
