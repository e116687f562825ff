#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Python code of docs/tutorial.md. The page shows parts of this file; docs_pages checks that."""

import pathlib
import tempfile
import unittest

import numpy as np

import espalier


def some_points():
    """A coil inside the box, and a point far away."""
    turn = 0.1 * np.arange(301)
    coil = np.stack([0.8 * np.cos(turn), 0.8 * np.sin(turn), 0.2 + 0.12 * turn], axis=1)
    return np.concatenate([coil, [[9, 0, 0]]])


class Tutorial(unittest.TestCase):
    def test_a_lattice_of_your_own(self):
        corners = np.array([[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0],
                            [0, 0, 2], [2, 0, 2], [2, 3, 2], [0, 3, 2],
                            [1, 0, 3], [1, 3, 3]])
        house = espalier.Lattice(
            corners, [[0, 1, 2, 3, 4, 5, 6, 7],
                      [4, 5, 8, 7, 6, 9]])

        self.assertEqual(house.counts, (10, 4 + 4 + 4 + 5, 6 + 5 - 1, 2))
        with self.assertRaises(ValueError):
            espalier.Lattice(corners, [[[0, 1, 99]]])

    def test_from_a_lattice_to_a_pose(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        file = pathlib.Path(folder.name) / "level-2.vtu"

        rest = espalier.shapes.box(cells=(2, 2, 4),
                                   min=(-1, -1, 0),
                                   max=(1, 1, 4))
        self.assertEqual(rest.positions.shape, (3 * 3 * 5, 3))

        refiner = espalier.Refiner(rest)
        cells = refiner.counts(2)[3]
        corners = (refiner.strata(2) == 0).sum()
        self.assertEqual((cells, corners), (16 * 8 * 8, 8))

        S = refiner.stencils(2).csr()
        rows = S.shape[0]
        weights = S[-1].data
        self.assertEqual(S.shape[1], 45)
        self.assertEqual(rows, refiner.counts(2)[0])
        self.assertAlmostEqual(weights.sum(), 1, delta=1e-15)  # rounding of about ten weights

        positions = refiner.positions(2)
        refiner.refine(2).write(file)
        self.assertTrue(np.array_equal(espalier.read(file).positions, positions))

        points = some_points()

        binding = espalier.bind(rest, points, level=3)
        D = binding.matrix  # points x vertices
        outside = (binding.statuses == int(
            espalier.PointStatus.OUTSIDE)).sum()
        self.assertEqual(D.shape, (302, 45))
        self.assertEqual(outside, 1)
        self.assertEqual(list(binding.kept), [301])

        pose = rest.positions.copy()
        pose[:, 0] += 0.1 * pose[:, 2] ** 2
        moved = binding.deform(pose)
        self.assertGreater(moved[300, 0], points[300, 0] + 1)
        self.assertTrue(np.array_equal(moved[301], points[301]))

        # Several poses at once; or one by one, in single precision,
        # into an existing array.
        several = binding.deform(np.stack([rest.positions, pose]))
        result = np.empty((302, 3), np.float32)
        binding.deform(pose.astype(np.float32), out=result)
        # Sums of up to 64 products of size 4, also for the error of the rest pose.
        np.testing.assert_allclose(several[1], moved, rtol=0, atol=1e-14)
        np.testing.assert_allclose(several[0], points, rtol=0, atol=1e-12)
        np.testing.assert_allclose(result, moved, rtol=0, atol=1e-5)  # units of 5e-7

        # Gradients of the sum of z² of the points.
        by_points = np.zeros_like(moved)
        by_points[:, 2] = 2 * moved[:, 2]
        by_vertices = binding.adjoint(by_points)
        # <g, D p> = <D.T g, p>: sums of about a hundred terms of size 10.
        self.assertAlmostEqual((by_points * (D @ pose)).sum(), (by_vertices * pose).sum(),
                               delta=1e-9)

        # Two points are pulled; the floor stays.
        fit = espalier.fit(
            rest, binding, rows=[150, 300],
            misses=[[0.2, 0, 0], [0, 0, 0.3]],
            smoothing="laplacian", frozen=range(9))
        fitted = rest.positions + fit.displacements
        self.assertLess(fit.largest_miss, 0.01)
        self.assertTrue(np.array_equal(fitted[8], rest.positions[8]))

        check = espalier.ValidityCheck(rest, level=2)
        validity = check.check(fitted)
        folds = len(validity.inverted) > 0
        step = check.largest_step(fitted, most=100)
        self.assertFalse(folds)
        self.assertGreater(validity.smallest[1], 0.1)
        self.assertTrue(1 < step.length < 100)


if __name__ == "__main__":
    unittest.main()
