#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier pose`: the formulas are tested in tests/shapes/pose_test.cpp; here, that the options do
what they say, in their order.

    pose_command_test.py PATH_OF_ESPALIER
"""

import math
import pathlib
import random
import struct
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

    def test_displacements(self):
        count = len(self.rest)
        lines = random.Random(1).sample(range(count), 7)
        vectors = {v: (0.25 * i, -0.5, 2.0 ** -i) for i, v in enumerate(lines)}
        self.put("step.csv", "vertex,dx,dy,dz\n" + "".join(f"{v},{x},{y},{z}\n" for v, (x, y, z) in vectors.items()))
        all_vectors = [vectors.get(v, (0, 0, 0)) for v in range(count)]
        expected = [tuple(a + b for a, b in zip(p, d)) for p, d in zip(self.rest, all_vectors)]
        self.assertEqual(self.pose("--displacements", "step.csv"), expected)
        self.put_npy("all.npy", (count, 3), [x for vector in all_vectors for x in vector])
        self.assertEqual(self.pose("--displacements", "all.npy"), expected)
        self.put_npy("some.npy", (len(lines), 4), [x for v in lines for x in (v, *vectors[v])])
        self.assertEqual(self.pose("--displacements", "some.npy"), expected)
        # A step among others, of the selected vertices.
        top = [p[2] == 4 for p in self.rest]
        self.assertEqual(self.pose("--select", "end", "+z", "--displacements", "all.npy", "--select-all", "--move", 1, 0, 0),
                         [(q[0] + 1, *q[1:]) if t else (p[0] + 1, *p[1:]) for p, q, t in zip(self.rest, expected, top)])
        result = self.run_program("pose", "rest.ovm", "--displacements", "step.csv", "-o", "pose.ovm")
        self.assertEqual(result.stdout, "pose.ovm: 7 of 45 vertices moved\n")

    def test_wrong_displacements(self):
        def error(name):
            return self.error_of("pose", "rest.ovm", "--displacements", name, "-o", "x.ovm", code=1)
        self.put("far.csv", "45,0,0,1\n")
        self.assertEqual(error("far.csv"), "espalier: far.csv:1: there is no vertex 45; the lattice has 45 vertices, "
                                           "numbered from 0\n")
        self.put("twice.csv", "3,0,0,1\n4,0,0,1\n3,0,0,1\n")
        self.assertEqual(error("twice.csv"), "espalier: twice.csv:3: vertex 3 has a displacement already, in line 1\n")
        self.put_npy("few.npy", (2, 3), range(6))
        self.assertIn("few.npy: has 2 vectors; expected one for each of the 45 vertices", error("few.npy"))
        self.assertIn("none.csv: cannot open", error("none.csv"))
        self.put("step.txt", "0 0 0 1\n")
        self.assertIn("step.txt: is not a table of displacements; expected .npy or .csv", error("step.txt"))
        self.assertIn("--displacements: expected the name of a file, got nothing", self.error_of(
            "pose", "rest.ovm", "--displacements", "", "-o", "x.ovm", code=2))
        self.put("same.ovm", "")
        self.assertIn("is also an input (--displacements)", self.error_of(
            "pose", "rest.ovm", "--displacements", "same.ovm", "-o", "same.ovm", code=1))

    def put_npy(self, name, shape, numbers):
        head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
        numbers = list(numbers)
        (pathlib.Path(self.path) / name).write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
                                                     + struct.pack(f"<{len(numbers)}d", *numbers))

    def test_limbs(self):
        # The shell of a box with one more row of cubes: a body of 3 x 3 x 3 cubes, and an arm of one
        # cube's width along x.
        self.run_program("shape", "box", "--cells", 3, 3, 3, "--min", 0, 0, 0, "--max", 3, 3, 3, "-o", "body.ovm")
        self.run_program("shape", "box", "--cells", 4, 1, 1, "--min", 3, 1, 1, "--max", 7, 2, 2, "-o", "arm.ovm")
        self.run_program("shape", "merge", "body.ovm", "arm.ovm", "-o", "figure.ovm")
        rest = self.read_ovm_positions("figure.ovm")

        def moved(*options):
            pose = self.pose(*options, lattice="figure.ovm")
            return {rest[i] for i, p in enumerate(pose) if p != rest[i]}

        def beyond(x):
            return {p for p in rest if p[0] >= x and (p[0] > 3 or {p[1], p[2]} <= {1, 2})}
        move = ["--move", 0, 0, 1]
        self.assertEqual(moved("--select", "limb", 7, 1.5, 1.5, *move), beyond(3))
        self.assertEqual(moved("--select", "limb", "7,1.5,1.5", "--select", "shrink", 1, *move), beyond(4))
        self.assertEqual(moved("--select", "end", "+x", "--select", "grow", 2, *move), beyond(5))
        self.assertEqual(moved("--select", "beyond", 5.1, 1.5, 2, *move), beyond(5))
        self.assertEqual(moved("--select", "near", 7.5, 1.5, 1.5, 1.2, *move), beyond(7))
        out = self.run_program("pose", "figure.ovm", "--select", "limb", 7, 1.5, 1.5, *move, "-o", "x.ovm").stdout
        self.assertEqual(out, "limb 7 1.5 1.5: 20 of 80 vertices, beyond a section of area 1 at 3 1.5 1.5\n"
                              "x.ovm: 20 of 80 vertices moved\n")
        # The falloff is measured along the cells: from the section, one edge into the body.
        pose = self.pose("--select", "limb", 7, 1.5, 1.5, "--falloff", "linear", 2, *move, lattice="figure.ovm")
        self.assertEqual({after[2] - p[2] for p, after in zip(rest, pose) if p[0] == 2 and {p[1], p[2]} <= {1, 2}},
                         {0.5})
        for options, message in [
                (["limb", 0, 0, 0], "--select: the lattice has no limb at (0, 0, 0): no section between there "
                                    "and the rest is narrow"),
                (["limb", 0, 0], "--select: limb 0 0: expected limb X Y Z"),
                (["grow", 1], "--select: grow 1: the whole lattice is selected; give another --select before it"),
                (["end", "+x", "--select", "shrink", 1], "--select: shrink 1: expected at least one vertex there; "
                                                         "the lattice has none. Give fewer steps"),
                (["beyond", 100000], "--select: face: expected 0 to "),
                (["beyond", 1, 2], "--select: beyond 1 2: expected beyond FACE or X Y Z"),
                (["grow", 0.5], "--select: grow 0.5: expected grow N, a whole number")]:
            with self.subTest(options):
                self.assertIn(message, self.error_of("pose", "figure.ovm", "--select", *options, *move, "-o",
                                                     "y.ovm", code=2))
        # Few vertices are noted, unless they are named one by one.
        result = self.run_program("pose", "figure.ovm", "--select", "ball", 0, 0, 0, 0.1, *move, "-o", "x.ovm")
        self.assertEqual(result.stderr, "espalier: note: --select ball 0 0 0 0.1 selects one of 80 vertices; a "
                                        "larger region, or --select grow 1 after it, selects more\n")
        result = self.run_program("pose", "figure.ovm", "--select", "vertices", 0, *move, "-o", "x.ovm")
        self.assertEqual(result.stderr, "")

    def test_pivots(self):
        # Rotations about the middle of the top, (0, 0, 4); about vertex 0; about the section at z = 2.
        top = ["--select", "end", "+z"]
        for pivot, center in [(["border"], (0, 0, 4)), (["vertex", 0], self.rest[0]), ([-1, 2, -.5], (-1, 2, -0.5)),
                              (["joint", 1, 0.3, 2.1], (0, 0, 2))]:
            for operation in [["--rotate", "x", 40], ["--scale", 2]]:
                with self.subTest((pivot, operation)):
                    expected = self.pose(*top, "--center", *center, *operation)
                    for point, wanted in zip(self.pose(*top, "--about", *pivot, *operation), expected):
                        for a, b in zip(point, wanted):
                            self.assertAlmostEqual(a, b, delta=1e-14)
        # Pivots follow the operations before; twist begins at the pivot.
        moved = self.pose("--move", 1, 0, 0, *top, "--about", "border", "--scale", 2)
        self.assertEqual({p for p in moved if p[2] == 4},
                         {(1 + 2 * x, 2 * y, 4) for x, y, z in self.rest if z == 4})
        self.assert_moved(["--about", 0, 0, 1, "--twist", "z", 90],
                          lambda *p: rotated(p, 90 * max(p[2] - 1, 0) / 3))
        self.assert_moved(["--about", 0, 0, 1, "--range", 0, 4, "--twist", "z", 90],
                          lambda *p: rotated(p, 90 * p[2] / 4))
        place = "--rotate, --scale, --twist, --bend or --taper"
        for options, message in [
                (["--about", "knee"], "--about: expected vertex NUMBER; border; joint X Y Z; X Y Z; got knee"),
                (["--about", "vertex", -1], "--about: expected vertex NUMBER; border; joint X Y Z; X Y Z; got vertex -1"),
                (["--about", "vertex", 45], "--about: vertex 45: expected 0 to 44"),
                (["--about", "border"], "--about: border: the whole lattice is selected, and has no border"),
                (["--center", 0, 0, 0, "--about", 0, 0, 0],
                 "--center: has no effect: the --about after it replaces it; put it before " + place)]:
            with self.subTest(options):
                self.assertIn(message, self.error_of("pose", "rest.ovm", *options, "--rotate", "z", 90, "-o",
                                                     "x.ovm", code=2))

    def test_the_other_side_does_what_one_side_does(self):
        top = ["--select", "box", -1, 1, 4, 1, 1, 4]
        out = self.run_program("pose", "rest.ovm", *top, "--rotate", "z", 30, "--move", 0, 0.5, 1, "--mirror", "y",
                               "-o", "both.ovm").stdout
        self.assertEqual(out, "mirror: 3 of 3 selected vertices at y = 0\nboth.ovm: 6 of 45 vertices moved\n")
        one = dict(zip(self.rest, self.pose(*top, "--rotate", "z", 30, "--move", 0, 0.5, 1)))
        for (x, y, z), after in zip(self.rest, self.read_ovm_positions("both.ovm")):
            expected = one[(x, 1, z)] if y else one[(x, y, z)]
            self.assertEqual(after, (expected[0], -expected[1], expected[2]) if y < 0 else expected)
        # Another plane: at z = 3.5, the layer at 4 is the image of the layer at 3, and the others have none.
        out = self.run_program("pose", "rest.ovm", "--select", "half-space", 0, 0, 2, 0, 0, 1, "--move", 0, 0, 0.25,
                               "--mirror", "z=3.5", "-o", "both.ovm").stdout
        self.assertEqual(out, "mirror: 18 of 27 selected vertices at z = 3.5; 9 without a mirror image stay\n"
                              "both.ovm: 27 of 45 vertices moved\n")
        heights = {z: after[2] for (x, y, z), after in zip(self.rest, self.read_ovm_positions("both.ovm"))}
        self.assertEqual(heights, {0: 0, 1: 1, 2: 2.25, 3: 2.75, 4: 4.25})
        for words, message in [
                (["w"], "--mirror: expected x, y or z, or a plane such as x=0.5, got w"),
                (["x=here"], "--mirror: expected x, y or z, or a plane such as x=0.5, got x=here"),
                (["x=9"], "--mirror: mirror: no position with a weight above 0 has a mirror image at x = 9")]:
            with self.subTest(words):
                self.assertIn(message, self.error_of("pose", "rest.ovm", "--mirror", *words, "-o", "x.ovm", code=2))

    def test_lengths_may_be_percentages_of_the_diagonal(self):
        # The box is 2 x 2 x 4, with the diagonal √24.
        half = 24 ** 0.5 / 2
        self.assert_moved(["--move", "50%", "-50%", 0], lambda x, y, z: (x + half, y - half, z))
        self.assertEqual(self.pose("--select", "ball", 0, 0, 5, "40%", "--move", 1, 0, 0),
                         self.pose("--select", "ball", 0, 0, 5, 0.8 * half, "--move", 1, 0, 0))
        self.run_program("pose", "--select", "end", "+z", "--falloff", "linear", "50%", "--move", 1, 0, 0, "rest.ovm",
                         "-o", "pose.ovm")
        for (x, y, z), after in zip(self.rest, self.read_ovm_positions("pose.ovm")):
            self.assertAlmostEqual(after[0], x + max(0, 1 - max(0, 4 - z - 0.04) / half), delta=1e-14)

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
