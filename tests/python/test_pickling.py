# SPDX-License-Identifier: Apache-2.0
"""Pickled objects come back the same, bit for bit."""

import copy
import pickle

import numpy as np
import pytest

import espalier
from espalier import shapes

CUBE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]


def again(value):
    return pickle.loads(pickle.dumps(value))


def assert_same_arrays(one, other):
    for name in one:
        assert one[name].dtype == other[name].dtype and one[name].shape == other[name].shape
        assert one[name].tobytes() == other[name].tobytes()


def everything_of(lattice):
    return (lattice.dimension, lattice.counts, lattice.faces, lattice.cells,
            lattice.edge_sharpness, lattice.vertex_sharpness, lattice.tags,
            list(lattice.attributes), lattice.texture_corners)


def arrays_of(lattice):
    return {"positions": lattice.positions, "edges": lattice.edges,
            "boundary": lattice.boundary_faces, "textures": lattice.texture_coordinates,
            **lattice.attributes}


@pytest.mark.parametrize("lattice", [
    shapes.box(cells=(2, 1, 3)),
    espalier.Lattice(np.array(CUBE) / 3, [range(8)], edge_sharpness={(1, 0): 2.5, (4, 5): np.inf},
                     vertex_sharpness={3: 0, 1: 1e-300},
                     attributes={"a": np.arange(8) / 7, "ü": np.eye(8)[:, :2] * -0.0}),
    *(getattr(shapes, name)() for name in shapes.__all__ if name not in ("around", "cage", "collar", "merge")),
    espalier.refine(shapes.star(core="polygon"), 2),
    espalier.Lattice.mesh(CUBE, [[0, 3, 2, 1], [0, 1, 5, 4], [4, 5, 6]], holes=[1]),
    espalier.Lattice.mesh(CUBE, [[0, 1, 2], [0, 1, 3], [1, 0, 4]]),  # three faces on an edge
    espalier.Lattice.mesh(CUBE, [[0, 1, 2], [0, 2, 3]], texture_coordinates=np.eye(7)[:, :2] / 3,
                          texture_corners=[[0, 1, 2], [6, 5, 3]]),
    espalier.refine(espalier.Refiner(
        espalier.Lattice.mesh(CUBE, [[0, 3, 2, 1]], texture_coordinates=np.eye(4)[:, :2],
                              texture_corners=[[0, 1, 2, 3]]), face_varying="none")),
    espalier.refine(espalier.Refiner(espalier.Lattice.mesh(CUBE, [[0, 3, 2, 1]]),
                                     boundary="edge-only", creasing="chaikin",
                                     triangles="smooth")),
    espalier.Lattice.curve(CUBE, closed=True),
], ids=repr)
def test_lattices(lattice):
    for other in (again(lattice), pickle.loads(pickle.dumps(lattice, protocol=5))):
        assert everything_of(other) == everything_of(lattice)
        assert_same_arrays(arrays_of(other), arrays_of(lattice))
        # Refined lattices also depend on marks, holes, tags and attributes.
        assert_same_arrays(arrays_of(espalier.refine(other)), arrays_of(espalier.refine(lattice)))
        assert pickle.dumps(other) == pickle.dumps(lattice)


def test_tables(rest):
    names = "offsets", "columns", "weights"
    for table in (espalier.Refiner(rest).stencils(2), espalier.Refiner(rest).stencils(2, []),
                  espalier.DesignVariables(4).matrix()):
        other = again(table)
        assert other.shape == table.shape
        assert_same_arrays({name: getattr(table, name) for name in names},
                           {name: getattr(other, name) for name in names})


def assert_same_binding(one, other, pose):
    assert one.shape == other.shape and one.largest_residual == other.largest_residual
    names = "kept", "points", "statuses"
    assert_same_arrays({name: getattr(one, name) for name in names},
                       {name: getattr(other, name) for name in names})
    np.testing.assert_array_equal(one.deform(pose), other.deform(pose))


def test_bindings(tmp_path, rest, points, pose):
    points[3] = (0, 0, 10)
    binding = espalier.bind(rest, points, level=2)
    other = again(binding)
    assert_same_binding(binding, other, pose)
    assert other.statuses[3] == espalier.PointStatus.OUTSIDE and other.kept.tolist() == [3]
    with pytest.raises(ValueError, match="topology"):
        other.deform(shapes.box())
    for name, each in (("one", binding), ("other", other)):
        each.save(tmp_path / name)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()
    loaded = espalier.load_binding(tmp_path / "one")
    assert_same_binding(loaded, again(loaded), pose)
    nothing = espalier.bind(rest, np.empty((0, 3)))
    assert_same_binding(nothing, again(nothing), pose)


def test_a_copy_is_the_object_itself(rest, binding):
    for each in (rest, binding, binding.table):
        assert copy.copy(each) is each
        assert copy.deepcopy([each, each])[1] is each


@pytest.mark.parametrize("change", [
    lambda state: state[:4],
    lambda state: (state[0][:-1], *state[1:]),
    lambda state: (state[0], state[1][:2] + [(3, *state[1][2][1:])], *state[2:]),
    lambda state: (state[0], state[1][:2] + [(6, state[1][2][1] + 7, state[1][2][2])], *state[2:]),
    lambda state: (state[0], state[1][:2] + [(6, *state[1][2][1:2], -2 * state[1][2][2])],
                   *state[2:]),
    lambda state: (*state[:3], [("a", 2, np.zeros(8))], state[4]),
], ids=["parts", "positions", "rows", "faces", "signs", "attributes"])
def test_a_lattice_that_is_none(change):
    cube = shapes.box()
    blank = espalier.Lattice.__new__(espalier.Lattice)
    with pytest.raises(ValueError):
        blank.__setstate__(change(cube.__getstate__()))


def test_a_table_that_is_none(binding):
    blank = espalier.StencilTable.__new__(espalier.StencilTable)
    columns, offsets, *rest = binding.table.__getstate__()
    with pytest.raises(ValueError):
        blank.__setstate__((columns, offsets[::-1], *rest))


@pytest.mark.parametrize("change", [lambda state: (state[0][:-1],), lambda state: (state[0][:-1] + b"x",),
                                    lambda state: (b"",), lambda state: (None,), lambda state: (), lambda state: 2 * state],
                         ids=["truncated", "another checksum", "empty", "no bytes", "nothing", "twice"])
def test_a_damaged_binding(binding, change):
    blank = espalier.Binding.__new__(espalier.Binding)
    with pytest.raises((ValueError, OSError, TypeError, RuntimeError)):
        blank.__setstate__(change(binding.__getstate__()))


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_all_protocols(protocol):
    lattice = shapes.box(cells=(2, 1, 1))
    binding = espalier.bind(lattice, lattice.positions[:2], level=1)
    for value in lattice, binding, binding.table:
        other = pickle.loads(pickle.dumps(value, protocol))
        assert type(other) is type(value) and repr(other) == repr(value)
    for value in espalier.Refiner(lattice), espalier.Lattice.__new__(espalier.Lattice):
        with pytest.raises(TypeError):
            pickle.dumps(value, protocol)
