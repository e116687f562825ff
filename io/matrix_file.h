// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/io/petsc_binary.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <string>
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

}  // namespace espalier::io
