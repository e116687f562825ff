# SPDX-License-Identifier: Apache-2.0
import gc

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

import espalier


@pytest.fixture
def table(rest):
    return espalier.Refiner(rest).stencils(2)


def test_levels_compose(rest):
    refiner = espalier.Refiner(rest)
    first, second = refiner.level_table(1).csr(), refiner.level_table(2).csr()
    composed = refiner.stencils(2).csr()
    assert composed.shape == (refiner.counts(2)[0], 36)
    # The entries are sums of a few tens of products of weights of size 1.
    assert abs(second @ first - composed).max() < 1e-14
    np.testing.assert_allclose(composed @ rest.positions, refiner.positions(2), atol=1e-14)
    np.testing.assert_allclose(composed.sum(axis=1), 1, atol=1e-14)
    assert (refiner.stencils(0).csr() != scipy.sparse.eye(36)).nnz == 0


def test_some_rows_of_a_level(rest, table):
    rows = [5, 3, 5]
    some = espalier.Refiner(rest).stencils(2, vertices=rows).csr()
    assert (some != table.csr()[rows]).nnz == 0


def test_csr_shares_the_memory_of_the_table(table):
    matrix = table.csr()
    assert isinstance(matrix, scipy.sparse.csr_matrix)
    assert np.shares_memory(matrix.data, table.weights)
    assert np.shares_memory(matrix.indices, table.columns)
    assert matrix.data.ctypes.data == table.weights.ctypes.data
    assert matrix.indices.dtype == matrix.indptr.dtype == np.int32
    np.testing.assert_array_equal(matrix.indptr, table.offsets)
    assert table.offsets.dtype == np.int64 and table.nnz == matrix.nnz
    for array in (matrix.data, matrix.indices):
        assert not array.flags.writeable


def test_csr_keeps_the_table_alive(rest):
    matrix = espalier.bind(rest, [[0, 0, 1]]).matrix
    wanted = matrix.toarray()
    gc.collect()
    _ = [np.full(1000, 7.0) for _ in range(1000)]  # would overwrite freed memory
    np.testing.assert_array_equal(matrix.toarray(), wanted)
    np.testing.assert_allclose(wanted.sum(), 1)


def test_scipy_takes_the_matrix_for_its_own(table, rest):
    matrix = table.csr()
    dense = matrix.toarray()
    assert matrix.has_sorted_indices and matrix.has_canonical_format
    np.testing.assert_allclose((matrix.T @ matrix).toarray(), dense.T @ dense, atol=1e-13)
    np.testing.assert_array_equal(matrix[10:20, ::2].toarray(), dense[10:20, ::2])
    np.testing.assert_array_equal(matrix.tocsc().toarray(), dense)
    np.testing.assert_array_equal((2 * matrix - matrix).toarray(), dense)
    # S has full column rank, so least squares recover the lattice.
    found = scipy.sparse.linalg.lsqr(matrix, matrix @ rest.positions[:, 2], atol=1e-14, btol=1e-14)
    np.testing.assert_allclose(found[0], rest.positions[:, 2], atol=1e-9)


def test_tables_from_scipy():
    coordinates = ([2, 0, 0, 2], [1, 3, 0, 1])
    matrix = scipy.sparse.coo_matrix(([1.0, 2.0, 3.0, 4.0], coordinates), shape=(3, 4))
    table = espalier.StencilTable(matrix)
    assert table.shape == (3, 4)
    np.testing.assert_array_equal(table.offsets, [0, 2, 2, 3])
    np.testing.assert_array_equal(table.columns, [0, 3, 1])
    np.testing.assert_array_equal(table.weights, [3, 2, 5])  # duplicates are added
    assert matrix.nnz == 4  # unchanged
    np.testing.assert_array_equal(table.transpose().csr().toarray(), matrix.toarray().T)


