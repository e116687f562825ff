# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

import espalier


@pytest.fixture
def model(tmp_path):
    """Two cubes beside each other, as a .vtu."""
    espalier.shapes.box(cells=(2, 1, 1), min=(0, 0, 0), max=(2, 1, 1)).write(tmp_path / "mesh.vtu")
    return espalier.read_model(tmp_path / "mesh.vtu")


def test_cells_are_checked(model):
    check = espalier.MeshCheck(model)
    assert check.cell_count == 2 and check.not_checked == {} and len(check.bad_at_rest) == 0
    moved = model.positions * (1, 1, 0.5)
    np.testing.assert_allclose(check.check(moved).ratios, [0.5, 0.5], rtol=1e-12)
    assert check.largest_step(moved).length == 1
    moved = model.positions * (1, 1, -1)
    assert list(check.check(moved).inverted) == [0, 1]
    assert check.check(moved).smallest[1] == pytest.approx(-1, rel=1e-12)
    # The volume is 1 - 2t.
    assert check.largest_step(moved).length == pytest.approx(0.5, rel=1e-10)
    assert check.largest_step(model.positions * (1, 1, 0.9), most=20).length == pytest.approx(10, rel=1e-10)


def test_quality_has_the_definitions_of_openfoam(model):
    quality = espalier.MeshCheck(model).quality(model.positions)
    assert quality == {"scaled_jacobian": 1, "non_orthogonality": 0, "mean_non_orthogonality": 0,
                       "severely_non_orthogonal": 0, "beyond_right_angle": 0, "skewness": pytest.approx(0, abs=1e-15),
                       "smallest_volume": pytest.approx(1, rel=1e-15),
                       "non_positive_volumes": 0, "negative_pyramids": 0}
    # Sheared by 45 degrees, the centres lie on a line along (1, 0, 1), and the face between has the normal (1, 0, 0).
    sheared = model.positions @ np.array([[1, 0, 1], [0, 1, 0], [0, 0, 1]])
    assert espalier.MeshCheck(model).quality(sheared)["non_orthogonality"] == pytest.approx(45, rel=1e-7)


def test_errors(model, tmp_path):
    check = espalier.MeshCheck(model)
    with pytest.raises(ValueError, match="points"):
        check.check(model.positions[:-1])
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(ValueError, match="a.obj has no cells$"):
        espalier.MeshCheck(espalier.read_model(tmp_path / "a.obj"))
    (tmp_path / "q.mesh").write_text(
        "MeshVersionFormatted 2\nDimension 3\nVertices 10\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n.5 0 0 0\n.5 .5 0 0\n"
        "0 .5 0 0\n0 0 .5 0\n.5 0 .5 0\n0 .5 .5 0\nTetrahedraP2 1\n1 2 3 4 5 6 7 8 9 10 0\n"
        "TetrahedraP2Ordering 10\n4 0 0 0\nEnd\n")
    with pytest.raises(ValueError, match="q.mesh has 1 cells of third order and above or of an unknown order of "
                                         "points, which cannot be checked, and no other cells"):
        espalier.MeshCheck(espalier.read_model(tmp_path / "q.mesh"))


def test_elements_of_unknown_types_are_counted(tmp_path):
    (tmp_path / "a.su2").write_text("NDIME= 3\nNELEM= 2\n10 0 1 2 3\n22 0 1 2 3\nNPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n")
    check = espalier.MeshCheck(espalier.read_model(tmp_path / "a.su2"))
    assert (check.cell_count, check.not_checked) == (1, {"elements of unknown types": 1})


def test_a_pose_is_shortened_until_it_is_valid(model):
    check = espalier.MeshCheck(model)
    moved = model.positions * (1, 1, -1)
    points, share = check.shorten(moved)
    assert share == pytest.approx(0.5, rel=1e-10)
    np.testing.assert_allclose(points, model.positions * (1, 1, 1 - 2 * share), atol=1e-12)
    assert check.check(points).inverted.size == 0
    # The solver's criterion is searched within 1e-3, and never beyond what it accepts.
    points, share = check.shorten(moved, criterion="solver")
    assert 0.499 < share < 0.5 and check.solver_errors(points) == 0
    # Both cells have a negative volume, and the format is not OpenFOAM's.
    assert check.solver_errors(moved) == 2
    assert check.shorten(model.positions, criterion="solver")[1] == 1
    with pytest.raises(ValueError, match="criterion"):
        check.shorten(moved, criterion="other")


