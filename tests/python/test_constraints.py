# SPDX-License-Identifier: Apache-2.0
"""espalier.constraints against formulas of NumPy, by the complex step: f(x + ih) = f(x) + ih f'(x) + O(h^2), without
cancellation. (tests/solve/constraints_test.cpp has the values, the errors and differences.)"""

import numpy as np
import pytest

import espalier

constraints = espalier.constraints
STEP = 1e-200
RANDOM = np.random.default_rng(3)
SKIN = espalier.shapes.box(cells=(2, 2, 2), min=(-1, -1, -1), max=(1, 1, 1))
# The faces of a box as triangles, anticlockwise seen from outside: from the middle of the cells they are
# anticlockwise, too.
TRIANGLES = []
for face in SKIN.boundary_faces:
    a, b, c, d = SKIN.faces[face]
    normal = np.cross(SKIN.positions[b] - SKIN.positions[a], SKIN.positions[c] - SKIN.positions[a])
    loop = (a, b, c, d) if normal @ SKIN.positions[a] > 0 else (a, d, c, b)
    TRIANGLES += [[loop[0], loop[1], loop[2]], [loop[0], loop[2], loop[3]]]
TRIANGLES = np.array(TRIANGLES)
POINTS = SKIN.positions + 0.2 * RANDOM.normal(size=SKIN.positions.shape)
CROSSINGS = constraints.crossings(SKIN.positions, TRIANGLES, [[0.3, 0.1, 0], [0, 0.2, 0.1]], [[0, 0, 1], [1, 0.2, 0]])


def length(vectors):
    return np.sqrt((vectors * vectors).sum(axis=-1))


def volume(points):
    a, b, c = points[TRIANGLES[:, 0]], points[TRIANGLES[:, 1]], points[TRIANGLES[:, 2]]
    return (a * np.cross(b, c)).sum(keepdims=True).ravel()[:1] / 6


def area(points):
    a, b, c = points[TRIANGLES[:, 0]], points[TRIANGLES[:, 1]], points[TRIANGLES[:, 2]]
    return length(np.cross(b - a, c - a)).sum().reshape(1) / 2


def curvatures(points):
    a, b, c = points[LINE[:-2]], points[LINE[1:-1]], points[LINE[2:]]
    return 2 * length(np.cross(b - a, c - b)) / (length(b - a) * length(c - b) * length(c - a))


def planarity(points):
    arms = points[SOME] - points[SOME].mean(axis=0)
    moments = arms.T @ arms / len(SOME)
    # The smallest root of the characteristic polynomial, by Newton's method from a root for the real part.
    trace, determinant = np.trace(moments), np.linalg.det(moments)
    minors = (trace**2 - np.trace(moments @ moments)) / 2
    root = np.linalg.eigvalsh(moments.real)[0] + 0j
    for _ in range(4):
        value = root**3 - trace * root**2 + minors * root - determinant
        root -= value / (3 * root**2 - 2 * trace * root + minors)
    return np.array([root])


LINE, SOME, PAIRS = [0, 1, 4, 13, 22], [0, 1, 2, 3, 5], [[0, 5], [26, 3]]
MEASURES = {
    "distances": (lambda p: constraints.distances(p, PAIRS),
                  lambda p: length(p[[5, 3]] - p[[0, 26]])),
    "thicknesses": (lambda p: constraints.thicknesses(p, CROSSINGS),
                    lambda p: length((CROSSINGS.csr() @ p)[::2] - (CROSSINGS.csr() @ p)[1::2])),
    "volume": (lambda p: constraints.volume(p, TRIANGLES), volume),
    "area": (lambda p: constraints.area(p, TRIANGLES), area),
    "curvatures": (lambda p: constraints.curvatures(p, LINE), curvatures),
    "planarity": (lambda p: constraints.planarity(p, SOME), planarity),
}


def by_complex_step(formula, points):
    columns = []
    for column in range(points.size):
        moved = points.astype(complex)
        moved.flat[column] += 1j * STEP
        columns.append(formula(moved).imag / STEP)
    return np.transpose(columns)


