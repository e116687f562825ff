// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/file.h>
#include <espalier/io/matrix_file.h>
#include <espalier/io/matrix_market.h>
#include <espalier/io/numpy_matrix.h>

namespace espalier::io {

std::vector<std::string> matrixExtensions() {
    return {".mtx", ".npz", ".npy", ".petsc"};
}

std::vector<std::filesystem::path> matrixPaths(const std::filesystem::path& path) {
    if (path.extension() != ".npy") return {path};
    const auto paths = npyPaths(path);
    return {paths.begin(), paths.end()};
}

template <class Real>
void writeMatrix(const std::filesystem::path& path, const stencils::StencilTable<Real>& table,
                 const MatrixFileOptions& options) {
    const std::string extension = path.extension().string();
    if (extension == ".mtx") return writeMatrixMarket(path, table, options.comments);
    if (extension == ".npz") return writeNpz(path, table);
    if (extension == ".npy") return writeNpyArrays(path, table);
    if (extension == ".petsc") return writePetscBinary(path, table, options.petscIntegers);
    throw FileError(path, "is not a matrix format; expected .mtx, .npz, .npy or .petsc");
}

template void writeMatrix(const std::filesystem::path&, const stencils::StencilTable<float>&,
                          const MatrixFileOptions&);
template void writeMatrix(const std::filesystem::path&, const stencils::StencilTable<double>&,
                          const MatrixFileOptions&);

}  // namespace espalier::io
