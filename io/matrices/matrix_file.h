// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/matrices/petsc_binary.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::io {

struct MatrixFileOptions {
    std::vector<std::string> comments = {};     ///< of .mtx: see writeMatrixMarket()
    PetscInt petscIntegers = PetscInt::Bits32;  ///< of .petsc
};

/// The extensions of writeMatrix(): .mtx, .npz, .npy and .petsc.
ESPALIER_API std::vector<std::string> matrixExtensions();

/// The files that writeMatrix() writes for a path: itself, or the three of .npy.
ESPALIER_API std::vector<std::filesystem::path> matrixPaths(const std::filesystem::path& path);

/// Writes a table in the format of the path's extension: Matrix Market text (.mtx), SciPy's archive
/// (.npz), an array a file (.npy), or PETSc's binary (.petsc). What each holds is said in
/// matrix_market.h, numpy_matrix.h and petsc_binary.h.
///
/// \throws FileError for another extension; what the writers throw
template <class Real>
ESPALIER_API void writeMatrix(const std::filesystem::path& path,
                              const stencils::StencilTable<Real>& table,
                              const MatrixFileOptions& options = {});

/// Reads a table in the format of the path's extension: .mtx, .npz or .petsc. Not .npy: none of the
/// three files has the number of columns (see readNpyArrays).
///
/// \throws FileError for another extension, .npy among them; what the readers throw
ESPALIER_API stencils::StencilTable<double> readMatrix(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file
ESPALIER_API stencils::StencilTable<double> readMatrix(const std::filesystem::path& path,
                                                       std::string_view bytes);

}  // namespace espalier::io
