# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
import scipy.sparse

import espalier


def test_held_vertices_stay_in_fits_pulls_and_poses():
    box = espalier.shapes.box((2, 2, 2), (0, 0, 0), (2, 2, 2))
    lattice = espalier.shapes.collar(box, layers=2, reach=1.0)
    np.testing.assert_array_equal(lattice.positions[:27], box.positions)
    assert len(lattice.held) == 7**3 - 27 and lattice.held.min() == 27
    assert len(box.held) == 0
    deformation = espalier.bind(lattice, [[0.2, 0.2, 0.2], [1, 1, 1.2]])
    misses = [[0, 0, 0.1], [0, 0.1, 0]]
    free = espalier.fit(lattice, deformation, misses, move_held=True)
    assert np.any(free.displacements[lattice.held] != 0)
    pull = espalier.RigidPull(lattice, deformation)
    for found in (espalier.fit(lattice, deformation, misses), pull.solve(misses)):
        assert np.all(found.displacements[lattice.held] == 0)
        assert np.any(found.displacements != 0)
    assert set(lattice.held) <= set(pull.fixed)
    every = espalier.RigidPull(lattice, deformation, reach=1.0, move_held=True)
    assert len(every.fixed) == 0
    weights = espalier.pose.without_held(lattice)
    assert np.flatnonzero(weights == 0).tolist() == lattice.held.tolist()
    half = espalier.pose.without_held(lattice, np.full(343, 0.5))
    np.testing.assert_array_equal(half, weights / 2)
    with pytest.raises(ValueError, match="there are 0 weights"):
        espalier.pose.without_held(lattice, [])


def test_collars_and_planes_of_symmetry():
    box = espalier.shapes.box((2, 2, 2), (0, 0, 0), (2, 2, 2))
    collar = espalier.shapes.collar(box, layers=1, until=[(-1, -2, -3), (4, 5, 6)], open=["z", "-x"])
    assert collar.positions.min(axis=0).tolist() == [0, -2, 0]
    assert collar.positions.max(axis=0).tolist() == [4, 5, 2]
    with pytest.raises(ValueError, match="open: expected an axis"):
        espalier.shapes.collar(box, reach=1.0, open="up")
    points = [[0, 0, 0], [1, 2, 3]]
    assert espalier.shapes.around(points, symmetry="y").positions[:, 1].min() == 0
    assert espalier.shapes.around(points, symmetry="z", symmetry_at=3.0).positions[:, 2].max() == 3
    with pytest.raises(ValueError, match="symmetry: expected x, y or z"):
        espalier.shapes.around(points, symmetry="up")


def test_fitting_finds_the_pose_back(rest, points, binding, pose):
    fit = espalier.fit(rest, binding, binding.deform(pose) - points)
    # The tolerance is the condition number times the rounding of the sums.
    assert 1 < fit.condition < 1e5
    np.testing.assert_allclose(rest.positions + fit.displacements, pose,
                               atol=fit.condition * 1e-13)
    assert fit.largest_miss < 1e-11 and 0 < fit.rms_miss <= fit.largest_miss


@pytest.mark.parametrize("form", [lambda b: b, lambda b: b.table, lambda b: b.matrix],
                         ids=["binding", "table", "csr_matrix"])
def test_fitting_some_rows_with_vertices_held(rest, binding, form):
    frozen = np.flatnonzero(rest.positions[:, 2] == 0)
    fit = espalier.fit(rest, form(binding), [[0.1, 0, 0], [0, 0, 0.1]], rows=[17, 4],
                       frozen=frozen, smoothing="laplacian", strength=1e-2)
    assert (fit.displacements[frozen] == 0).all()
    moved = binding.matrix @ fit.displacements
    np.testing.assert_allclose(moved[[17, 4]], [[0.1, 0, 0], [0, 0, 0.1]],
                               atol=fit.largest_miss + 1e-13)
    assert fit.largest_miss < 0.05
    with pytest.raises(ValueError, match="^rows: there is no row 500; there are 500, numbered from 0$"):
        espalier.fit(rest, form(binding), [[0, 0, 0]], rows=[500])


def test_targets_that_leave_vertices_open(rest, binding):
    assert espalier.fit(rest, binding, [[0.1, 0, 0]], rows=[0]).condition == np.inf
    with pytest.raises(ValueError, match="leave vertex"):
        espalier.fit(rest, binding, [[0.1, 0, 0]], rows=[0], undetermined="refuse")


