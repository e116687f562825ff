#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Matrices that `espalier stencils` writes, read by SciPy, NumPy and a reader for PETSc.

    export_test.py PATH_OF_ESPALIER
"""

import sys
import unittest

import numpy
import scipy.io
import scipy.sparse

import program
from program import CliTest, icosphere_points


def petsc_matrix(path, integer):
    """A matrix in PETSc's binary format, as its manual describes it."""
    data = path.read_bytes()
    size = numpy.dtype(integer).itemsize
    kind, rows, columns, entries = numpy.frombuffer(data, integer, 4)
    assert kind == 1211216
    lengths = numpy.frombuffer(data, integer, rows, 4 * size)
    indices = numpy.frombuffer(data, integer, entries, (4 + rows) * size)
    weights = numpy.frombuffer(data, ">f8", entries, (4 + rows + entries) * size)
    assert len(data) == (4 + rows + entries) * size + 8 * entries
    offsets = numpy.concatenate([[0], numpy.cumsum(lengths)])
    return scipy.sparse.csr_matrix((weights.astype(float), indices.astype(int), offsets),
                                   shape=(rows, columns))


class Export(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "cylinder", "--from", 0.5, 0.5, -0.5, "--to", 0.5, 0.5, 1.5,
                         "-o", "c.ovm")

    def write(self, *arguments):
        return self.run_program("stencils", "c.ovm", *arguments).stdout

    def assert_same(self, matrix, expected):
        """Checks that matrices have the same entries, bit for bit."""
        self.assertEqual(matrix.shape, expected.shape)
        self.assertEqual(matrix.nnz, expected.nnz)
        self.assertEqual((matrix != expected).nnz, 0)

    def npz(self, name):
        return scipy.sparse.load_npz(self.path / name)

    def test_every_format_holds_the_same_matrix(self):
        for name in ["s.mtx", "s.npz", "s.npy", "s.petsc"]:
            self.write("-n", 2, "-o", name)
        self.write("-n", 2, "--petsc-indices", 64, "-o", "s64.petsc")
        expected = self.npz("s.npz")
        self.assertEqual(expected.format, "csr")
        self.assertEqual((expected.dtype, expected.indices.dtype), (float, numpy.int32))
        self.assertTrue(expected.has_canonical_format)
        numpy.testing.assert_allclose(expected.sum(axis=1), 1, rtol=0, atol=1e-15)
        self.assert_same(scipy.io.mmread(self.path / "s.mtx").tocsr(), expected)
        self.assert_same(petsc_matrix(self.path / "s.petsc", ">i4"), expected)
        self.assert_same(petsc_matrix(self.path / "s64.petsc", ">i8"), expected)
        arrays = [numpy.load(self.path / f"s.{name}.npy", mmap_mode="r")
                  for name in ["data", "indices", "indptr"]]
        self.assert_same(scipy.sparse.csr_matrix(tuple(arrays), shape=expected.shape), expected)

    def test_rows_are_in_the_order_of_refine(self):
        self.write("-n", 2, "-o", "s.npz")
        self.run_program("refine", "c.ovm", "-n", 2, "-o", "r.ovm")
        base, refined = (numpy.array(self.read_ovm_positions(name)) for name in ["c.ovm", "r.ovm"])
        numpy.testing.assert_allclose(self.npz("s.npz") @ base, refined, rtol=0, atol=1e-15)

    def test_level_tables_multiply_to_the_whole(self):
        out = self.write("-n", 3, "--level-tables", "-o", "r%d.npz")
        self.assertEqual(len(out.splitlines()), 3)
        self.write("-n", 3, "-o", "s.npz")
        product = self.npz("r3.npz") @ self.npz("r2.npz") @ self.npz("r1.npz")
        # The entries are sums of up to some hundred products, each rounded.
        self.assertLess(abs(product - self.npz("s.npz")).max(), 1e-14)
        self.write("-n", 1, "--level-tables", "-o", "one.mtx")
        self.assertTrue((self.path / "one.mtx").exists())

    def test_level_tables_that_are_one_file_are_refused(self):
        (self.path / "r2.npz").symlink_to("r1.npz")
        self.assertIn("r2.npz: is the same file as r1.npz, through a link",
                      self.error_of("stencils", "c.ovm", "-n", 2, "--level-tables", "-o",
                                    "r%d.npz"))
        self.assertFalse((self.path / "r1.npz").exists())

    def test_points_give_the_deformation_matrix(self):
        points = icosphere_points(50) + [(9, 9, 9)]
        self.write_model(points)
        self.write("-n", 2, "--points", "model.obj", "-o", "d.npz")
        matrix = self.npz("d.npz")
        base = numpy.array(self.read_ovm_positions("c.ovm"))
        self.assertEqual(matrix.shape, (51, len(base)))
        # At rest the product gives the points; the point outside has an empty row.
        numpy.testing.assert_allclose((matrix @ base)[:50], points[:50], rtol=0, atol=1e-14)
        self.assertEqual(matrix[50].nnz, 0)
        # deform moves the points in the same way.
        pose = base * [1, 1.5, 1] + [0, 0, 0.25]
        self.write_positions("pose.ovm", "c.ovm", pose)
        self.deform("model.obj", "c.ovm", "pose.ovm", "-n", 2, out="moved.obj")
        numpy.testing.assert_allclose((matrix @ pose)[:50], self.read_points("moved.obj")[:50],
                                      rtol=0, atol=1e-14)
        # With --outside nearest, the nearest cell moves a point that is not too far away.
        near = points[:50] + [(1.2, 0, 0.5), (9, 9, 9)]
        self.write_model(near)
        self.write("-n", 2, "--points", "model.obj", "--outside", "nearest", "-o", "n.npz")
        numpy.testing.assert_allclose((self.npz("n.npz") @ base)[:51], near[:51], rtol=0, atol=1e-12)
        self.assertEqual(self.npz("n.npz")[51].nnz, 0)

    def bent(self, rest):
        base = numpy.array(self.read_ovm_positions(rest))
        x, y, z = base.T
        return base, base + numpy.array([0.3 * z * z, -0.2 * x * z, 0.1 * x * y]).T

    def test_the_limit_is_that_of_deform(self):
        points = icosphere_points(50) + [(9, 9, 9)]
        self.write_model(points)
        base, pose = self.bent("c.ovm")
        self.write_positions("pose.ovm", "c.ovm", pose)
        self.deform("model.obj", "c.ovm", "pose.ovm", "--limit", out="moved.obj")
        moved = self.read_points("moved.obj")
        for name in ["d.npz", "d.mtx"]:
            out = self.write("--points", "model.obj", "--limit", "-o", name)
            self.assertEqual(len(out.splitlines()), 1)
        matrix = self.npz("d.npz")
        self.assertIn("D in the limit: rows are the points of model.obj", self.text("d.mtx"))
        self.assert_same(scipy.io.mmread(self.path / "d.mtx").tocsr(), matrix)
        numpy.testing.assert_allclose((matrix @ base)[:50], points[:50], rtol=0, atol=1e-14)
        numpy.testing.assert_allclose((matrix @ pose)[:50], moved[:50], rtol=0, atol=1e-14)
        self.assertEqual(matrix[50].nnz, 0)
        # The limit differs from every level.
        self.write("--points", "model.obj", "-n", 3, "-o", "level.npz")
        self.assertGreater(abs((self.npz("level.npz") - matrix) @ pose).max(), 1e-5)

    def test_gradients_of_the_limit(self):
        points = icosphere_points(20) + [(9, 9, 9)]
        self.write_model(points)
        self.write("--points", "model.obj", "--limit", "-o", "d.npz")
        alone = self.npz("d.npz")
        out = self.write("--points", "model.obj", "--limit", "--gradients", "-o", "d.npz")
        self.assertEqual([line.split(":")[0] for line in out.splitlines()],
                         ["d.npz", "d.dx.npz", "d.dy.npz", "d.dz.npz"])
        self.assert_same(self.npz("d.npz"), alone)
        base, pose = self.bent("c.ovm")
        turn = numpy.array([[0.6, -0.8, 0], [0.8, 0.6, 0.2], [0, 0.1, 1.5]])
        step = 1e-5
        for axis, name in enumerate(["d.dx.npz", "d.dy.npz", "d.dz.npz"]):
            gradient = self.npz(name)
            self.assertEqual(gradient.shape, alone.shape)
            # The gradient of an affine pose is its matrix everywhere; a point that stays has no row.
            numpy.testing.assert_allclose((gradient @ (base @ turn.T))[:20],
                                          numpy.tile(turn[:, axis], (20, 1)), rtol=0, atol=1e-6)
            self.assertEqual(gradient[20].nnz, 0)
            # For any pose the gradient is the difference quotient of D.
            moved = []
            for sign in (1, -1):
                there = numpy.array(points)
                there[:, axis] += sign * step
                self.write_model([tuple(p) for p in there], "there.obj")
                self.write("--points", "there.obj", "--limit", "-o", "there.npz")
                moved.append(self.npz("there.npz") @ pose)
            numpy.testing.assert_allclose((gradient @ pose)[:20],
                                          ((moved[0] - moved[1]) / (2 * step))[:20],
                                          rtol=0, atol=1e-3)
        self.write("--points", "model.obj", "--limit", "--gradients", "-o", "d.npy")
        data = numpy.load(self.path / "d.dz.data.npy")
        numpy.testing.assert_array_equal(data, self.npz("d.dz.npz").data)

    def test_other_bases_are_those_of_deform(self):
        self.run_program("shape", "box", "--cells", 3, 4, 3, "--max", 3, 4, 3, "-o", "c.ovm")
        points = [(1.25 + 0.1 * i, 1.5 + 0.2 * i, 1.75) for i in range(5)]
        self.write_model(points)
        base, pose = self.bent("c.ovm")
        self.write_positions("pose.ovm", "c.ovm", pose)
        for basis, title in [("bezier", "D of the Bézier volume"),
                             ("bspline", "D of the uniform cubic B-splines"),
                             ("subdivision", "D at level 2")]:
            options = ["--basis", basis, *(["-n", 2] if basis == "subdivision" else [])]
            self.deform("model.obj", "c.ovm", "pose.ovm", *options, out="moved.obj")
            self.write("--points", "model.obj", *options, "-o", "d.npz")
            matrix = self.npz("d.npz")
            numpy.testing.assert_allclose(matrix.sum(axis=1), 1, rtol=0, atol=1e-14)
            numpy.testing.assert_allclose(matrix @ base, points, rtol=0, atol=1e-13)
            numpy.testing.assert_allclose(matrix @ pose, self.read_points("moved.obj"),
                                          rtol=0, atol=1e-13)
            self.write("--points", "model.obj", *options, "-o", "d.mtx")
            self.assertIn(title, self.text("d.mtx"))

    def test_a_full_disk(self):
        for name in ["s.mtx", "s.npz", "s.petsc"]:
            self.assert_nothing_is_lost_on_a_full_disk("stencils", "c.ovm", "-n", 2, output=name)
        # Three files are written; there is room for the first one only, the row offsets.
        for name in ["indptr", "indices", "data"]:
            self.put(f"s.{name}.npy", "old")
        self.assert_nothing_is_lost_on_a_full_disk("stencils", "c.ovm", "-n", 2, output="s.npy",
                                                   named="s.indices.npy")

    def test_refusals(self):
        self.write_model(icosphere_points(5) + [(9, 9, 9)])
        self.assertIn("s.mat: is not of a format that can be written here; expected .mtx, .npz, .npy, .petsc",
                      self.error_of("stencils", "c.ovm", "-o", "s.mat"))
        self.assertIn("point 5", self.error_of("stencils", "c.ovm", "-n", 1, "--points",
                                               "model.obj", "--outside", "error", "-o", "d.npz"))
        self.assertIn("--level-tables", self.error_of("stencils", "c.ovm", "-n", 0,
                                                      "--level-tables", "-o", "r.npz", code=2))
        for options in [["--outside", "nearest"], ["--points", "model.obj", "--level-tables"],
                        ["--petsc-indices", "16"], ["--limit"], ["--basis", "bspline"],
                        ["--gradients"],
                        ["--points", "model.obj", "--limit", "-n", "2"],
                        ["--points", "model.obj", "--limit", "--basis", "bezier"],
                        ["--points", "model.obj", "--basis", "bezier", "-n", "2"],
                        ["--points", "model.obj", "--basis", "bspline", "--rules", "mlca"]]:
            self.error_of("stencils", "c.ovm", *options, "-o", "d.npz", code=2)
        self.assertIn("the lattice is not a box", self.error_of(
            "stencils", "c.ovm", "--points", "model.obj", "--basis", "bezier", "-o", "d.npz"))
        # If the name of one file is taken, no file is written.
        (self.path / "d.dy.npz").mkdir()
        self.assertIn("d.dy.npz", self.error_of("stencils", "c.ovm", "--points", "model.obj",
                                                "--limit", "--gradients", "-o", "d.npz"))
        (self.path / "d.dy.npz").rmdir()
        self.assertIn("--level: expected 1 to 20 to bind points, got 0",
                      self.error_of("stencils", "c.ovm", "-n", 0, "--points", "model.obj", "-o", "d.npz", code=2))
        self.assertFalse(list(self.path.glob("*.npz")))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
