# SPDX-License-Identifier: Apache-2.0
import pickle
import struct
import threading
import warnings

import numpy as np
import pytest

import espalier

# The results compared are sums of up to 64 products of size 1 in different orders. They differ by a few
# units in the last place.
CLOSE = 1e-13


def test_a_binding_is_its_matrix(rest, points, binding, pose):
    matrix = binding.matrix
    assert binding.shape == matrix.shape == (500, 36)
    assert np.shares_memory(matrix.data, binding.table.weights)
    np.testing.assert_allclose(matrix.sum(axis=1), 1, atol=CLOSE)
    np.testing.assert_allclose(matrix @ rest.positions, points, atol=1e-12)  # Newton's residual
    np.testing.assert_allclose(binding.deform(pose), matrix @ pose, atol=CLOSE)
    gradients = np.random.default_rng(5).normal(size=points.shape)
    np.testing.assert_allclose(binding.adjoint(gradients), matrix.T @ gradients, atol=1e-11)
    assert not np.array_equal(binding.deform(pose), binding.deform(rest.positions))


def test_affine_maps_of_the_lattice_are_maps_of_the_points(rest, points, binding):
    linear, offset = np.random.default_rng(6).normal(size=(3, 3)), (1, 2, 3)
    np.testing.assert_allclose(binding.deform(rest.positions @ linear.T + offset),
                               points @ linear.T + offset, atol=1e-12)
    posed = rest.transformed(linear, offset)
    if np.linalg.det(linear) > 0:
        np.testing.assert_allclose(binding.deform(posed), points @ linear.T + offset, atol=1e-12)


def test_several_poses_at_once(binding, pose, rest):
    poses = np.array([pose, rest.positions, 2 * pose])
    result = binding.deform(poses)
    assert result.shape == (3, 500, 3)
    for one, each in zip(result, poses):
        np.testing.assert_array_equal(one, binding.deform(each))
    back = binding.adjoint(result)
    assert back.shape == (3, 36, 3)
    np.testing.assert_array_equal(back[2], binding.adjoint(result[2]))


def test_float32_stays_float32(binding, pose):
    single = binding.deform(pose.astype(np.float32))
    assert single.dtype == np.float32 and binding.deform(pose).dtype == np.float64
    # Results are sums of 64 products of size 3, each with a relative rounding error of 6e-8.
    np.testing.assert_allclose(single, binding.deform(pose), atol=1e-5)
    assert binding.adjoint(single).dtype == np.float32
    for order in "<>":
        np.testing.assert_array_equal(binding.deform(pose.astype(order + "f4")), single)
        assert binding.deform(pose.astype(order + "f4")).dtype == np.float32
    out = np.empty((500, 3), np.float32)
    assert binding.deform(pose.astype(np.float32), out=out) is out
    np.testing.assert_array_equal(out, single)


def test_points_outside(rest, points, pose):
    points[3] = (0, 0, 10)
    kept = espalier.bind(rest, points, level=2)
    status = espalier.PointStatus
    assert kept.kept.tolist() == [3] and kept.statuses[3] == status.OUTSIDE
    assert (np.delete(kept.statuses, 3) == status.INSIDE).all()
    assert kept.matrix[3].nnz == 0
    np.testing.assert_array_equal(kept.deform(pose)[3], (0, 0, 10))
    np.testing.assert_array_equal(kept.deform(np.stack([pose, pose]))[1, 3], (0, 0, 10))
    np.testing.assert_array_equal(kept.deform(pose.astype(np.float32))[3], (0, 0, 10))
    # Weights at this distance would sum to more than 8.
    far = espalier.bind(rest, points, level=2, outside="nearest")
    assert far.kept.tolist() == [3] and far.statuses[3] == status.OUTSIDE
    points[3] = rest.positions.max(axis=0) + (0, 0, 0.1)
    nearest = espalier.bind(rest, points, level=2, outside="nearest")
    assert len(nearest.kept) == 0 and nearest.statuses[3] == status.OUTSIDE
    np.testing.assert_allclose(nearest.deform(rest.positions + (1, 0, 0))[3],
                               points[3] + (1, 0, 0), atol=1e-12)
    points[3] = (0, 0, 10)
    wide = espalier.bind(rest, points, level=2, tolerance=0.99)
    assert nearest.largest_residual < 1e-9 <= wide.largest_residual or len(wide.kept) == 1


