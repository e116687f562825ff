// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/matrices/petsc_binary.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// \file
/// Writes and reads tables in all matrix formats, chosen by the extension.

namespace espalier::io {

/// Options of writeMatrix().
struct MatrixFileOptions {
    std::vector<std::string> comments = {};     ///< comments of an .mtx: see writeMatrixMarket()
    PetscInt petscIntegers = PetscInt::Bits32;  ///< size of the integers of a .petsc
};

/// Returns the files that writeMatrix() writes for a path: the path itself, or three files for
/// .npy.
ESPALIER_API std::vector<std::filesystem::path> matrixPaths(const std::filesystem::path& path);

/// Writes a table in the format of the path's extension: Matrix Market text (.mtx), SciPy's archive
/// (.npz), one file per array (.npy), or PETSc's binary (.petsc). The headers matrix_market.h,
/// numpy_matrix.h and petsc_binary.h describe the formats.
///
/// \throws FileError for another extension; the errors of the writers
template <class Real>
ESPALIER_API void writeMatrix(const std::filesystem::path& path,
                              const stencils::StencilTable<Real>& table,
                              const MatrixFileOptions& options = {});

/// Reads a table in the format of the path's extension: .mtx, .npz or .petsc. It cannot read .npy,
/// because none of the three files has the number of columns (see readNpyArrays).
///
/// \throws FileError for another extension, including .npy; the errors of the readers
ESPALIER_API stencils::StencilTable<double> readMatrix(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file
ESPALIER_API stencils::StencilTable<double> readMatrix(const std::filesystem::path& path,
                                                       std::string_view bytes);

}  // namespace espalier::io
