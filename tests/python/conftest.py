# SPDX-License-Identifier: Apache-2.0
"""Fixtures that the tests share: a lattice, a pose of it, points inside it, and their binding."""

import numpy as np
import pytest

import espalier


@pytest.fixture
def rest():
    return espalier.shapes.box(cells=(2, 2, 3), min=(-1, -1, 0), max=(1, 1, 3))


@pytest.fixture
def points():
    return np.random.default_rng(1).uniform((-0.9, -0.9, 0.1), (0.9, 0.9, 2.9), (500, 3))


@pytest.fixture
def pose(rest):
    return rest.positions + np.random.default_rng(2).normal(0, 0.1, rest.positions.shape)


@pytest.fixture
def binding(rest, points):
    return espalier.bind(rest, points, level=2)
