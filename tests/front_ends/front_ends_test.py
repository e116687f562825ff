#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Does each scenario of scenarios.py by the program, by C and by Python, and compares.

C and Python must give the same points to the last bit, the program the same but for rounding, and each the same again from
the binding that it has saved; the rest pose must give the points themselves; and an affine pose must move the points
inside affinely. What is special to a front
end, such as its messages, is tested in tests/cli, tests/c and tests/python."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import espalier
from scenarios import SCENARIOS

PROGRAM, C_PROGRAM = sys.argv[1:3]

# The constants of C are the places of the words in these lists (tests/docs/words_test.py compares them).
WORDS = {
    "outside": ("keep", "nearest", "error"),
    "rules": ("siggraph96", "cse96", "mlca"),
    "boundary": ("sharp", "edge-only", "open"),
    "sharp-edges": ("single-cell", "literal"),
    "creasing": ("uniform", "chaikin"),
    "triangles": ("catmark", "smooth"),
    "basis": ("bezier", "bspline"),
}
LINEAR, OFFSET = np.array([[1.5, 0.25, 0], [0, 1, -0.5], [0.125, 0, 2]]), np.array([1, 2, 3])


def twist(positions):
    """A smooth map that is far from affine."""
    x, y, z = positions.T
    return np.stack([x + 0.3 * z * z, y - 0.2 * x * z, z + 0.1 * np.sin(3 * x)], axis=1)


def colors_of(points):
    """Three weights for each point: a third of them is 0, and a third is 1."""
    return (np.arange(len(points))[:, None] + [0, 1, 2]) % 3 / 2


def points_of(lattice):
    """Points in the cells and near their vertices, one just outside of the lattice, and one far away."""
    points = []
    for loops in lattice.cells:
        corners = lattice.positions[sorted({vertex for loop in loops for vertex in loop})]
        centre = corners.mean(axis=0)
        points += [centre, *(0.5 * centre + 0.5 * corners[:3]), 0.1 * centre + 0.9 * corners[0]]
    top = lattice.positions.max(axis=0)
    return np.array([*points, top + 0.05 * (top - lattice.positions.min(axis=0)), top + 9])


