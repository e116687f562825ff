#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier pose`: the formulas are tested in tests/shapes/pose_test.cpp; here, that the options do
what they say, in their order.

    pose_command_test.py PATH_OF_ESPALIER
"""

import math
import pathlib
import random
import sys
import unittest

import program
from program import CliTest

# Models that are not part of the repository: tried where they are there.
MODELS = sorted(pathlib.Path(__file__).resolve().parents[3].glob("shared/data/models/*.obj"))


def rotated(p, degrees):
    """Returns a point rotated about the z axis."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (c * p[0] - s * p[1], s * p[0] + c * p[1], p[2])


class Pose(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 2, 2, 4, "--min", -1, -1, 0, "--max", 1, 1, 4,
                         "-o", "rest.ovm")
        self.rest = self.read_ovm_positions("rest.ovm")

    def pose(self, *options, lattice="rest.ovm"):
        """Poses a lattice. Returns the positions."""
        self.run_program("pose", lattice, *options, "-o", "pose.ovm")
        return self.read_ovm_positions("pose.ovm")

    def assert_moved(self, options, move):
        """Checks that each vertex p of the pose is at move(*p), up to roundings."""
        expected = [move(*p) for p in self.rest]
        for point, wanted in zip(self.pose(*options), expected):
            for a, b in zip(point, wanted):
                self.assertAlmostEqual(a, b, delta=1e-14)

    def test_operations(self):
        self.assert_moved(["--move", 1, -2, 0.5], lambda x, y, z: (x + 1, y - 2, z + 0.5))
        self.assert_moved(["--move=1,-2,0.5"], lambda x, y, z: (x + 1, y - 2, z + 0.5))
        self.assert_moved(["--rotate", "z", 30], lambda *p: rotated(p, 30))
        self.assert_moved(["--rotate", "-z", 30], lambda *p: rotated(p, -30))
        self.assert_moved(["--scale", 2], lambda x, y, z: (2 * x, 2 * y, 2 * z - 2))
        self.assert_moved(["--scale", 2, 1, 0.5], lambda x, y, z: (2 * x, y, 0.5 * z + 1))
        self.assert_moved(["--twist", "z", 90], lambda *p: rotated(p, 90 * p[2] / 4))
        self.assert_moved(["--taper", "z", 0.5],
                          lambda x, y, z: ((1 - z / 8) * x, (1 - z / 8) * y, z))
        radius = 4 / math.radians(60)

        def bent(x, y, z):
            angle = math.radians(60) * z / 4
            return radius - (radius - x) * math.cos(angle), y, (radius - x) * math.sin(angle)
        self.assert_moved(["--bend", "z", 60], bent)
        self.assert_moved(["--toward", "+x", "--bend", "z", 60], bent)
        self.assert_moved(["--toward", "-x", "--bend", "z", -60], bent)

    def test_operations_run_in_their_order(self):
        # The first rotation is about the middle of the lattice, which has moved to (1, 0). The
        # second one is about the origin.
        def move(*p):
            x, y, z = rotated(p, 90)
            return rotated((x + 2, y, z), 90)
        self.assert_moved(["--move", 1, 0, 0, "--rotate", "z", 90, "--move", 1, 0, 0,
                           "--center", 0, 0, 0, "--rotate", "z", 90], move)

    def test_center_and_range(self):
        self.assert_moved(["--center", 1, 1, 0, "--rotate", "z", 180],
                          lambda x, y, z: (2 - x, 2 - y, z))
        self.assert_moved(["--range", 1, 3, "--twist", "z", 90],
                          lambda *p: rotated(p, 90 * min(max((p[2] - 1) / 2, 0), 1)))

    def test_selections(self):
        top = {i for i, p in enumerate(self.rest) if p[2] == 4}
        numbers = sorted(top)
        for select in [["end", "+z"], ["box", -1, -1, 3.5, 1, 1, 4], ["ball", 0, 0, 5, 1.8],
                       ["box", "-1,-1,3.5,1,1,4"],
                       ["half-space", 0, 0, 3.5, 0, 0, 1], ["vertices", *numbers],
                       ["vertices", ",".join(map(str, numbers))]]:
            moved = self.pose("--select", *select, "--move", 0, 0, 1)
            with self.subTest(select):
                for i, (before, after) in enumerate(zip(self.rest, moved)):
                    self.assertEqual(after, (*before[:2], before[2] + (i in top)))
        # A later selection replaces the one before, of the positions in the file.
        moved = self.pose("--select", "end", "+z", "--move", 0, 0, -10, "--select", "end", "-z",
                          "--move", 0, 0, -1, "--select-all", "--move", 1, 0, 0)
        for (x, y, z), after in zip(self.rest, moved):
            self.assertEqual(after, (x + 1, y, z - 10 if z == 4 else z - 1 if z == 0 else z))

    def test_falloff(self):
        moved = self.pose("--select", "box", -1, -1, 4, 1, 1, 4, "--falloff", "linear", 4,
                          "--move", 1, 0, 0)
        for (x, y, z), after in zip(self.rest, moved):
            self.assertAlmostEqual(after[0], x + z / 4, delta=1e-15)
        # The falloff ends with its selection.
        moved = self.pose("--select", "end", "+z", "--falloff", "smooth", 4, "--move", 0, 0, 0,
                          "--select", "end", "+z", "--move", 1, 0, 0)
        self.assertEqual(sum(a != b for a, b in zip(moved, self.rest)), 9)

    def test_the_values_of_an_attribute_are_weights(self):
        self.put("marked.vtk", "\n".join([
            "# vtk DataFile Version 2.0", "", "ASCII", "DATASET UNSTRUCTURED_GRID",
            "POINTS 8 double", *["%d %d %d" % (i & 1, i >> 1 & 1, i >> 2) for i in range(8)],
            "CELLS 1 9", "8 0 1 3 2 4 5 7 6", "CELL_TYPES 1", "12", "POINT_DATA 8",
            "SCALARS part double 1", "LOOKUP_TABLE default", "0 0 0 0 1 1 0.5 0.5",
            "SCALARS large double 1", "LOOKUP_TABLE default", "0 0 0 0 1 1 2 2"]) + "\n")
        moved = self.pose("--select", "attribute", "part", "--move", 0, 0, 1, lattice="marked.vtk")
        self.assertEqual([p[2] for p in moved], [0, 0, 0, 0, 2, 2, 1.5, 1.5])
        for name, message in [("large", "attribute large is 2 at vertex 6; expected 0 to 1"),
                              ("other", "the lattice has no attribute other with one value for each "
                                        "vertex; its attributes: part, large")]:
            self.assertIn(message, self.error_of("pose", "marked.vtk", "--select", "attribute",
                                                 name, "--move", 0, 0, 1, "-o", "x.ovm", code=2))

    def test_it_prints_how_many_moved(self):
        out = self.run_program("pose", "rest.ovm", "--select", "end", "+z", "--move", 1, 0, 0, "-o",
                               "pose.vtu").stdout
        self.assertEqual(out, "pose.vtu: 9 of 45 vertices moved\n")
        # No operation: the pose is the lattice.
        self.assertEqual(self.pose(), self.rest)

    def test_options_that_change_no_operation_are_refused(self):
        late = ": no operation after it uses it; put it before "
        turns = "--rotate, --scale, --twist, --bend or --taper"
        bends = "--twist, --bend or --taper"
        any_operation = "the operation that it is for"
        move, bend, top = ["--move", 1, 0, 0], ["--bend", "x", 90], ["--select", "end", "+z"]
        for options, message in [
                ([*bend, "--toward", "+z"], "--toward: has no effect" + late + "--bend"),
                ([*bend, "--range", 0, 1], "--range: has no effect" + late + bends),
                ([*bend, "--center", 0, 0, 0], "--center: has no effect" + late + turns),
                ([*bend, *top], "--select: has no effect" + late + any_operation),
                ([*top, *bend, "--falloff", "smooth", 1], "--falloff: has no effect" + late + any_operation),
                ([*top, *bend, "--select-all"], "--select-all: has no effect" + late + any_operation),
                # An operation that does not use it.
                (["--toward", "+z", *move], "--toward: has no effect" + late + "--bend"),
                (["--center", 0, 0, 0, *move], "--center: has no effect" + late + turns),
                (["--range", 0, 1, "--rotate", "x", 9], "--range: has no effect" + late + bends),
                # Replaced before an operation.
                (["--center", 0, 0, 0, "--center", 1, 0, 0, *bend],
                 "--center: has no effect: the --center after it replaces it; put it before " + turns),
                (["--toward", "+z", *top, *bend],
                 "--toward: has no effect: the --select after it replaces it; put it before --bend"),
                ([*top, "--select-all", *bend], "--select: has no effect: the --select-all after it "
                                                "replaces it; put it before " + any_operation)]:
            self.assertEqual(self.error_of("pose", "rest.ovm", *options, "-o", "x.ovm", code=2),
                             f"espalier: {message}\n")
        # Nothing is read, and nothing written.
        self.assertIn("--toward", self.error_of("pose", "none.ovm", *bend, "--toward", "y", "-o", "x.ovm", code=2))
        self.assertFalse((self.path / "x.ovm").exists())
        # An option lasts until it is replaced.
        self.pose("--center", 0, 0, 0, *move, "--rotate", "z", 90, "--twist", "z", 9, *top, *move)

    def test_wrong_options_name_themselves(self):
        for options, message in [
                (["--twist", "w", 90], "--twist: expected an axis x, y or z, or with a sign (+x, -z), "
                                       "got w\n"),
                (["--twist", "z", "much"], "--twist: expected AXIS DEGREES, with spaces or commas "
                                           "between, got much"),
                (["--twist", "z"], "--twist: expected AXIS DEGREES"),
                (["--falloff", "linear", "far"], "--falloff: expected linear|smooth RADIUS, with "
                                                 "spaces or commas between, got far"),
                (["--move", 1, "two", 3], "--move: expected the numbers X Y Z, with spaces or commas "
                                          "between, got two"),
                (["--move", 1, 2], "--move: expected the numbers X Y Z"),
                (["--scale", 1, 2], "--scale: expected one factor or three, got two"),
                (["--taper", "z", -1], "espalier: --taper: factor: expected 0 or more, got -1"),
                (["--range", 1, 0, "--twist", "z", 9],
                 "espalier: --twist: range[1]: expected a number above range[0] (1), got 0"),
                (["--select", "corner"], "--select: corner: expected box X0 Y0 Z0 X1 Y1 Z1; ball"),
                (["--select", "box", 1, 2, 3], "--select: box 1 2 3: expected box X0 Y0 Z0"),
                (["--select", "vertices", 45],
                 "--select: vertices 45: expected numbers of vertices, 0 to 44"),
                (["--select", "vertices", 1.5],
                 "--select: vertices 1.5: expected numbers of vertices, 0 to 44"),
                (["--select", "ball", 0, 0, 0, -1],
                 "espalier: --select: radius: expected a finite number of 0 or more, got -1\n"),
                (["--select", "ball", 9, 9, 9, 1],
                 "--select: ball 9 9 9 1: expected at least one vertex there; the lattice has none"),
                (["--falloff", "linear", 1], "give --select before --falloff"),
                (["--select", "end", "+z", "--falloff", "steep", 1],
                 "--falloff: expected linear or smooth, got steep"),
                (["--select", "end", "+z", "--falloff", "linear", 0],
                 "--falloff: expected a radius above 0, got 0\n"),
                (["--bend", "z", 30, "--toward", "z", "--bend", "z", 30],
                 "espalier: --bend: toward: expected a vector that is not parallel to the axis, got (0, 0, 1)\n")]:
            with self.subTest(options):
                self.assertIn(message, self.error_of("pose", "rest.ovm", *options, "--move", 0, 0, 0,
                                                     "-o", "x.ovm", code=2))
                self.assertFalse((self.path / "x.ovm").exists())


