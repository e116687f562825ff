// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <filesystem>
#include <string_view>

namespace espalier::io {

/// Writes a table for scipy.sparse.load_npz, in the way that scipy.sparse.save_npz writes a
/// csr_array without compression: an archive of indptr, indices, data, shape and format. Weights
/// have the table's precision; indptr and indices have 32 bits, or both have 64 if there are 2^31
/// entries or more. Archives above 4 GB use ZIP64.
///
/// \throws Error if a weight is not finite, naming the row; FileError if the file cannot be written
/// \cost reads the table twice, since a checksum precedes each array
template <class Real>
ESPALIER_API void writeNpz(const std::filesystem::path& path,
                           const stencils::StencilTable<Real>& table);

/// Reads a csr_matrix or csr_array that scipy.sparse.save_npz wrote, compressed or not. Weights are
/// reals of 4 or 8 bytes, or integers that a double holds exactly; indptr and indices are integers
/// of any size; either byte order is accepted. The columns of a row may be in any order. Duplicate
/// columns are an error; they are not summed.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError if the file is malformed, fails the checksums of the archive, has another
///         format, claims more data than it has (before memory is allocated for it), or has a
///         weight that is not finite; the message names the array, or the row, counted from 0
/// \cost memory for the file, one array and the table. A compressed array takes at most 1032 times
/// its bytes in the file, and up to 8 times as much again in the table (integers of 8 bits).
ESPALIER_API stencils::StencilTable<double> readNpz(const std::filesystem::path& path,
                                                    std::string_view bytes);

/// Returns the files that writeNpyArrays() writes for a path: for D.npy these are D.indptr.npy,
/// D.indices.npy and D.data.npy.
ESPALIER_API std::array<std::filesystem::path, 3> npyPaths(const std::filesystem::path& path);

/// Writes indptr, indices and data of a table to a file each, for numpy.load, which can also map
/// them into memory. None of the files has the number of columns.
///
/// \throws Error if a weight is not finite, naming the row; FileError if a file cannot be written
///         (writeFiles in files/file.h says which old files then remain)
template <class Real>
ESPALIER_API void writeNpyArrays(const std::filesystem::path& path,
                                 const stencils::StencilTable<Real>& table);

/// Reads a table from three files of writeNpyArrays() or numpy.save. The arrays may have the types
/// that readNpz() accepts.
///
/// \param path names the three files as in npyPaths()
/// \param columnCount number of columns; for D, the number of lattice vertices
/// \throws FileError as readNpz(), naming the file, or naming `path` if the arrays do not fit
///         together
ESPALIER_API stencils::StencilTable<double> readNpyArrays(const std::filesystem::path& path,
                                                          Index columnCount);

/// The same for files that are in memory already.
/// \param path for messages
/// \param bytes the whole files, in the order of npyPaths()
ESPALIER_API stencils::StencilTable<double> readNpyArrays(
    const std::filesystem::path& path, Index columnCount,
    const std::array<std::string_view, 3>& bytes);

}  // namespace espalier::io