class FrontEnds(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_program(self, *arguments):
        result = subprocess.run(list(map(str, arguments)), cwd=self.folder, capture_output=True, text=True, timeout=120,
                                check=False)
        self.assertEqual(result.returncode, 0, f"{arguments}: {result.stdout}{result.stderr}")
        return result.stdout

    def write_files(self, scenario):
        """Writes rest.ovm, model.obj and the poses. Returns the lattice, the points and the names of the poses."""
        self.run_program(PROGRAM, "shape", *scenario.lattice, "-o", "rest.ovm", "--quiet")
        rest = espalier.read(self.folder / "rest.ovm")
        if scenario.marks:
            # The edges on the axis of the cylinder.
            axis = set(np.flatnonzero(np.abs(rest.positions[:, :2]).max(axis=1) < 1e-12).tolist())
            edges = [edge for edge in map(tuple, rest.edges.tolist()) if axis.issuperset(edge)]
            rest = rest.with_marks(edge_sharpness=dict(zip(edges, (2.5, 1.0), strict=True)), vertex_sharpness={2: 1.5})
        points = points_of(rest)
        (self.folder / "model.obj").write_text(
            "".join("v %.17g %.17g %.17g %g %g %g\n" % (*point, *color)
                    for point, color in zip(points, colors_of(points), strict=True)))
        poses = {"rest.ovm": rest.positions, "affine.ovm": rest.positions @ LINEAR.T + OFFSET,
                 "twist.ovm": twist(rest.positions)}
        for name, positions in poses.items():
            rest.with_positions(positions).write(self.folder / name)
        return rest, points, list(poses)

    def by_program(self, scenario, poses):
        to = {"level": ("-n", scenario.level), "limit": ("--limit",)}.get(scenario.to, ("--basis", scenario.to))
        outside = ("--falloff", scenario.falloff) if scenario.falloff else ("--outside", scenario.outside)
        options = [*to, *outside, *(("--weights", scenario.weights) if scenario.weights else ()),
                   *(word for key, value in scenario.refinement.items() for word in ("--" + key, value))]
        self.run_program(PROGRAM, "deform", "model.obj", "--rest", "rest.ovm", "--to", *poses, *options, "-o",
                         "out%d.obj", "--quiet")
        self.run_program(PROGRAM, "bind", "model.obj", "--rest", "rest.ovm", *options, "-o", "bound.espb", "--quiet")
        self.run_program(PROGRAM, "apply", "bound.espb", "--to", *poses, "-o", "applied%d.obj", "--quiet")

        def points_of_file(name):
            return [[float(word) for word in line.split()[1:4]]
                    for line in (self.folder / name).read_text().splitlines()]

        return [np.array([points_of_file(f"{name}{i}.obj") for i in range(len(poses))]) for name in ("out", "applied")]

    def by_c(self, scenario, poses, count):
        def number(key, word):
            return WORDS[key].index(word)

        basis = scenario.to if scenario.to in ("level", "limit") else number("basis", scenario.to)
        options = [number(key, scenario.refinement.get(key, WORDS[key][0]))
                   for key in ("rules", "boundary", "sharp-edges", "creasing", "triangles")]
        lines = self.run_program(C_PROGRAM, "rest.ovm", "model.obj", "c.espb", basis, scenario.level,
                                 number("outside", scenario.outside), *options, scenario.falloff,
                                 scenario.weights or "-", *poses).splitlines()
        points = np.array([[float(word) for word in line.split()] for line in lines[count:]])
        return np.array(lines[:count], dtype=int), points.reshape(2, len(poses), count, 3)

    def by_python(self, scenario, rest, points, poses):
        refinement = {key.replace("-", "_"): value for key, value in scenario.refinement.items()}
        lattice = espalier.Refiner(rest, **refinement) if refinement else rest
        to = {"level": {"level": scenario.level}, "limit": {"limit": True}}.get(scenario.to, {"basis": scenario.to})
        if scenario.weights:
            to["weights"] = colors_of(points)[:, ("red", "green", "blue").index(scenario.weights)]
        binding = espalier.bind(lattice, points, outside=scenario.outside, falloff=scenario.falloff, **to)
        binding.save(self.folder / "python.espb")
        loaded = espalier.load_binding(self.folder / "python.espb")
        positions = [espalier.read_pose(self.folder / pose, rest) for pose in poses]
        return binding, [np.array([each.deform(pose) for pose in positions]) for each in (binding, loaded)]

    def check(self, scenario):
        rest, points, poses = self.write_files(scenario)
        binding, (python, loaded) = self.by_python(scenario, rest, points, poses)
        statuses, c = self.by_c(scenario, poses, len(points))
        deformed, applied = self.by_program(scenario, poses)
        np.testing.assert_array_equal(statuses, binding.statuses)
        for name, got in (("Python, loaded", loaded), ("C", c[0]), ("C, loaded", c[1])):
            np.testing.assert_array_equal(got, python, name)
        np.testing.assert_array_equal(applied, deformed)
        # The program adds up the products of a row in another order than the deformer of C and Python. The rows have
        # weights whose absolute values sum to 8 at most, and vertices move by less than 20: 64 additions of numbers
        # below 160 have rounding errors of 1e-14 each at most.
        np.testing.assert_allclose(deformed, python, rtol=0, atol=64e-14)
        for at_rest in (python[0], deformed[0]):
            np.testing.assert_array_equal(at_rest, points)

        _, affine, twisted = python
        inside = binding.statuses == espalier.PointStatus.INSIDE
        self.assertGreater(np.count_nonzero(inside), len(points) / 5)
        self.assertGreater(np.count_nonzero(~inside), 0)
        # Points are placed within 1e-12 of the size, which is below 10, and the map stretches by less than 3.
        weights = binding.matrix.sum(axis=1)
        np.testing.assert_allclose((affine - points)[inside],
                                   (np.asarray(weights) * (points @ LINEAR.T + OFFSET - points))[inside], atol=3e-11)
        if scenario.weights:
            self.assertGreater(np.count_nonzero(binding.statuses == espalier.PointStatus.NOT_BOUND), len(points) / 4)
        self.assertGreater(np.abs(twisted - points)[inside].max(), 0.01)
        stay = np.diff(binding.table.offsets) == 0
        np.testing.assert_array_equal(twisted[stay], points[stay])
        self.assertTrue(stay[-1], "the point far away")
        if scenario.outside == "keep" and not scenario.falloff:
            np.testing.assert_array_equal(stay, ~inside)
        return twisted

    def test_scenarios(self):
        results = {}
        for scenario in SCENARIOS:
            with self.subTest(scenario.name()):
                result = self.check(scenario).tobytes()
                # Each scenario is a deformation of its own: no option is ignored.
                self.assertNotIn(result, results, results.get(result))
                results[result] = scenario.name()


if __name__ == "__main__":
    del sys.argv[1:3]
    unittest.main()
