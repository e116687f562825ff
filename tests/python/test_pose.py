# SPDX-License-Identifier: Apache-2.0
"""espalier.pose: the formulas are tested in C++; here, that the arguments arrive."""

import numpy as np
import pytest

import espalier
from espalier import pose

BOX = espalier.shapes.box(cells=(2, 2, 4), min=(-1, -1, 0), max=(1, 1, 4)).positions
TOP = BOX[:, 2] == 4


def rotated(points, angle):
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return points @ turn.T


def test_operations():
    np.testing.assert_allclose(pose.move(BOX, (1, 2, 3)), BOX + (1, 2, 3))
    np.testing.assert_allclose(pose.rotate(BOX, "z", 0.5), rotated(BOX, 0.5), atol=1e-14)
    np.testing.assert_allclose(pose.rotate(BOX, (0, 0, -2), 0.5), rotated(BOX, -0.5), atol=1e-14)
    np.testing.assert_allclose(pose.rotate(BOX, "-z", 0.5), rotated(BOX, -0.5), atol=1e-14)
    around_corner = pose.rotate(BOX, "z", np.pi, center=(1, 1, 0))
    np.testing.assert_allclose(around_corner, (2, 2, 0) + BOX * (-1, -1, 1), atol=1e-14)
    np.testing.assert_allclose(pose.scale(BOX, 2), (0, 0, -2) + 2 * BOX)
    np.testing.assert_allclose(pose.scale(BOX, (2, 1, 1), center=(1, 0, 0)), BOX * (2, 1, 1) - (1, 0, 0))
    twisted = pose.twist(BOX, "z", 1.0)
    np.testing.assert_allclose(twisted[TOP], rotated(BOX[TOP], 1.0), atol=1e-14)
    np.testing.assert_array_equal(twisted[BOX[:, 2] == 0], BOX[BOX[:, 2] == 0])
    half = pose.twist(BOX, "z", 1.0, range=(0, 8))
    np.testing.assert_allclose(half[TOP], rotated(BOX[TOP], 0.5), atol=1e-14)
    tapered = pose.taper(BOX, "z", 0.5)
    np.testing.assert_allclose(tapered[TOP], BOX[TOP] * (0.5, 0.5, 1))
    # A quarter circle of length 4 about (8 / pi, 0) in the x, z plane.
    bent = pose.bend(BOX, "z", np.pi / 2, "x")
    np.testing.assert_allclose(bent[TOP][:, 2], 8 / np.pi - BOX[TOP][:, 0], atol=1e-14)
    np.testing.assert_allclose(bent[TOP][:, 0], 8 / np.pi, atol=1e-14)


def test_mirror():
    right = (BOX[:, 0] == 1).astype(float)
    moved = pose.move(BOX, (0.5, 1, 0), weights=right)
    both = pose.mirror(BOX, moved, "x", weights=right)
    np.testing.assert_array_equal(both - BOX, np.outer(BOX[:, 0], (0.5, 0, 0)) + np.outer(BOX[:, 0] != 0, (0, 1, 0)))
    # The vertices at x = 1 lie in the plane then, and the others have no image.
    with pytest.warns(UserWarning, match="mirror: 30 of 45 positions have no mirror image, and stay"):
        np.testing.assert_array_equal(pose.mirror(BOX, BOX, "x", plane=1), BOX)
    with pytest.raises(ValueError, match="axis: expected x, y or z, got 'w'"):
        pose.mirror(BOX, BOX, "w")


def test_selections_are_weights():
    np.testing.assert_array_equal(pose.select_end(BOX, "+z"), TOP)
    np.testing.assert_array_equal(pose.select_box(BOX, (-1, -1, 4), (1, 1, 4)), TOP)
    np.testing.assert_array_equal(pose.select_half_space(BOX, (0, 0, 3.5), (0, 0, 1)), TOP)
    np.testing.assert_array_equal(pose.select_numbers(BOX, np.flatnonzero(TOP)), TOP)
    np.testing.assert_array_equal(pose.select_ball(BOX, (0, 0, 5), 1.8), TOP)
    falling = pose.select_end(BOX, (0, 0, 1), falloff="smooth", falloff_radius=3.96)
    np.testing.assert_allclose(falling[BOX[:, 2] == 4], 1)
    np.testing.assert_allclose(falling[BOX[:, 2] == 0], 0)
    moved = pose.move(BOX, (1, 0, 0), weights=falling)
    np.testing.assert_allclose(moved - BOX, falling[:, None] * (1, 0, 0))


def test_selections_along_the_cells():
    # A body of 3 x 3 x 3 cubes, and a row of three cubes on it.
    lattice = espalier.shapes.merge([espalier.shapes.box((3, 3, 3), (0, 0, 0), (3, 3, 3)),
                                     espalier.shapes.box((1, 1, 3), (1, 1, 3), (2, 2, 6))])
    x, y, z = lattice.positions.T
    row = (z >= 3) & (1 <= x) & (x <= 2) & (1 <= y) & (y <= 2)
    limb = pose.select_limb(lattice, (1.5, 1.5, 6))
    np.testing.assert_array_equal(limb, row)
    np.testing.assert_allclose(pose.border(lattice, limb), (1.5, 1.5, 3))
    np.testing.assert_array_equal(pose.grow(lattice, limb, -1), row & (z > 3))
    np.testing.assert_array_equal(pose.grow(lattice, 1.0 * (z == 6), 2), z >= 4)
    np.testing.assert_array_equal(pose.select_beyond(lattice, (1.5, 1.5, 4)), z >= 4)
    np.testing.assert_array_equal(pose.select_near(lattice, (1.5, 1.5, 6), 1), z == 6)
    falling = pose.select_limb(lattice, (1.5, 1.5, 6), falloff_radius=2)
    np.testing.assert_allclose(falling[(z == 2) & (x == 1) & (y == 1)], 0.5)
    with pytest.raises(ValueError, match="the lattice has no limb at"):
        pose.select_limb(espalier.shapes.box(), (0, 0, 0))
    with pytest.raises(ValueError, match="weights has shape"):
        pose.grow(lattice, [1.0])


@pytest.mark.parametrize("call, message", [
    (lambda: pose.move(BOX, (1, np.nan, 0)), r"move: offset: expected finite numbers, got \("),
    (lambda: pose.move(BOX, (1, 0, 0), weights=[1]), "weights has shape"),
    (lambda: pose.move(BOX, (1, 0, 0), weights=2 * TOP), r"weights\[\d+\] is 2; expected 0 to 1"),
    (lambda: pose.move(BOX[:, :2], (1, 0, 0)), "positions"),
    (lambda: pose.rotate(BOX, "w", 1), "axis: expected x, y or z, or a vector, got 'w'"),
    (lambda: pose.bend(BOX, "z", 1, "z"), "toward: expected a vector that is not parallel to the axis"),
    (lambda: pose.select_ball(BOX, (0, 0, 0), -1), "select_ball: radius: expected a finite number of 0 or more, got -1"),
    (lambda: pose.select_end(BOX, "+z", falloff="steep"), "falloff"),
    (lambda: pose.select_numbers(BOX, [99]), r"select_numbers: numbers\[0\]: expected 0 to 44, got 99"),
])
def test_wrong_arguments_name_themselves(call, message):
    with pytest.raises(ValueError, match=message):
        call()
