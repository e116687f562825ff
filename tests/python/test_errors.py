# SPDX-License-Identifier: Apache-2.0
"""What is wrong is said by a ValueError, which names the argument or what the library names."""

import numpy as np
import pytest

import espalier

NAN = float("nan")


@pytest.mark.parametrize("points, text", [
    (np.zeros((4, 2)), "points: expected an array of shape (N, 3), got (4, 2)"),
    (np.zeros(3), "points: expected an array of shape (N, 3), got (3,)"),
    ([[0, 0, 0], [0, NAN, 0]], "points[1, 1] is nan; expected a finite number"),
    ([[0, 0, -np.inf]], "points[0, 2] is -inf; expected a finite number"),
    ([[0, 0, 1j]], "points: expected an array of real numbers, got complex128"),
    ([["a", "b", "c"]], "points: expected an array of real numbers, got <U1"),
    ([[True, False, True]], "points: expected an array of real numbers, got bool"),
    (None, "points: expected an array of real numbers, got object"),
    ([[0, 0], [1]], "points: expected an array of real numbers, got list"),
])
def test_points_that_are_none(rest, points, text):
    with pytest.raises(ValueError) as error:
        espalier.bind(rest, points)
    assert str(error.value) == text


@pytest.mark.parametrize("points", [
    [[0, 0, 1], [0, 0, 2]], np.array([[0, 0, 1], [0, 0, 2]], np.int8),
    np.array([[0, 0, 1], [0, 0, 2]], np.float16), np.array([[0, 0], [0, 0], [1, 2]], float).T,
    np.array([[0, 0, 1], [0, 0, 2]], ">f8"),
    np.array([[0, 9, 0, 9, 1, 9], [0, 9, 0, 9, 2, 9]], float)[:, ::2],
], ids=["list", "int8", "float16", "Fortran order", "big endian", "strides"])
def test_points_of_any_kind_are_converted(rest, points):
    binding = espalier.bind(rest, points)
    np.testing.assert_array_equal(binding.points, [[0, 0, 1], [0, 0, 2]])


def test_poses_and_gradients_of_another_shape(binding):
    for pose in (np.zeros((35, 3)), np.zeros((36, 2)), np.zeros(36), np.zeros((2, 2, 36, 3))):
        with pytest.raises(ValueError) as error:
            binding.deform(pose)
        shape = str(pose.shape)
        assert str(error.value) == ("pose: expected an array of shape (36, 3) or (P, 36, 3), got "
                                    + shape)
    with pytest.raises(ValueError, match=r"^gradients: expected .* \(500, 3\) or \(P, 500, 3\), "
                                         r"got \(36, 3\)$"):
        binding.adjoint(np.zeros((36, 3)))
    pose = np.zeros((36, 3))
    pose[7, 1] = NAN
    with pytest.raises(ValueError, match=r"^pose\[7, 1\] is nan"):
        binding.deform(pose)


@pytest.mark.parametrize("out, text", [
    (np.empty((500, 2)), "out: expected an array of shape (500, 3), got (500, 2)"),
    (np.empty((500, 3), np.float32),
     "out: expected an array of float64 in C order, got float32"),
    (np.empty((3, 500)).T, "out: expected an array of float64 in C order, got float64 in another order"),
    ([0], "out: expected an array, got list"),
])
def test_places_for_results_that_do_not_fit(binding, pose, out, text):
    with pytest.raises(ValueError) as error:
        binding.deform(pose, out=out)
    assert str(error.value) == text


def test_places_for_results_that_must_not_be_written(binding, rest, pose):
    out = np.empty((500, 3))
    out.flags.writeable = False
    with pytest.raises(ValueError, match="^out: the array is read-only$"):
        binding.deform(pose, out=out)
    buffer = np.zeros(4000)
    with pytest.raises(ValueError, match="^out: the array overlaps"):
        binding.deform(buffer[:108].reshape(36, 3), out=buffer[60:1560].reshape(500, 3))


def test_words_that_are_none(rest, points):
    with pytest.raises(ValueError) as error:
        espalier.bind(rest, points, outside="drop")
    assert str(error.value) == 'outside: expected keep, nearest or error, got "drop"'
    with pytest.raises(ValueError, match='^rules: expected siggraph96, cse96 or rats, got "x"$'):
        espalier.Refiner(rest, rules="x")
    with pytest.raises(ValueError, match="^dtype: expected float32 or float64, got int64$"):
        espalier.CompiledTable(espalier.Refiner(rest).stencils(1), dtype=int)


def test_topology_that_is_none():
    cube = espalier.shapes.box()
    with pytest.raises(ValueError, match="vertex 8"):
        espalier.Lattice(cube.positions, [[0, 1, 2, 3, 4, 5, 6, 8]])
    with pytest.raises(ValueError, match=r"^cells\[1\]: expected the 4, 5, 6 or 8 vertices"):
        espalier.Lattice(cube.positions, [range(8), range(7)])
    with pytest.raises(ValueError, match=r"^cells\[0, 2\] is 4294967296; expected a number of 32"):
        espalier.Lattice(cube.positions, np.array([[0, 1, 2**32, 3, 4, 5, 6, 7]]))
    with pytest.raises(ValueError, match="^cells: expected an array of integers, got float64$"):
        espalier.Lattice(cube.positions, cube.hexahedra.astype(float))
    with pytest.raises(ValueError, match="edge"):
        cube.with_marks(edge_sharpness={(0, 7): 1})
    with pytest.raises(ValueError, match=r"^attributes\[\"a\"\]: expected an array of shape \(8,\)"):
        espalier.Lattice(cube.positions, cube.hexahedra, attributes={"a": np.zeros(7)})


def test_the_librarys_own_errors_keep_their_text(rest, points, tmp_path):
    with pytest.raises(ValueError) as error:
        espalier.bind(rest, points + 10, outside="error")
    assert str(error.value).startswith("point 0 ")
    with pytest.raises(ValueError, match="missing.vtu: "):
        espalier.read(tmp_path / "missing.vtu")
    with pytest.raises(ValueError, match="lattice.xyz"):
        rest.write(tmp_path / "lattice.xyz")
    with pytest.raises(ValueError, match="all vertices are frozen"):
        espalier.fit(rest, espalier.bind(rest, points), 0 * points, frozen=range(36))
    with pytest.raises(ValueError, match="^level: expected 0 or more, got -1$"):
        espalier.refine(rest, -1)


def test_a_pose_of_another_lattice(binding):
    with pytest.raises(ValueError, match="^pose: the lattice has another topology"):
        binding.deform(espalier.shapes.box(cells=(2, 3, 2)))


def test_other_types_are_type_errors(rest, points):
    with pytest.raises(TypeError, match="expected a Lattice or a Refiner, got ndarray"):
        espalier.bind(rest.positions, points)
    with pytest.raises(TypeError, match="expected a StencilTable, a Binding or a sparse matrix"):
        espalier.CompiledTable(np.eye(3))


def test_one_value_error_a_cause_and_the_module_lives_on(rest, points):
    for _ in range(100):
        with pytest.raises(ValueError):
            espalier.bind(rest, points[:, :2])
    assert espalier.bind(rest, points).shape == (500, 36)