def test_the_lattices_that_came_before(points, rest, pose):
    bezier = espalier.bind(rest, points, basis="bezier")
    # The basis is Bernstein polynomials of degrees 2, 2 and 3. None is 0 inside.
    assert bezier.matrix.nnz == 500 * 36
    np.testing.assert_allclose(bezier.deform(rest.positions), points, atol=1e-12)
    with pytest.raises(ValueError, match="^the lattice has marks"):
        espalier.bind(rest.with_marks(vertex_sharpness={0: 0}), points, basis="bezier")


def test_the_limit_is_the_spline():
    # With boundary="open", the middle cell of three is the uniform B-spline.
    box = espalier.shapes.box(cells=(3, 3, 3), max=(3, 3, 3))
    points = 1.05 + 0.9 * np.random.default_rng(4).random((200, 3))
    spline = espalier.bind(box, points, basis="bspline").matrix
    limit = espalier.bind(espalier.Refiner(box, boundary="open"), points, limit=True).matrix
    assert abs(limit - spline).max() < 1e-13  # places are found to about 1e-15
    with pytest.raises(ValueError, match='^limit: expected False with the basis "bezier"'):
        espalier.bind(box, points, basis="bezier", limit=True)
    with pytest.raises(ValueError, match="^tolerance: expected 1e-14 to 0.1, got 0.5$"):
        espalier.bind(box, points, limit=True, tolerance=0.5)


def test_saved_and_loaded(tmp_path, rest, points, pose):
    points[3] = (0, 0, 10)
    binding = espalier.bind(rest, points, level=2)
    binding.save(tmp_path / "binding.espb")
    loaded = espalier.load_binding(tmp_path / "binding.espb")
    np.testing.assert_array_equal(loaded.deform(pose), binding.deform(pose))
    np.testing.assert_array_equal(loaded.points, points)
    assert loaded.kept.tolist() == [3]
    np.testing.assert_array_equal(loaded.statuses, binding.statuses)
    assert loaded.largest_residual == binding.largest_residual
    with pytest.raises(ValueError, match="topology"):
        loaded.deform(espalier.shapes.box())
    (tmp_path / "binding.espb").write_bytes((tmp_path / "binding.espb").read_bytes()[:-1])
    with pytest.raises(ValueError, match="binding.espb"):
        espalier.load_binding(tmp_path / "binding.espb")


def test_a_file_of_an_older_version_is_refused(tmp_path, binding):
    path = tmp_path / "old.espb"
    binding.save(path)
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack("<I", 4) + content[12:])
    with pytest.raises(ValueError, match="old.espb: is a bound model of version 4, .*: bind the model again"):
        espalier.load_binding(path)


def test_what_a_pose_leaves_alone_stays_as_it_was(tmp_path, rest, points):
    points = np.concatenate([points, [(0, 0, 10)]])
    made = espalier.bind(rest, points, level=2)
    made.save(tmp_path / "bound.espb")
    moved = rest.positions.copy()
    moved[0] -= 1
    # In float32, smaller weights do not change a coordinate of size 1.
    columns = made.matrix[:, [0]].toarray()[:, 0] != 0
    assert 0 < columns.sum() < len(points)
    for binding in [made, espalier.load_binding(tmp_path / "bound.espb"),
                    pickle.loads(pickle.dumps(made))]:
        for dtype in (np.float64, np.float32):  # float32 holds the lattice exactly
            at_rest = points.astype(dtype)
            poses = np.stack([rest.positions, moved]).astype(dtype)
            first, second = binding.deform(poses)
            np.testing.assert_array_equal(first, at_rest)
            np.testing.assert_array_equal((second != at_rest).any(axis=1), columns)


def test_the_rest_pose_in_float32_leaves_all_points_as_they_were():
    # float32 can hold neither 0.1 nor 1000.1, so a pose must be compared with the rest in float32.
    rest = espalier.shapes.box(min=(0.1, 0.1, 999.1), max=(1.1, 1.1, 1000.1), cells=(2, 2, 2))
    assert (rest.positions.astype(np.float32) != rest.positions).any()
    points = np.random.default_rng(8).uniform((.2, .2, 999.2), (1, 1, 1000), (200, 3))
    for limit in False, True:
        binding = espalier.bind(rest, points, limit=limit)
        np.testing.assert_array_equal(binding.deform(rest.positions.astype(np.float32)),
                                      points.astype(np.float32))
        np.testing.assert_array_equal(binding.deform(rest.positions), points)