def broken_matrices():
    def broken(form, name, values, shape=(3, 3)):
        matrix = getattr(scipy.sparse, form + "_matrix")(np.eye(*shape))
        array = getattr(matrix, name)
        setattr(matrix, name, np.array(values, array.dtype))
        return matrix

    yield broken("csr", "indptr", [0, 2, 1, 3]), r"indptr[2] is 1; expected 2 or more"
    yield broken("csr", "indptr", [0, 5, -3, 0]), r"indptr[2] is -3; expected 5 or more"
    yield broken("csr", "indptr", [1, 1, 2, 3]), r"indptr[0] is 1; expected 0"
    yield broken("csr", "indptr", [0, 1, 2, 1 << 20]), r"indices: expected 1048576 entries, got 3"
    yield broken("csr", "indptr", [0, 1, 2]), r"indptr: expected 4 entries, got 3"
    yield broken("csr", "indices", [0, 3, 1]), r"indices[1] is 3; expected 0 to 2"
    yield broken("csr", "indices", [0, -1, 1]), r"indices[1] is -1; expected 0 to 2"
    yield broken("csr", "data", [1, 1]), r"indptr[3] is 3; expected 2 at most, which data has"
    yield broken("csc", "indptr", [0, 2, 1, 3]), r"indptr[2] is 1; expected 2 or more"
    yield broken("csc", "indices", [0, 1 << 20, 1]), r"indices[1] is 1048576; expected 0 to 2"
    yield broken("bsr", "indptr", [0, 2, 1, 3]), r"indptr[2] is 1; expected 2 or more"
    yield broken("coo", "row", [0, 1 << 20, 1]), r"row[1] is 1048576; expected 0 to 2"
    yield broken("coo", "col", [0, 1]), r"col: expected 3 entries, got 2"


@pytest.mark.parametrize("matrix, text", broken_matrices())
def test_matrices_that_scipy_would_write_out_of_bounds_for(matrix, text):
    with pytest.raises(ValueError) as error:
        espalier.StencilTable(matrix)
    assert str(error.value) == text


@pytest.mark.parametrize("form", ["csr", "csc", "bsr", "coo", "lil", "dok", "dia"])
def test_matrices_of_every_format(form):
    dense = np.arange(24.0).reshape(4, 6) % 5
    matrix = getattr(scipy.sparse, form + "_matrix")(dense)
    np.testing.assert_array_equal(espalier.StencilTable(matrix).csr().toarray(), dense)
    empty = getattr(scipy.sparse, form + "_matrix")((2, 3))
    assert espalier.StencilTable(empty).shape == (2, 3)


@pytest.mark.parametrize("dtype, bound", [(np.float64, 1e-13), (np.float32, 1e-5)])
@pytest.mark.parametrize("shape", [(36,), (36, 1), (36, 3), (36, 7), (4, 36, 3), (0, 36, 3)])
def test_compiled_tables_give_the_product(table, dtype, bound, shape):
    # Rows have up to 64 entries of size 1. The bound is a few hundred units in the last place.
    values = np.random.default_rng(3).normal(size=shape)
    compiled = espalier.CompiledTable(table, dtype=dtype)
    result = compiled.evaluate(values)
    wanted = np.einsum("rv,...vk->...rk" if len(shape) > 1 else "rv,v->r",
                       table.csr().toarray(), values)
    assert result.dtype == compiled.dtype == dtype and result.shape == wanted.shape
    np.testing.assert_allclose(result, wanted, atol=bound)
    adjoint = espalier.CompiledAdjoint(table, dtype=dtype)
    assert adjoint.shape == compiled.shape[::-1]
    np.testing.assert_allclose(
        adjoint.evaluate(wanted),
        np.einsum("rv,...rk->...vk" if len(shape) > 1 else "rv,r->v",
                  table.csr().toarray(), wanted), atol=1000 * bound)  # columns of 500 entries


def test_results_go_where_they_are_wanted(table):
    compiled = espalier.CompiledTable(table)
    values = np.random.default_rng(4).normal(size=(2, 36, 3))
    out = np.full((2, table.shape[0], 3), np.nan)
    assert compiled.evaluate(values, out=out) is out
    np.testing.assert_array_equal(out, compiled.evaluate(values))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(36,), (36, 3), (2, 36, 3)])
def test_only_what_has_changed_is_evaluated_again(table, dtype, shape):
    compiled = espalier.CompiledTable(table, dtype=dtype)
    evaluator = espalier.ChangeEvaluator(compiled)
    assert evaluator.shape == table.shape and evaluator.dtype == dtype and evaluator.nbytes > 0
    values = np.random.default_rng(5).normal(size=shape).astype(dtype)
    out = compiled.evaluate(values)
    changed, axis = [35, 0, 35], len(shape) == 3
    values[(slice(None),) * axis + (changed,)] += 1
    wanted = compiled.evaluate(values)
    assert evaluator.evaluate_changed(values, changed, out) is out
    np.testing.assert_array_equal(out, wanted)

    rows = evaluator.rows(changed)
    assert rows.dtype == np.int32
    dense = table.csr().toarray()
    np.testing.assert_array_equal(rows, np.flatnonzero((dense[:, changed] != 0).any(axis=1)))
    assert 0 < len(rows) < table.shape[0]
    out[...] = np.nan
    evaluator.evaluate_changed(values, changed, out=out)
    written = ~np.isnan(out).any(axis=2) if len(shape) == 3 else ~np.isnan(out)
    assert set(np.nonzero(written)[axis]) == set(rows)
    before = out.copy()
    evaluator.evaluate_changed(values, np.empty(0, int), out)
    np.testing.assert_array_equal(out, before)


