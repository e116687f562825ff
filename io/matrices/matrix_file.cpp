// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/matrix_market.h>
#include <espalier/io/matrices/numpy_matrix.h>

namespace espalier::io {

using stencils::StencilTable;

namespace {

using Reader = StencilTable<double> (*)(const std::filesystem::path&, std::string_view bytes);

Reader readerOf(const std::filesystem::path& path) {
    const std::string extension = path.extension().string();
    if (extension == ".mtx") return readMatrixMarket;
    if (extension == ".npz") return readNpz;
    if (extension == ".petsc") return readPetscBinary;
    if (extension == ".npy")
        throw FileError(path,
                        "cannot be read as a matrix: arrays in .npy files do not have its "
                        "number of columns; expected .mtx, .npz or .petsc");
    throw FileError(path,
                    "is not of a matrix format that can be read; expected .mtx, .npz or .petsc");
}

}  // namespace

std::vector<std::string> matrixExtensions() {
    return {".mtx", ".npz", ".npy", ".petsc"};
}

std::vector<std::filesystem::path> matrixPaths(const std::filesystem::path& path) {
    if (path.extension() != ".npy") return {path};
    const auto paths = npyPaths(path);
    return {paths.begin(), paths.end()};
}

template <class Real>
void writeMatrix(const std::filesystem::path& path, const StencilTable<Real>& table,
                 const MatrixFileOptions& options) {
    const std::string extension = path.extension().string();
    if (extension == ".mtx") return writeMatrixMarket(path, table, options.comments);
    if (extension == ".npz") return writeNpz(path, table);
    if (extension == ".npy") return writeNpyArrays(path, table);
    if (extension == ".petsc") return writePetscBinary(path, table, options.petscIntegers);
    throw FileError(path, "is not of a matrix format; expected .mtx, .npz, .npy or .petsc");
}

StencilTable<double> readMatrix(const std::filesystem::path& path) {
    const Reader read = readerOf(path);
    return read(path, readFile(path));
}

StencilTable<double> readMatrix(const std::filesystem::path& path, std::string_view bytes) {
    return readerOf(path)(path, bytes);
}

template void writeMatrix(const std::filesystem::path&, const StencilTable<float>&,
                          const MatrixFileOptions&);
template void writeMatrix(const std::filesystem::path&, const StencilTable<double>&,
                          const MatrixFileOptions&);

}  // namespace espalier::io