@pytest.mark.parametrize("name", [name for name in MEASURES if name != "planarity"])
def test_derivatives_are_those_of_the_complex_step(name):
    measure, formula = MEASURES[name]
    values, derivatives = measure(POINTS)
    np.testing.assert_allclose(values, formula(POINTS).real, rtol=1e-13)
    np.testing.assert_allclose(derivatives.csr().toarray(), by_complex_step(formula, POINTS), atol=1e-13)


def test_planarity():
    # numpy.linalg.det() pivots, so that a step of 1e-200 would vanish.
    values, derivatives = constraints.planarity(POINTS, SOME)
    np.testing.assert_allclose(values, planarity(POINTS).real, rtol=1e-10)
    central = []
    for column in range(POINTS.size):
        ends = []
        for step in (-2e-3, -1e-3, 1e-3, 2e-3):
            moved = POINTS.copy()
            moved.flat[column] += step
            ends.append(constraints.planarity(moved, SOME)[0][0])
        central.append((ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / 12e-3)
    np.testing.assert_allclose(derivatives.csr().toarray()[0], central, atol=1e-9)


@pytest.mark.parametrize("name", MEASURES)
def test_derivatives_by_the_lattice(name):
    """G (D x I3) and G J, against differences of the measures of deformed points, to 1e-9."""
    lattice = espalier.shapes.box(cells=(3, 3, 3), min=(-2, -2, -2), max=(2, 2, 2))
    binding = espalier.bind(lattice, SKIN.positions, level=2)
    pose = lattice.positions + 0.3 * RANDOM.normal(size=lattice.positions.shape)
    measure = MEASURES[name][0]
    _, by_points = measure(binding.matrix @ pose)
    by_vertices = constraints.by_vertices(by_points, binding).csr().toarray()
    direction = RANDOM.normal(size=pose.shape)
    h = 1e-3
    a, b, c, d = (measure(binding.matrix @ (pose + k * h * direction))[0] for k in (-2, -1, 1, 2))
    # The largest derivatives are some tens; the error is h^4 / 30 times a fifth derivative.
    np.testing.assert_allclose(by_vertices @ direction.ravel(), (a - 8 * b + 8 * c - d) / (12 * h), rtol=1e-8, atol=1e-9)
    # Each row is also Dᵀ times the gradient by the points.
    gradient = by_points.csr().toarray()[0].reshape(-1, 3)
    np.testing.assert_allclose(by_vertices[0].reshape(-1, 3), binding.adjoint(gradient), atol=1e-14)
    design = espalier.DesignVariables(len(pose))
    design.freeze(np.arange(10))
    jacobian = espalier.jacobian(binding, design.matrix())
    by_variables = constraints.by_variables(by_points, jacobian).csr().toarray()
    np.testing.assert_allclose(by_variables, by_vertices @ design.matrix().csr().toarray(), atol=1e-14)


def test_lattices_themselves_have_measures():
    # The volume of a box of 2 x 2 x 2, scaled by 1.5 along x.
    scaled = espalier.pose.scale(SKIN.positions, (1.5, 1, 1))
    assert constraints.volume(scaled, TRIANGLES)[0] == pytest.approx(12)


def test_wrong_arguments():
    with pytest.raises(ValueError, match=r"^triangles: expected .*\(F, 3\)"):
        constraints.volume(POINTS, [[0, 1, 2, 3]])
    with pytest.raises(ValueError, match="^the surface is not closed: the triangles at the edge from point"):
        constraints.volume(POINTS, TRIANGLES[1:])
    with pytest.raises(ValueError, match=r"^line_directions: expected an array of shape \(1, 3\), got \(2, 3\)"):
        constraints.crossings(POINTS, TRIANGLES, [[0, 0, 0]], [[0, 0, 1], [1, 0, 0]])
    with pytest.raises(ValueError, match="^pair 1: there is no point 27; there are 27, numbered from 0"):
        constraints.distances(POINTS, [[0, 1], [3, 27]])
