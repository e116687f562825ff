// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <filesystem>
#include <string_view>

namespace espalier::io {

/// Writes a table as scipy.sparse.save_npz writes a csr_array, not compressed, for
/// scipy.sparse.load_npz: an archive of indptr, indices, data, shape and format. Weights are of the
/// table's precision; indptr and indices are of 32 bits, or both of 64 where there are 2^31 entries
/// or more. Of more than 4 GB in ZIP64.
///
/// \throws Error if a weight is not finite, naming the row; FileError if the file cannot be written
/// \cost reads the table twice, for checksums
template <class Real>
ESPALIER_API void writeNpz(const std::filesystem::path& path,
                           const stencils::StencilTable<Real>& table);

/// Reads a matrix that scipy.sparse.save_npz wrote, compressed or not, in the format csr, as a
/// csr_matrix or a csr_array. Weights are reals of 4 or 8 bytes, or integers that a double holds
/// exactly; indptr and indices are integers of any size; of either byte order. The columns of a row
/// may come in any order; one that comes twice is an error, not a sum.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError if the file is malformed or damaged, by the checksums of the archive, if it is
///         of another format, if it claims more than there is (before memory is taken for it), or
///         if a weight is not finite; it names the array, or the row, counted from 0
/// \cost   the file, an array and the table in memory; of what is compressed, an array takes no
/// more
///         than 1032 times its bytes, and up to 8 times that in the table (integers of 8 bits)
ESPALIER_API stencils::StencilTable<double> readNpz(const std::filesystem::path& path,
                                                    std::string_view bytes);

/// The files that writeNpyArrays() writes for a path: D.npy stands for D.indptr.npy, D.indices.npy
/// and D.data.npy.
ESPALIER_API std::array<std::filesystem::path, 3> npyPaths(const std::filesystem::path& path);

/// Writes the same arrays, each as a file of its own, for numpy.load, which can also map them into
/// memory. The number of columns is in none of them.
///
/// \throws Error if a weight is not finite, naming the row; FileError if a file cannot be written:
///         all old ones are then as they were
template <class Real>
ESPALIER_API void writeNpyArrays(const std::filesystem::path& path,
                                 const stencils::StencilTable<Real>& table);

/// Reads such arrays, as numpy.save wrote them: what readNpz() takes, in three files.
///
/// \param path stands for the files of npyPaths()
/// \param columnCount which none of them has: of D it is the number of lattice vertices
/// \throws FileError as readNpz(), naming the file, or `path` where they do not fit together
ESPALIER_API stencils::StencilTable<double> readNpyArrays(const std::filesystem::path& path,
                                                          Index columnCount);

/// The same for files that are in memory already.
/// \param path for messages
/// \param bytes the whole files, in the order of npyPaths()
ESPALIER_API stencils::StencilTable<double> readNpyArrays(
    const std::filesystem::path& path, Index columnCount,
    const std::array<std::string_view, 3>& bytes);

}  // namespace espalier::io