def write_pipe(path):
    """Two layers of hexahedra in a quarter of a pipe: 16 sides would go around it."""
    angles = np.linspace(0, np.pi / 2, 5)
    points = np.array([(r * np.cos(a), r * np.sin(a), z) for z in (0, 0.5, 1) for r in (1, 2) for a in angles])
    at = np.arange(30).reshape(3, 2, 5)
    cells, hull, low = [], [], []
    for k in range(2):
        for i in range(4):
            corners = [(k + c, b, i + a) for c in (0, 1) for b, a in ((0, 0), (1, 0), (1, 1), (0, 1))]
            cells.append([12, *(at[c] for c in corners)])
            hull.append([9, at[k, 1, i], at[k, 1, i + 1], at[k + 1, 1, i + 1], at[k + 1, 1, i]])
    for i in range(4):
        low.append([9, at[0, 0, i], at[0, 1, i], at[0, 1, i + 1], at[0, 0, i + 1]])

    def rows(numbers):
        return "".join(" ".join(map(str, row)) + "\n" for row in numbers)
    path.write_text(f"NDIME= 3\nNELEM= {len(cells)}\n{rows(cells)}NPOIN= 30\n{rows(points.tolist())}NMARK= 2\n"
                    f"MARKER_TAG= hull\nMARKER_ELEMS= {len(hull)}\n{rows(hull)}"
                    f"MARKER_TAG= low\nMARKER_ELEMS= 4\n{rows(low)}")
    return espalier.read_model(path)


def test_points_of_patches_slide(tmp_path):
    model = write_pipe(tmp_path / "pipe.su2")
    sliding = espalier.SlidingPoints(model, ["hull", "low"])
    (kind, origin, direction, radius), = sliding.shapes["hull"]
    assert (kind, direction, sliding.point_count) == ("cylinder", [0, 0, 1], 20)
    np.testing.assert_allclose([*origin[:2], radius], [0, 0, 2], atol=1e-14)
    assert sliding.shapes["low"][0][0] == "plane"
    pose = model.positions + np.random.default_rng(1).uniform(-0.1, 0.1, (30, 3))
    points, distance = sliding.slide(pose)
    hull = np.hypot(*model.positions[:, :2].T) > 1.5
    low = model.positions[:, 2] == 0
    np.testing.assert_allclose(np.hypot(*points[hull, :2].T), 2, rtol=1e-15)
    assert np.all(points[low, 2] == 0)
    np.testing.assert_array_equal(points[~hull & ~low], pose[~hull & ~low])
    np.testing.assert_array_equal(points[hull & ~low, 2], pose[hull & ~low, 2])
    assert distance == pytest.approx(np.linalg.norm(points - pose, axis=1).max(), rel=1e-12)
    points, distance = sliding.slide(model.positions)
    np.testing.assert_array_equal(points, model.positions)
    assert distance == 0
    with pytest.raises(ValueError, match="has no group 'x' of points; it has 'hull', 'low'"):
        espalier.SlidingPoints(model, ["x"])
    with pytest.raises(ValueError, match="points"):
        sliding.slide(pose[1:])


def test_points_of_patches_are_held(tmp_path):
    model = write_pipe(tmp_path / "pipe.su2")
    rest = espalier.shapes.box(cells=(2, 2, 2), min=(-1, -1, -1), max=(3, 3, 3))
    binding = espalier.bind(rest, model, hold=["low"])
    assert list(binding.kept) == list(range(10))
    pose = rest.positions + (0, 0, 1)
    points = binding.deform(pose)
    np.testing.assert_array_equal(points[:10], model.positions[:10])
    np.testing.assert_allclose(points[10:], model.positions[10:] + (0, 0, 1), atol=1e-14)
    with pytest.raises(ValueError, match="weights, only, hold: names need a Model"):
        espalier.bind(rest, model.positions, hold=["low"])
