# SPDX-License-Identifier: Apache-2.0
"""Wrong arguments raise a ValueError that names the argument, or that has the library's own text."""

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
    with pytest.raises(ValueError, match='^rules: expected siggraph96, cse96, mlca or rats, got "x"$'):
        espalier.Refiner(rest, rules="x")
    with pytest.raises(ValueError, match="^dtype: expected float32 or float64, got int64$"):
        espalier.CompiledTable(espalier.Refiner(rest).stencils(1), dtype=int)


def test_topology_that_is_none():
    cube = espalier.shapes.box()
    with pytest.raises(ValueError, match="vertex 8"):
        espalier.Lattice(cube.positions, [[0, 1, 2, 3, 4, 5, 6, 8]])
    with pytest.raises(ValueError, match=r"^cells\[1\]: expected the 4, 5, 6 or 8 vertices"):
        espalier.Lattice(cube.positions, [range(8), range(7)])
    with pytest.raises(ValueError, match=r"^cells\[0, 2\] is 4294967296; expected an integer that fits"):
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
    with pytest.raises(ValueError, match="^pose: its topology differs from the lattice that the points are bound to"):
        binding.deform(espalier.shapes.box(cells=(2, 3, 2)))


def test_other_types_are_type_errors(rest, points):
    with pytest.raises(TypeError, match="expected a Lattice or a Refiner, got ndarray"):
        espalier.bind(rest.positions, points)
    with pytest.raises(TypeError, match="expected a StencilTable, a Binding or a sparse matrix"):
        espalier.CompiledTable(np.eye(3))


@pytest.mark.parametrize("call", [
    lambda rest: espalier.Refiner(None),
    lambda rest: espalier.refine(None),
    lambda rest: espalier.ValidityCheck(None),
    lambda rest: espalier.compare(None),
    lambda rest: espalier.shapes.merge([None]),
    lambda rest: espalier.shapes.merge([rest, None]),
    lambda rest: rest.topology_difference(None),
    lambda rest: espalier.CompiledTable(None),
    lambda rest: espalier.ChangeEvaluator(None),
    lambda rest: espalier.StencilTable(None),
    lambda rest: espalier.StencilTable.csr(None),
    lambda rest: espalier.StencilTable.__getstate__(None),
    lambda rest: espalier.Lattice.__setstate__(espalier.Lattice.__new__(espalier.Lattice), None),
], ids=lambda call: None)
def test_none_is_no_object(rest, call):
    with pytest.raises(TypeError):
        call(rest)


def test_none_has_no_members_of_ours():
    seen = 0
    for name in espalier.__all__:
        each = getattr(espalier, name)
        if type(each).__name__ != "pybind11_type":
            continue
        for member, value in vars(each).items():
            if member in ("__copy__", "mesh", "curve"):
                continue
            if isinstance(value, property) or type(value).__name__ == "instancemethod":
                with pytest.raises(TypeError):
                    value.fget(None) if isinstance(value, property) else value(None)
                seen += 1
    assert seen > 60


def test_an_edge_is_marked_once(rest):
    for marks in ({(1, 0): 1, (0, 1): 2}, {(0, 1): 1, (1, 0): 1}):
        with pytest.raises(ValueError,
                           match="^edge_sharpness: the edge of vertices 0 and 1 is given twice"):
            rest.with_marks(edge_sharpness=marks)
    assert rest.with_marks(edge_sharpness={(1, 0): 1}).edge_sharpness == {(1, 0): 1}


def test_names_of_attributes_that_files_need(rest):
    values = np.zeros(len(rest.positions))
    with pytest.raises(ValueError, match=r'^attributes\["espalier:x"\]: names that begin with'):
        espalier.Lattice(rest.positions, rest.hexahedra, attributes={"espalier:x": values})
    made = espalier.Lattice(rest.positions, rest.hexahedra, attributes={"espalier": values})
    assert list(made.attributes) == ["espalier"]


@pytest.mark.parametrize("name, arguments, text", [
    ("cylinder", {"start": (1, 2, 3), "end": (1, 2, 3)},
     "cylinder: end: expected a point other than start, got (1, 2, 3)"),
    ("cylinder", {"start": (np.inf, 0, 0)},
     "cylinder: start: expected finite numbers, got (inf, 0, 0)"),
    ("torus", {"minor_radius": 2},
     "torus: minor_radius: expected a number below major_radius (1), got 2"),
    ("torus", {"grid_cells": 0}, "torus: grid_cells: expected 1 or more, got 0"),
    ("star", {"inner_radius": 0}, "star: inner_radius: expected a finite number above 0, got 0"),
    ("barbell", {"end_segments": 2}, "barbell: end_segments: expected 3 or more, got 2"),
    ("barbell", {"bar_half_width": 1},
     "barbell: bar_half_width: expected with roundness 1, a number below end_radius (1), got 1"),
    ("barbell", {"roundness": 2}, "barbell: roundness: expected 0 to 1, got 2"),
    ("arm", {"joints": [[0, 0, 0, 1], [1, 0, 0, 0]]},
     "arm: joints[1, 3]: expected a finite number above 0, got 0"),
    ("arm", {"joints": [[0, 0, 0, 1], [0, 0, 0, 1]]},
     "arm: joints[1, :3]: expected a place other than the one of the joint before, got (0, 0, 0)"),
    ("prism", {"sides": 2}, "prism: sides: expected 3 or more, got 2"),
])
def test_shapes_name_their_arguments(name, arguments, text):
    with pytest.raises(ValueError) as error:
        getattr(espalier.shapes, name)(**arguments)
    assert str(error.value) == text


def test_a_level_that_is_refined_is_wanted(rest, pose):
    for call in (lambda: espalier.ValidityCheck(rest, 0), lambda: espalier.check(rest, pose, 0),
                 lambda: espalier.Refiner(rest).level_table(0)):
        with pytest.raises(ValueError, match="^level: expected 1 or more, got 0$"):
            call()


def misaligned(array):
    """Returns a copy whose numbers are not aligned."""
    memory = np.zeros(array.nbytes + 1, np.uint8)
    result = np.frombuffer(memory, array.dtype, array.size, 1).reshape(array.shape)
    result[...] = array
    assert not result.flags.aligned
    return result


def test_arrays_that_are_not_aligned(rest, points, pose):
    binding = espalier.bind(rest, misaligned(points), level=2)
    np.testing.assert_array_equal(binding.points, points)
    np.testing.assert_array_equal(binding.deform(misaligned(pose)), binding.deform(pose))
    with pytest.raises(ValueError, match="^out: the numbers of the array are not aligned"):
        binding.deform(pose, out=misaligned(np.zeros((500, 3))))


def test_an_array_that_is_not_aligned_is_copied(rest):
    """NumPy copies the input to an aligned array, and `out` cannot overlap with the copy."""
    compiled = espalier.CompiledTable(espalier.Refiner(rest).stencils(0))
    memory = np.zeros(8 * 37, np.uint8)
    values = np.frombuffer(memory, float, 36, 1)
    values[:] = np.arange(36)
    compiled.evaluate(values, out=memory[:8 * 36].view(float))
    np.testing.assert_array_equal(memory[:8 * 36].view(float), np.arange(36))


def test_one_value_error_a_cause_and_the_module_lives_on(rest, points):
    for _ in range(100):
        with pytest.raises(ValueError):
            espalier.bind(rest, points[:, :2])
    assert espalier.bind(rest, points).shape == (500, 36)
