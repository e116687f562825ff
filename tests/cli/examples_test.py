#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the examples run, and that their physics is right.

    examples_test.py PATH_OF_ESPALIER PATH_OF_ELASTIC_LATTICE FOLDER_OF_EXAMPLES
"""

import math
import pathlib
import subprocess
import sys
import unittest
from unittest import mock

import numpy as np
import scipy.optimize
import scipy.sparse

import program
from program import CliTest

ELASTIC = EXAMPLES = ""  # the tests set them


class PanelMethod(unittest.TestCase):
    def test_circle(self):
        points = np.exp(2j * np.pi * np.arange(120) / 120)
        flow = panel_method.Flow(points, 0)
        exact = 1 - 4 * np.sin(np.angle(flow.middle))**2
        # A polygon replaces the circle. The error is 9e-4 here, and a quarter of it for twice the
        # number of panels.
        self.assertLess(abs(flow.pressure - exact).max(), 1e-3)
        self.assertLess(abs(flow.lift), 1e-12)

    def test_a_section_of_karman_and_trefftz(self):
        """Compares with an exact flow. The map takes a circle through 1 to a section with a trailing
        edge of 14.4 degrees, and the flow around both is known (Milne-Thomson, Theoretical
        Aerodynamics, 7.5)."""
        n, centre, incidence = 1.92, -0.1, np.radians(5)
        radius = 1 - centre

        def section(turn):
            c = centre + radius * np.exp(1j * turn)
            up, down = (c + 1)**n, (c - 1)**n
            return n * (up + down) / (up - down)

        count = 240
        turn = 2 * np.pi * np.arange(count) / count
        flow = panel_method.Flow(section(turn), incidence)
        # The lift is twice the circulation, for a chord of 1. The error is of second order in the
        # size of the panels: about 1e-4 for 240 panels.
        exact = 8 * np.pi * radius * np.sin(incidence)
        self.assertLess(abs(flow.lift / exact - 1), 1e-3)

        middle = turn + np.pi / count
        c = radius * np.exp(1j * middle) + centre
        speed = 2 * abs(np.sin(middle - incidence) + np.sin(incidence))
        stretch = abs(4 * n**2 * ((c + 1) * (c - 1))**(n - 1) / ((c + 1)**n - (c - 1)**n)**2)
        away = abs(c - 1) > 0.1  # from the trailing edge, where dz/dc is 0
        error = abs(flow.pressure - (1 - (speed / stretch)**2))[away]
        # The pressures go down to −1.6. Their error is of second order, too.
        self.assertLess(error.max(), 0.01)

    def test_naca_0012(self):
        points = panel_method.naca(0, 0.12, 120)
        self.assertAlmostEqual(np.ptp(points.imag), 0.12, places=4)  # no point is exactly at the thickest
        flow = panel_method.Flow(points, np.radians(5))
        # Thin aerofoil theory with the first-order correction for thickness has an error of second
        # order, which is a few thousandths.
        thin = 2 * math.pi * math.sin(math.radians(5))
        self.assertAlmostEqual(flow.lift, thin * (1 + 0.77 * 0.12), delta=0.01)
        # Pressures add up to the same lift, and to no drag.
        panels = np.roll(points, -1) - points
        force = (flow.pressure * panels * 1j).sum() / flow.onflow
        self.assertAlmostEqual(force.imag, flow.lift, delta=0.002)
        self.assertAlmostEqual(force.real, 0, delta=0.002)
        self.assertAlmostEqual(panel_method.Flow(points, 0).lift, 0, places=10)

    def test_gradients(self):
        points = panel_method.naca(0.04, 0.12, 40)
        random = np.random.default_rng(2)
        weights, step = random.normal(size=40), 1e-7 * random.normal(size=(2, 40)).T @ [1, 1j]

        def difference(function):
            return function(points + step) - function(points - step)

        for gradient, function in (
                (panel_method.Flow(points, 0.1).gradient(weights),
                 lambda p: weights @ panel_method.Flow(p, 0.1).strength),
                (panel_method.area(points)[1], lambda p: panel_method.area(p)[0])):
            slope = 2 * (gradient.conj() @ step).real
            # The difference has an error of second order in the steps, which are 1e-5 of the smallest
            # panels. Rounding adds 1e-16 of the value, which is 1e-8 of the difference.
            self.assertLess(abs(difference(function) / slope - 1), 1e-6)


def gradient_error(function, at, directions=5):
    """Returns the largest relative difference of a gradient from fourth-order central differences."""
    worst = 0
    for direction in np.random.default_rng(1).normal(size=(directions, len(at))):
        h = 1e-5 / np.linalg.norm(direction)
        near, far = (function(at + k * h * direction)[0] - function(at - k * h * direction)[0]
                     for k in (1, 2))
        slope = (8 * near - far) / (12 * h)
        worst = max(worst, abs(function(at)[1] @ direction / slope - 1))
    return worst


class Aerofoil(CliTest):
    def run_example(self, path):
        return subprocess.run([sys.executable, pathlib.Path(EXAMPLES) / "aerofoil.py", "--program",
                               path, "--work", self.path], text=True, capture_output=True,
                              timeout=120, check=False)

    def test_optimises(self):
        result = self.run_example(program.ESPALIER)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        words = [line.split() for line in result.stdout.splitlines()]
        before, after = ({line[i]: float(line[i + 1]) for i in (1, 3, 5)} for line in words[:2])
        # The lattice can only approximate NACA 4412, but closely.
        self.assertLess(after["objective"], before["objective"] / 500)
        self.assertAlmostEqual(after["area"], before["area"], places=6)
        wanted = panel_method.Flow(panel_method.naca(0.04, 0.12, 120), aerofoil.INCIDENCE)
        self.assertAlmostEqual(after["lift"], wanted.lift, delta=0.005)
        self.assertAlmostEqual(before["lift"], 0.241, delta=0.005)

        section, optimised = (np.array(self.read_points(f"{name}.obj"))[:, :2] @ [1, 1j]
                              for name in ("section", "optimised"))
        self.assertLess(abs(optimised - section)[[0, 60]].max(), 1e-12)  # the ends stay
        self.assertLess(abs((optimised - section).real).max(), 1e-12)
        # The section gets the target's camber: the middle of both sides is 4 % high at 40 % of the
        # chord.
        camber = (optimised + np.roll(optimised[::-1], 1)).imag[1:60] / 2
        self.assertAlmostEqual(camber.max(), 0.04, delta=0.002)
        self.assertAlmostEqual(section.real[1 + camber.argmax()], 0.4, delta=0.1)

        pose = np.array(self.read_ovm_positions("pose.ovm"))
        rest = np.array(self.read_ovm_positions("rest.ovm"))
        np.testing.assert_array_equal(pose[:18, 1], pose[18:, 1])
        np.testing.assert_array_equal(pose[:, ::2], rest[:, ::2])

        deformation = scipy.sparse.load_npz(self.path / "D.npz")
        # `deform` gives the same section as D, except for the order of sums.
        np.testing.assert_allclose(deformation @ pose[:, :2] @ [1, 1j], optimised, rtol=0,
                                   atol=1e-14)
        design = aerofoil.Design(section, deformation, rest, aerofoil.wanted_pressure(section))
        variables = (pose - rest)[:, 1] @ design.link / np.asarray(design.link.sum(axis=0)).ravel()
        # Halfway, because the gradient is nearly 0 at the end. The differences are good to 1e-8.
        for function in (design.objective, design.area_gain):
            self.assertLess(gradient_error(function, variables / 2), 1e-6)

    def test_refusals(self):
        for path, message in (("no-such-program", "no-such-program: not a program"),
                              ("false", "false shape box: failed")):
            result = self.run_example(path)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(result.stderr, message + "\n")

    def test_an_optimisation_that_fails_is_told(self):
        with mock.patch.object(scipy.optimize, "minimize") as minimize, \
                mock.patch.object(sys, "argv", ["aerofoil.py", "--program", program.ESPALIER,
                                                "--work", str(self.path)]):
            minimize.return_value = mock.Mock(success=False, message="Iteration limit reached")
            with self.assertRaises(SystemExit) as raised:
                aerofoil.main()
        self.assertEqual(raised.exception.code, "no optimum was found: Iteration limit reached")
        self.assertFalse((self.path / "pose.ovm").exists())

    def test_numpy_2(self):
        """In NumPy 2, unique() returns an inverse with one more axis."""
        unique = np.unique

        def with_an_axis(*arguments, **named):
            values, inverse = unique(*arguments, **named)
            return values, inverse[:, np.newaxis]

        points = panel_method.naca(0, 0.12, 120)
        rest = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]])
        with mock.patch.object(np, "unique", with_an_axis):
            design = aerofoil.Design(points, None, rest, None)
        np.testing.assert_array_equal(design.link.toarray(), [[1, 0], [0, 1], [1, 0], [0, 1]])

    def test_a_wrong_gradient_is_found(self):
        def function(factor):
            return lambda x: (np.sin(x).sum(), factor * np.cos(x))

        at = np.linspace(0.1, 1, 5)
        self.assertLess(gradient_error(function(1), at), 1e-8)
        self.assertGreater(gradient_error(function(1 + 2e-6), at), 1e-6)


class ElasticLattice(CliTest):
    LENGTH, POISSON = 10.0, 0.3

    def deflection(self, points, weight, cells="20 2 2", name="out.obj", at=(0, 0, 0)):
        """Returns how the given points of a 1 × 1 bar move. The bar is held at x = 0."""
        low, high = (np.add(at, corner) for corner in ((0, -0.5, -0.5), (self.LENGTH, 0.5, 0.5)))
        self.run_program("shape", "box", "--cells", *cells.split(), "--min", *low, "--max", *high,
                         "-o", "rest.ovm")
        self.write_model([tuple(np.add(p, at)) for p in points])
        self.elastic("model.obj", "rest.ovm", at[0], weight, name, "pose.ovm")
        return np.array(self.read_points(name)) - np.add(points, at)

    def elastic(self, *arguments, code=0):
        result = subprocess.run([ELASTIC, *map(str, arguments)], cwd=self.path, text=True,
                                capture_output=True, timeout=120, check=False)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def tip(self):
        return [(self.LENGTH, y, z) for y in (-0.3, 0.3) for z in (-0.3, 0.3)]

    def timoshenko(self):
        """Returns the deflection of the tip for a force of 1 there: the bending by Euler and
        Bernoulli, plus the shear with Cowper's coefficient for rectangles."""
        coefficient = 10 * (1 + self.POISSON) / (12 + 11 * self.POISSON)
        return self.LENGTH**3 / (3 / 12) + self.LENGTH * 2 * (1 + self.POISSON) / coefficient

    def test_a_beam(self):
        weight = 1e-6
        bends = [-self.deflection(self.tip(), weight, cells)[:, 2].mean() / weight
                 for cells in ("10 2 2", "20 2 2")]
        exact = self.timoshenko()
        # The lattice takes the shape of least energy among the shapes that it can represent. So it
        # bends too little (Ritz), and a finer lattice bends more.
        self.assertLess(bends[0], bends[1])
        self.assertLess(bends[1], exact)
        # A cubic spline has no curvature at its end, but the beam is held there and has its largest
        # curvature there. The second derivatives of splines are piecewise linear, so the lattice
        # misses √3/2 · cell / length of the energy. Shear makes the loss smaller. Two cells across
        # cannot bulge as they should, which costs another 1 %.
        for bend, cell in zip(bends, (1, 0.5)):
            self.assertGreater(bend, (1 - math.sqrt(3) / 2 * cell / self.LENGTH - 0.012) * exact)

    def test_a_beam_with_its_weight_all_along(self):
        points = [(x, y, z) for x in (np.arange(80) + 0.5) / 8 for y in (-0.3, 0.3)
                  for z in (-0.3, 0.3)]
        weight, x = 1e-6, points[-1][0]
        bend = -self.deflection(points, weight)[-4:, 2].mean()
        exact = weight / self.LENGTH * x * x * (6 * 100 - 40 * x + x * x) / (24 / 12)
        # Shear adds 1 %. The lattice is stiffer by 3 %, as in test_a_beam.
        self.assertLess(abs(bend / exact - 1), 0.05)

    def test_it_narrows_where_it_is_stretched(self):
        weight, x = 1e-6, 5
        self.deflection(self.tip(), weight)
        self.write_model([(x, 0.5, 0.5), (x, 0.5, -0.5)], "probes.obj")
        self.deform("probes.obj", "rest.ovm", "pose.ovm", "-n", 2, out="moved.obj")
        above, below = np.array(self.read_points("moved.obj"))[:, 1] - 0.5
        stretch = weight * (self.LENGTH - x) * 12 * 0.5  # moment / (width · height³ / 12) · z
        # The beam bends about 3 % too little, as in test_a_beam.
        self.assertLess(abs(-above / (self.POISSON * stretch * 0.5) - 1), 0.03)
        self.assertLess(abs(below / (self.POISSON * stretch * 0.5) - 1), 0.03)

    def test_it_is_linear_and_moves_along(self):
        points = self.tip() + [(5, 0.1, 0.2)]
        once = self.deflection(points, 1e-6)
        # Positions are near 10, where doubles are 2e-15 apart.
        np.testing.assert_allclose(self.deflection(points, 3e-6), 3 * once, atol=1e-13)
        # Near 1000, doubles are 1e-13 apart. The weights of the tables have errors of the same size.
        np.testing.assert_allclose(self.deflection(points, 1e-6, at=(700, -900, 1000)), once,
                                   atol=1e-11)

    def test_beyond_its_load_a_beam_moves_rigidly(self):
        points = [(3.0, y, z) for y in (-0.3, 0.3) for z in (-0.3, 0.3)]
        self.deflection(points, 1e-6)
        pose, rest = (np.array(self.read_ovm_positions(f"{name}.ovm")) for name in ("pose", "rest"))
        far = rest[:, 0] > 8
        ones = np.ones((far.sum(), 1))
        motion, *_ = np.linalg.lstsq(np.hstack([rest[far], ones]), (pose - rest)[far], rcond=None)
        turn = motion[:3]
        self.assertGreater(abs(turn[0, 2]), 1e-5)
        # Five thicknesses from the load, the strains have died down (Saint-Venant).
        np.testing.assert_allclose(np.hstack([rest[far], ones]) @ motion, (pose - rest)[far],
                                   atol=1e-5 * abs(turn[0, 2]))
        np.testing.assert_allclose(turn + turn.T, 0, atol=1e-5 * abs(turn[0, 2]))

    def test_a_hinge_does_not_hold(self):
        self.run_program("shape", "box", "--cells", 4, 4, 4, "-o", "box.ovm")
        lines, rows, positions = aerofoil.read_lattice(self.path / "box.ovm")
        # Only one edge of the box is held. The weight has no torque about the edge, so it alone would
        # not turn the box.
        turn = np.array([[1, -1, 0], [1, 1, 0], [0, 0, math.sqrt(2)]]) / math.sqrt(2)
        positions = positions @ turn.T
        lines[rows] = [" ".join(f"{x:.17g}" for x in p) for p in positions]
        self.put("rest.ovm", "\n".join(lines) + "\n")
        self.write_model([tuple(positions.mean(axis=0))])
        edge = positions[:, 0].min() + 1e-9
        self.assertEqual((positions[:, 0] <= edge).sum(), 5)
        error = self.elastic("model.obj", "rest.ovm", edge, 1e-6, "out.obj", code=1).stderr
        self.assertIn("do not hold the lattice", error)
        self.assertFalse((self.path / "out.obj").exists())

    def test_what_is_held_stays(self):
        self.run_program("shape", "box", "-o", "rest.ovm")
        self.write_model([(0.1, 0.2, 0.1)])
        self.assertEqual(self.elastic("model.obj", "rest.ovm", 9, 1, "out.obj").stdout,
                         "largest displacement: 0\n")
        # The rows of D sum to 1, except for rounding.
        self.assert_close(self.read_points("out.obj"), [(0.1, 0.2, 0.1)], 1e-15)

    def test_refusals(self):
        self.write_model([(0.1, 0.2, 0.1)])
        self.run_program("shape", "octahedron", "-o", "rest.ovm")
        error = self.elastic("model.obj", "rest.ovm", -0.5, 1, "out.obj", code=1).stderr
        self.assertIn("cell 0 of level 2 is not a hexahedron", error)
        self.run_program("shape", "tetrahedron", "-o", "rest.ovm")  # one edge is held
        error = self.elastic("model.obj", "rest.ovm", -0.5, 1, "out.obj", code=1).stderr
        self.assertIn("do not hold the lattice", error)
        error = self.elastic("model.obj", "rest.ovm", -5, 1, "out.obj", code=1).stderr  # none held
        self.assertIn("do not hold the lattice", error)
        self.write_model([(0.1, 0.2, 7)])
        error = self.elastic("model.obj", "rest.ovm", -0.5, 1, "out.obj", code=1).stderr
        self.assertIn("point 0", error)
        error = self.elastic("model.obj", "rest.ovm", "here", 1, "out.obj", code=1).stderr
        self.assertIn("'here' is not a finite number", error)
        self.elastic("model.obj", "rest.ovm", code=1)
        self.assertFalse((self.path / "out.obj").exists())


if __name__ == "__main__":
    program.ESPALIER, ELASTIC, EXAMPLES = sys.argv[1:4]
    del sys.argv[1:4]
    sys.dont_write_bytecode = True
    sys.path.insert(0, EXAMPLES)
    import aerofoil
    import panel_method
    unittest.main()
