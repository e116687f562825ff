// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <filesystem>

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

}  // namespace espalier::io