def test_a_model_with_normals_keeps_its_gradients(tmp_path, rest, points):
    lines = ["v {} {} {}".format(*p.tolist()) for p in points]
    (tmp_path / "plain.obj").write_text("\n".join([*lines, ""]))
    (tmp_path / "model.obj").write_text("\n".join([*lines, "vn 0 0 1", "f 1//1 2//1 3//1", ""]))
    model = espalier.read_model(tmp_path / "model.obj")
    first, copy = tmp_path / "first.espb", tmp_path / "copy.espb"
    for binding, has_gradients in [(espalier.bind(rest, model, limit=True), 1),
                                   (espalier.bind(rest, model), 1),
                                   (espalier.bind(rest, model, gradients=False), 0),
                                   (espalier.bind(rest, espalier.read_model(tmp_path / "plain.obj"),
                                                  limit=True), 0)]:
        binding.save(first)
        assert first.read_bytes()[8] == 8  # the version
        assert first.read_bytes()[12] == has_gradients
        for other in [espalier.load_binding(first), pickle.loads(pickle.dumps(binding))]:
            other.save(copy)
            assert copy.read_bytes() == first.read_bytes()


def test_directions_that_stay_are_told(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n")
    model = espalier.read_model(tmp_path / "a.obj")
    moved = model.positions + [0, 0, 1]
    with pytest.warns(UserWarning, match="a.obj: 1 normal, tangent or splat stays as in the file"):
        model.write(tmp_path / "b.obj", moved)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.write(tmp_path / "c.obj", moved, gradients=False)
        model.write(tmp_path / "d.obj", moved, np.tile(np.eye(3), (3, 1, 1)))
        model.write(tmp_path / "e.obj", model.positions)
    assert (tmp_path / "b.obj").read_text() == (tmp_path / "c.obj").read_text()


def test_weights_multiply_displacements(tmp_path, rest, points, pose):
    weights = np.linspace(0, 1, len(points))
    full, binding = espalier.bind(rest, points), espalier.bind(rest, points, weights=weights)
    expected = points + weights[:, None] * (full.deform(pose) - points)
    np.testing.assert_allclose(binding.deform(pose), expected, atol=CLOSE)
    np.testing.assert_allclose(binding.matrix.sum(axis=1).ravel(), [weights], atol=CLOSE)
    assert binding.statuses[0] == espalier.PointStatus.NOT_BOUND and 0 in binding.kept
    for wrong, message in [(weights[1:], r"shape \(500,\)"), (2 * weights, "point 250 is"), ("red", "need a Model")]:
        with pytest.raises(ValueError, match=message):
            espalier.bind(rest, points, weights=wrong)
    with pytest.raises(ValueError, match="need a Model"):
        espalier.bind(rest, points, only=["head"])


def test_a_falloff_carries_points_outside():
    box = espalier.shapes.box(cells=(2, 2, 2))
    points = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 1.25], [0.5, 0.5, 1.5], [9, 9, 9]])
    binding = espalier.bind(box, points, falloff=0.5, gradients=True)
    lifted = binding.deform(box.positions + [0, 0, 1])
    np.testing.assert_allclose(lifted - points, [[0, 0, 1], [0, 0, 0.5], [0, 0, 0], [0, 0, 0]], atol=CLOSE)
    assert binding.statuses.tolist() == [0, 1, 3, 3]
    # The displacement falls by 1.5 / 0.5 in the middle.
    np.testing.assert_allclose(binding.gradients(box.positions + [0, 0, 1])[1], np.diag([1, 1, -2]), atol=1e-12)
    with pytest.raises(ValueError, match="leave out one of the two"):
        espalier.bind(box, points, falloff=0.5, outside="error")


def test_a_part_of_a_model_follows(tmp_path):
    text = ("v .1 .1 .5 1 0 0\nv .9 .1 .5 .5 0 0\nv .9 .9 .5 .25 0 0\nv .1 .9 .5 0 0 0\n"
            "vn 0 0 1\ng a\nf 1//1 2//1 3//1\ng b\nf 1//1 3//1 4//1\n")
    (tmp_path / "two.obj").write_text(text)
    model = espalier.read_model(tmp_path / "two.obj")
    assert model.attributes == ["red", "green", "blue"] and model.groups == ["a", "b"]
    np.testing.assert_array_equal(model.attribute("red"), [1, 0.5, 0.25, 0])
    with pytest.raises(ValueError, match="has no attribute 'bend'"):
        model.attribute("bend")
    box = espalier.shapes.box(cells=(2, 2, 2))
    up = box.positions + [0, 0, 1]
    for options, expected in [({"only": ["b"]}, [1, 0, 1, 1]), ({"weights": "red", "only": ["b"]}, [1, 0, 0.25, 0]),
                              ({"weights": [0, 1, 0.5, 1], "only": ["b"]}, [0, 0, 0.5, 1])]:
        binding = espalier.bind(box, model, **options)
        np.testing.assert_allclose(binding.deform(up)[:, 2] - 0.5, expected, atol=CLOSE)
        for other in [pickle.loads(pickle.dumps(binding))]:
            np.testing.assert_array_equal(other.gradients(up), binding.gradients(up))
    # The weight of point 1 falls by 0.625 along x in the only triangle with it: the surface slopes, and its normal
    # too. F = 1 + (0, 0, 1) (slope)^T.
    binding = espalier.bind(box, model, weights="red")
    np.testing.assert_allclose(binding.gradients(up)[1], [[1, 0, 0], [0, 1, 0], [-0.625, -0.3125, 1]], atol=1e-12)
    # The same from points of one's own has no faces, and so no slope.
    binding = espalier.bind(box, model.positions, weights=model.attribute("red"), gradients=True)
    np.testing.assert_allclose(binding.gradients(up)[1], np.eye(3), atol=1e-12)