def test_a_reference_axis_carries_vertices(rest):
    axis = espalier.ReferenceAxis(rest.positions, [[0.1, 0.2, 0], [0.1, 0.2, 3]], link="across", direction=(0, 0, 2))
    assert axis.at_rest.shape == (2, 11)
    np.testing.assert_allclose(axis.feet, rest.positions * (0, 0, 1) + (0.1, 0.2, 0), atol=1e-15)
    values = axis.at_rest
    values[1, 6] = 0.5
    twisted = espalier.pose.twist(rest.positions, "z", 0.5, center=(0.1, 0.2, 0))
    np.testing.assert_allclose(axis.positions(values), twisted, atol=1e-14)
    # The derivatives by the values and by the rest, in a direction.
    random = np.random.default_rng(8)
    step, moves, h = random.normal(size=(2, 11)), random.normal(size=(len(rest.positions) + 2, 3)), 1e-6
    nodes = axis.at_rest[:, :3]

    def at(t):
        moved = axis.moved_to(rest.positions + t * moves[:-2], nodes + t * moves[-2:])
        return moved.positions(values + t * step).ravel()
    expected = axis.matrix(values).csr() @ step.ravel() + axis.rest_matrix(values).csr() @ moves.ravel()
    np.testing.assert_allclose((at(h) - at(-h)) / (2 * h), expected, atol=1e-8)
    with pytest.raises(ValueError, match=r"^values: expected shape \(2, 11\), got shape \(22, 2\)"):
        axis.positions(np.zeros((22, 2)))
    with pytest.raises(ValueError, match="^link: expected nearest, along or across, got"):
        espalier.ReferenceAxis(rest.positions, nodes, link="far")


def test_pulls_keep_cells_rigid(rest, points, binding):
    pull = espalier.RigidPull(rest, binding, rows=[17, 4, 200], reach=1)
    assert len(pull.fixed) == 0
    pose = pull.solve(np.tile([0.3, -0.2, 0.1], (3, 1)))
    np.testing.assert_allclose(pose.displacements, np.tile([0.3, -0.2, 0.1], (36, 1)), atol=1e-9)
    assert pose.largest_miss < 1e-9 and pose.rms_miss < 1e-9 and pose.energy < 1e-9 and pose.iterations >= 1
    pull = espalier.RigidPull(rest, binding, rows=[17, 4], pins=[1], frozen=[0])
    assert 0 in pull.fixed
    pose = pull.solve([[0.1, 0, 0.1], [0, 0, 0]])
    again = pull.solve([[0.1, 0, 0.1], [0, 0, 0]], start=pose.displacements)
    np.testing.assert_allclose(again.displacements, pose.displacements, atol=1e-3)
    np.testing.assert_allclose((binding.matrix @ pose.displacements)[[17, 4]], [[0.1, 0, 0.1], [0, 0, 0]], atol=1e-6)
    assert not pose.meets_barrier
    assert pull.solve([[0, 0, -3], [0, 0, 0]]).meets_barrier or pull.solve([[0, 0, 3], [0, 0, 0]]).meets_barrier
    with pytest.raises(ValueError, match="^rows: there is no row 500"):
        espalier.RigidPull(rest, binding, rows=[500])
    with pytest.raises(ValueError, match="max_iterations: expected 1 or more, got 0"):
        espalier.RigidPull(rest, binding, max_iterations=0)


def test_design_variables(rest, points, binding):
    design = espalier.DesignVariables(36)
    design.freeze(np.flatnonzero(rest.positions[:, 2] == 0))
    design.freeze(35, axis=1)
    design.mirror(rest.positions, axis=0)
    design.scale(34, 2.0, axis=2)
    b = design.matrix().csr()
    assert b.shape[0] == 108
    displacements = (b @ np.ones(b.shape[1])).reshape(36, 3)
    assert (displacements[:9] == 0).all()
    mirror = rest.positions * (-1, 1, 1)
    image = [int(np.flatnonzero((rest.positions == p).all(axis=1))[0]) for p in mirror]
    np.testing.assert_array_equal(displacements[image], displacements * (-1, 1, 1))
    assert displacements[35, 1] == 0 and displacements[34, 2] == 2
    jacobian = espalier.jacobian(binding, design.matrix()).csr()
    assert jacobian.shape == (1500, b.shape[1])
    wanted = scipy.sparse.kron(binding.matrix, scipy.sparse.eye(3)) @ b
    assert abs(jacobian - wanted).max() < 1e-14
    with pytest.raises(ValueError, match="36"):
        design.freeze([36])


def test_poses_that_fold(rest):
    check = espalier.ValidityCheck(rest, level=1)
    valid = check.check(2 * rest.positions)
    np.testing.assert_allclose(valid.ratios, 8, rtol=2e-3)  # lower bounds, at most 0.1 % too small
    assert len(valid.inverted) == 0 and valid.smallest[1] == valid.ratios.min()
    # Halfway to the mirror image, all cells are flat.
    mirrored = rest.positions * (-1, 1, 1)
    assert len(check.check(mirrored).inverted) == 96
    step = check.largest_step(mirrored)
    assert step.length == pytest.approx(0.5, abs=1e-4) and step.is_tight
    assert 0 <= check.base_cell(step.limiting_cell) < 12
    assert check.largest_step(2 * rest.positions, most=3).limiting_cell is None
    assert len(espalier.check(rest, mirrored, level=1).inverted) == 96
    with pytest.raises(ValueError, match="^cell: expected 0 to 95, got 96$"):
        check.base_cell(96)