def test_changes_that_are_none(table):
    evaluator = espalier.ChangeEvaluator(espalier.CompiledTable(table))
    out = np.zeros((table.shape[0], 3))
    for call in (evaluator.rows, lambda c: evaluator.evaluate_changed(np.ones((36, 3)), c, out)):
        with pytest.raises(ValueError, match="^changed: there is no column 36; there are 36, "):
            call([3, 36])
        with pytest.raises(ValueError, match="^changed: expected an array of integers"):
            call([0.5])
    with pytest.raises(ValueError, match="^out: expected an array, got NoneType$"):
        evaluator.evaluate_changed(np.ones((36, 3)), [0], None)
    assert (out == 0).all()


@pytest.mark.parametrize("extension", ["mtx", "npz"])
def test_tables_are_written(tmp_path, table, extension):
    import scipy.io
    path = tmp_path / f"table.{extension}"
    table.write(path)
    read = scipy.io.mmread if extension == "mtx" else scipy.sparse.load_npz
    assert (read(path) != table.csr()).nnz == 0


def test_rules_and_boundaries(rest):
    usual = espalier.Refiner(rest)
    assert usual.rules == "siggraph96"
    assert abs(usual.stencils(2).csr()
               - espalier.Refiner(rest, rules="cse96").stencils(2).csr()).max() == 0  # regular
    star = espalier.shapes.star(layers=2)
    assert abs(espalier.Refiner(star).stencils(2).csr()
               - espalier.Refiner(star, rules="cse96").stencils(2).csr()).max() > 1e-3
    mlca = espalier.Refiner(star, rules="mlca")
    assert mlca.rules == "mlca"
    assert abs(mlca.stencils(2).csr()
               - espalier.Refiner(star, rules="cse96").stencils(2).csr()).max() > 1e-3
    with pytest.raises(ValueError, match="MLCA do not have smooth triangles"):
        espalier.Refiner(rest, rules="mlca", triangles="smooth")
    opened = espalier.Refiner(espalier.shapes.box(cells=(3, 3, 3)), boundary="open")
    assert np.ptp(opened.positions(3), axis=0).max() < 0.5  # the region shrinks to a third
    with pytest.raises(ValueError, match="RATS"):
        espalier.Refiner(rest, rules="rats")


def test_strata_and_counts(rest):
    refiner = espalier.Refiner(rest)
    strata = refiner.strata(0)
    assert strata.dtype == np.uint8
    # A box of 2 x 2 x 3 cells has 8 corners, 1 or 2 vertices inside each of its 12 edges and 6 sides,
    # and 2 vertices in the interior.
    assert np.bincount(strata).tolist() == [8, 4 * 1 + 4 * 1 + 4 * 2, 2 * 1 + 4 * 2, 1 * 1 * 2]
    assert refiner.counts(1) == (5 * 5 * 7, *espalier.refine(rest).counts[1:])
    with pytest.raises(ValueError, match="^dimension: expected 0 to 3, got 4$"):
        refiner.strata(0, 4)


def test_refining_twice_is_refining_by_two_levels(rest):
    lattice = rest.with_marks(edge_sharpness={(0, 1): 1.5}, vertex_sharpness={8: 0})
    at_once = espalier.refine(lattice, 2)
    in_steps = espalier.refine(espalier.refine(lattice))
    assert at_once.topology_difference(in_steps) is None
    # The second step starts from rounded positions.
    np.testing.assert_allclose(at_once.positions, in_steps.positions, atol=1e-14)


def test_the_tables_of_a_refiner_do_not_change_when_it_goes_deeper(rest):
    refiner = espalier.Refiner(rest)
    first = refiner.positions(1)
    refiner.counts(3)
    np.testing.assert_array_equal(refiner.positions(1), first)