# For an affine pose F is the matrix of the pose, at each level, in the limit and under each basis.
def test_gradients_turn_the_normals_of_a_model(tmp_path, rest, points):
    matrix = np.array([[0.0, -2.0, 0.0], [1.0, 0.0, 0.5], [0.0, 0.0, 1.0]])
    for options in {"level": 2}, {"limit": True}, {"basis": "bezier"}:
        binding = espalier.bind(rest, points, outside="nearest", gradients=True, **options)
        gradients = binding.gradients(rest.positions @ matrix.T)
        assert gradients.shape == (500, 3, 3)
        np.testing.assert_allclose(gradients, np.broadcast_to(matrix, (500, 3, 3)), atol=1e-12)
    with pytest.raises(ValueError, match="the binding has no gradients"):
        espalier.bind(rest, points).gradients(rest.positions)

    lines = ["v {} {} {}".format(*p.tolist()) for p in points]
    (tmp_path / "model.obj").write_text("\n".join([*lines, "vn 1 0 0", "f 1//1 2//1 3//1", ""]))
    model = espalier.read_model(tmp_path / "model.obj")
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = np.asarray(model.positions) @ turn.T
    model.write(tmp_path / "turned.obj", moved, np.broadcast_to(turn, (500, 3, 3)))
    assert "vn 0 1 0" in (tmp_path / "turned.obj").read_text()
    model.write(tmp_path / "kept.obj", moved)
    assert "vn 1 0 0" in (tmp_path / "kept.obj").read_text()
    # A shear of the plane z = 0 along x turns the normal x, and the tangent y.
    shear = np.array([[[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]])
    np.testing.assert_allclose(espalier.carry_normals(shear, [[1, 0, 0]]),
                               [[0.5 ** 0.5, -0.5 ** 0.5, 0]], atol=1e-15)
    np.testing.assert_allclose(espalier.carry_tangents(shear, [[0, 3, 0]]),
                               [[3 * 0.5 ** 0.5, 3 * 0.5 ** 0.5, 0]], atol=1e-15)
    for wrong in np.zeros((500, 9)), np.zeros((499, 3, 3)):
        with pytest.raises(ValueError, match=r"^gradients: expected an array of shape \(500, 3, 3\)"):
            model.write(tmp_path / "wrong.obj", moved, wrong)


def test_gradients_turn_gaussian_splats(tmp_path, rest):
    names = "x y z scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()
    numbers = np.array([[0.1, 0.2, 0.3, -1, -2, -3, 2, 0, 0, 0]])
    header = "".join(["ply\nformat binary_little_endian 1.0\nelement vertex 1\n",
                      *(f"property double {name}\n" for name in names), "end_header\n"]).encode()
    (tmp_path / "splats.ply").write_bytes(header + numbers.tobytes())
    model = espalier.read_model(tmp_path / "splats.ply")
    binding = espalier.bind(rest, model)  # splats need gradients
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    pose = rest.positions @ turn.T
    model.write(tmp_path / "turned.ply", binding.deform(pose), binding.gradients(pose))
    turned = np.frombuffer((tmp_path / "turned.ply").read_bytes()[len(header):])
    # A quarter turn around z, of the length 2.
    np.testing.assert_allclose(turned, [-0.2, 0.1, 0.3, -1, -2, -3, 2 ** 0.5, 0, 0, 2 ** 0.5],
                               atol=1e-12)


def test_a_binding_of_nothing(tmp_path, rest, pose):
    nothing = espalier.bind(rest, np.empty((0, 3)))
    nothing.save(tmp_path / "nothing.espb")
    loaded = espalier.load_binding(tmp_path / "nothing.espb")
    assert loaded.shape == (0, 36) and loaded.points.shape == (0, 3)
    assert loaded.deform(pose).shape == (0, 3)


def test_models(tmp_path, rest, points, pose):
    lines = ["# kept", *("v {} {} {}".format(*p.tolist()) for p in points), "f 1 2 3", ""]
    (tmp_path / "model.obj").write_text("\n".join(lines))
    model = espalier.read_model(tmp_path / "model.obj")
    assert model.name == "model.obj"
    np.testing.assert_array_equal(model.positions, points)
    binding = espalier.bind(rest, model, level=2)
    model.write(tmp_path / "deformed.obj", binding.deform(pose))
    written = (tmp_path / "deformed.obj").read_text().splitlines()
    assert written[0] == "# kept" and written[-1] == "f 1 2 3"
    np.testing.assert_array_equal(espalier.read_model(tmp_path / "deformed.obj").positions,
                                  binding.deform(pose))
    binding.save(tmp_path / "model.espb")
    np.testing.assert_array_equal(espalier.load_binding(tmp_path / "model.espb").points, points)
    with pytest.raises(ValueError, match="^positions: expected an array of shape \\(500, 3\\)"):
        model.write(tmp_path / "deformed.obj", points[1:])


def test_models_are_written_in_other_formats(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\n")
    model = espalier.read_model(tmp_path / "a.obj")
    with pytest.warns(UserWarning, match="b.ply: the .obj has data that are not written: texture "
                                         "coordinates$"):
        model.write(tmp_path / "b.ply", model.positions + 1)
    np.testing.assert_array_equal(espalier.read_model(tmp_path / "b.ply").positions,
                                  model.positions + 1)
    # A warning that is an error leaves no file.
    with warnings.catch_warnings(), pytest.raises(UserWarning):
        warnings.simplefilter("error")
        model.write(tmp_path / "c.ply", model.positions)
    assert not (tmp_path / "c.ply").exists()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        espalier.read_model(tmp_path / "b.ply").write(tmp_path / "d.vtk", model.positions)
    assert (tmp_path / "d.vtk").read_text().endswith("POLYGONS 1 5\n4 0 1 2 3\n")
    (tmp_path / "cloud.obj").write_text("v 0 0 0\n")
    with pytest.raises(ValueError, match="a .stl consists of triangles, and the model has no faces"):
        espalier.read_model(tmp_path / "cloud.obj").write(tmp_path / "e.stl", [(0, 0, 0)])


def test_what_a_model_has_beyond_its_format_is_a_warning(tmp_path):
    note = r"kept 1 line whose first word no OBJ has ('foo' in line 2)"
    (tmp_path / "a.obj").write_text("v 0 0 0\nfoo bar\n")
    with pytest.warns(UserWarning) as warned:
        model = espalier.read_model(tmp_path / "a.obj")
    assert [str(each.message) for each in warned] == [f"{tmp_path / 'a.obj'}: {note}"]
    assert model.notes == [note]
    (tmp_path / "b.obj").write_text("v 0 0 0\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert espalier.read_model(tmp_path / "b.obj").notes == []


def test_one_binding_for_many_threads(binding, pose, rest, points):
    fresh = espalier.bind(rest, points, level=2)  # not compiled yet
    wanted, failures = binding.deform(pose), []

    def work():
        for _ in range(50):
            if not np.array_equal(fresh.deform(pose), wanted):
                failures.append("differs")

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures


def test_results_do_not_depend_on_the_number_of_threads(rest, points, pose):
    with espalier.ThreadLimit(1) as limit:
        alone = espalier.bind(rest, points, level=3)
        with pytest.raises(ValueError, match="in use"):
            limit.__enter__()
    together = espalier.bind(rest, points, level=3)
    assert (alone.matrix != together.matrix).nnz == 0
    np.testing.assert_array_equal(alone.deform(pose), together.deform(pose))
    with pytest.raises(ValueError, match="^threads: expected 0 or more, got -1$"):
        espalier.ThreadLimit(-1)


def test_more_memory_than_a_limit_allows_is_a_memory_error(rest, points):
    with espalier.MemoryLimit(1), pytest.raises(MemoryError, match="the limit is 1 B"):
        espalier.shapes.box(cells=(100, 100, 100))
    with espalier.MemoryLimit(1) as limit:
        with pytest.raises(MemoryError, match="the limit is 1 B"):
            espalier.bind(rest, points, level=3)
        with pytest.raises(ValueError, match="in use"):
            limit.__enter__()
    espalier.bind(rest, points, level=3)
    with pytest.raises(ValueError, match="^bytes: expected 1 or more, got 0$"):
        espalier.MemoryLimit(0)