def test_limits_that_fold():
    # The inner vertices of the bar, at x = 1 and x = 2, each move by a towards the other ones. The
    # ratio in the middle of the limit is then 1 - 5a/4 (tests/solve/limit_validity_test.cpp).
    bar = espalier.shapes.box(cells=(3, 1, 1), max=(3, 1, 1))
    pinched = bar.positions.copy()
    pinched[bar.positions[:, 0] == 1, 0] += 1
    pinched[bar.positions[:, 0] == 2, 0] -= 1
    check = espalier.ValidityCheck(bar, level=1, limit=True)
    folded = check.check(pinched)
    assert len(folded.ratios) == 3 and folded.inverted.tolist() == [1]
    assert folded.smallest[1] == pytest.approx(-0.25, abs=1e-3)
    step = check.largest_step(pinched)
    assert step.length == pytest.approx(0.8, abs=1e-5) and step.limiting_cell == 1
    assert check.base_cell(1) == 1
    assert espalier.check(bar, pinched, limit=True).inverted.tolist() == [1]


def test_cells_that_are_bad_at_rest_have_no_ratio():
    box = espalier.shapes.box(cells=(2, 1, 1))
    folded = box.positions.copy()
    folded[box.positions[:, 0] == 1, 0] = 0.25  # the second of the two cells is inverted
    check = espalier.ValidityCheck(box.with_positions(folded), level=1)
    bad = check.bad_at_rest
    assert 0 < len(bad) < 16
    ratios = check.check(folded).ratios
    assert np.flatnonzero(np.isnan(ratios)).tolist() == bad.tolist()


def test_what_is_held_stays(rest, points, binding):
    side = [face for face in rest.boundary_faces
            if (rest.positions[rest.faces[face]][:, 2] == 0).all()]
    assert len(side) == 4
    np.testing.assert_array_equal(espalier.hold(rest, faces=side, continuity="c0"), range(9))
    np.testing.assert_array_equal(espalier.hold(rest, faces=side), range(18))
    low = points[points[:, 2] < 0.5]
    held = espalier.hold(rest, points=low, level=2)
    moved = rest.positions + 1.0
    moved[held] = rest.positions[held]
    still = espalier.bind(rest, low, level=2).deform(moved)
    np.testing.assert_allclose(still, low, atol=1e-9)  # the bound in continuity.h
    with pytest.raises(ValueError, match="^hold: expected faces, points, or both$"):
        espalier.hold(rest)


def test_a_lattice_in_a_lattice(rest, points, binding, pose):
    parent = espalier.shapes.box(min=(-2, -2, -1), max=(2, 2, 4))
    nested = espalier.nest(binding, pose, parent, level=2)
    assert nested.shape == (500, 8)
    child = binding.deform(pose)
    np.testing.assert_allclose(nested.csr() @ parent.positions, child, atol=1e-12)
    turned = parent.positions[:, [1, 0, 2]] * (-1, 1, 1)
    np.testing.assert_allclose(nested.csr() @ turned, child[:, [1, 0, 2]] * (-1, 1, 1),
                               atol=1e-12)
    with pytest.raises(ValueError, match="vertex"):
        espalier.nest(binding, pose, parent.transformed(np.eye(3) / 9), level=2)


def test_sections_along_an_axis(rest, points):
    sections = espalier.SectionVariables(rest.positions, [0.0, 1.5, 3.0])
    values = sections.at_rest
    np.testing.assert_array_equal(values, [0, 1, 0, 0, 0] * 3)
    np.testing.assert_allclose(sections.positions(values), rest.positions, atol=1e-15)
    values[0::5] = [0, 0.5, 1]
    np.testing.assert_allclose(sections.positions(values),
                               espalier.pose.twist(rest.positions, "z", 1.0, center=(0, 0, 0)),
                               atol=1e-14)
    # One step of a gradient method: the points move as the Jacobian says.
    binding = espalier.bind(rest, points)
    jacobian = espalier.jacobian(binding, sections.matrix(values)).csr()
    step = 1e-7 * np.random.default_rng(1).normal(size=15)
    moved = binding.deform(sections.positions(values + step))
    np.testing.assert_allclose((moved - binding.deform(sections.positions(values))).ravel(),
                               jacobian @ step, atol=1e-12)
    with pytest.raises(ValueError, match="there are 3 values; expected 15"):
        sections.positions([0, 1, 0])
