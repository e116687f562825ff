#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the files of this folder, with NumPy 1.24.2 and SciPy 1.10.1, those of Debian 12.

    write_matrices.py [FOLDER]
"""

import pathlib
import sys
import zipfile

import numpy
import scipy.sparse

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__ + "/..").resolve()

# Rows of 2, 0, 3 and 0 entries; floats hold the weights.
matrix = scipy.sparse.csr_matrix(([0.25, -1.5, 2.0**-100, 7, 1], [0, 2, 0, 1, 3], [0, 2, 2, 5, 5]),
                                 shape=(4, 100_000))
scipy.sparse.save_npz(folder / "scipy-compressed.npz", matrix)
scipy.sparse.save_npz(folder / "scipy-csc.npz", matrix[:, :4].tocsc())
scipy.sparse.save_npz(folder / "scipy-no-rows.npz", scipy.sparse.csr_matrix((0, 3)))

unsorted = scipy.sparse.csr_array(
    (numpy.array([-1.5, 0.25, 1, 2.0**-100, 7], "f4"), [2, 0, 3, 0, 1], [0, 2, 2, 5, 5]),
    shape=(4, 100_000))
unsorted.indices, unsorted.indptr = (a.astype("i8") for a in (unsorted.indices, unsorted.indptr))
scipy.sparse.save_npz(folder / "scipy-array-unsorted-stored.npz", unsorted, compressed=False)


def save(name, version, **arrays):
    """As numpy.savez_compressed, with heads of a version that it keeps for what needs it."""
    with zipfile.ZipFile(folder / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for key, array in arrays.items():
            with archive.open(key + ".npy", "w", force_zip64=True) as out:
                numpy.lib.format.write_array(out, numpy.asanyarray(array), version=version)


shape = numpy.array(matrix.shape)
save("numpy-2-big-endian.npz", (2, 0), indices=matrix.indices.astype(">i4"),
     indptr=matrix.indptr.astype(">i8"), format="csr", shape=shape.astype(">i8"),
     data=matrix.data.astype(">f8"))
save("numpy-3-integers.npz", (3, 0), indices=matrix.indices.astype("u2"), indptr=matrix.indptr,
     format=b"csr", shape=shape, data=numpy.array([1, -2, 2**53, -2**53, 0]))

for name in ["indptr", "indices", "data"]:
    numpy.save(folder / f"numpy.{name}.npy", getattr(matrix, name))