class OfAModel(CliTest):
    """The three commands: a lattice around a model, a pose of it, the deformed model."""

    def three_commands(self, model, *operations):
        self.run_program("shape", "around", model, "-o", "rest.vtu")
        self.run_program("pose", "rest.vtu", *operations, "-o", "posed.vtu")
        out = self.deform(model, "rest.vtu", "posed.vtu", out="twisted.obj").stdout
        self.assertRegex(out, r"points +(\d+) inside the lattice, 0 outside, 0 could not be placed")
        return self.read_points(model), self.read_points("twisted.obj")

    def write_spiral(self):
        """Writes a model of 300 points."""
        generator = random.Random(1)
        self.write_model([tuple(generator.uniform(-1, 1) for _ in range(3)) for _ in range(300)])

    def test_affine_poses_move_the_model_affinely(self):
        self.write_spiral()
        for operations, move in [
                (["--move", 1, 2, 3], lambda x, y, z: (x + 1, y + 2, z + 3)),
                (["--center", 0, 0, 0, "--rotate", "z", 50], lambda *p: rotated(p, 50)),
                (["--center", 0, 0, 0, "--scale", 2, 3, 0.5],
                 lambda x, y, z: (2 * x, 3 * y, 0.5 * z))]:
            before, after = self.three_commands("model.obj", *operations)
            self.assert_close(after, [move(*p) for p in before], 1e-12)

    def test_models_of_others(self):
        if not MODELS:
            self.skipTest("there are no models beside the repository")
        for model in MODELS:
            with self.subTest(model.name):
                before, after = self.three_commands(model, "--twist", "z", 90)
                self.assertEqual(len(before), len(after))
                self.assertNotEqual(before, after)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
