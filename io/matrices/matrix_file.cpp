// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/matrix_market.h>
#include <espalier/io/matrices/numpy_matrix.h>

#include <type_traits>

#include "../files/other_content.h"
#include "../format.h"

namespace espalier::io {

using stencils::StencilTable;

namespace {

using Path = std::filesystem::path;
using Reader = StencilTable<double> (*)(const Path&, std::string_view bytes);

/// A format whose function `write` takes tables of both precisions.
template <class Write>
constexpr Format formatOfMatrices(std::string_view extension, Reader read, Write) {
    return {
        .extensions = {extension},
        .readMatrix = read,
        .writeFloats = [](const Path& path, const StencilTable<float>& table,
                          const MatrixFileOptions& options) { Write{}(path, table, options); },
        .writeDoubles = [](const Path& path, const StencilTable<double>& table,
                           const MatrixFileOptions& options) { Write{}(path, table, options); }};
}

Reader readerOf(const Path& path) {
    if (const Format* format = findFormat(path, FileContent::Matrix)) return format->readMatrix;
    const std::string expected = "; expected " + listOfFormats(FileContent::Matrix, FileUse::Read);
    if (findFormat(path, FileContent::Matrix, FileUse::Write) == &kNumpyArraysFormat)
        throw FileError(path,
                        "cannot be read as a matrix: arrays in .npy files do not have its "
                        "number of columns" +
                            expected);
    throw FileError(path, "is not of a matrix format that can be read" + expected);
}

}  // namespace

const Format kMatrixMarketFormat = formatOfMatrices(
    ".mtx", readMatrixMarket, [](const Path& path, const auto& table, const auto& options) {
        writeMatrixMarket(path, table, options.comments);
    });
const Format kNumpyArchiveFormat = formatOfMatrices(
    ".npz", readNpz,
    [](const Path& path, const auto& table, const auto&) { writeNpz(path, table); });
const Format kNumpyArraysFormat = [] {
    Format format = formatOfMatrices(
        ".npy", nullptr,
        [](const Path& path, const auto& table, const auto&) { writeNpyArrays(path, table); });
    format.isDisplacements = true;
    return format;
}();
const Format kPetscBinaryFormat = formatOfMatrices(
    ".petsc", readPetscBinary, [](const Path& path, const auto& table, const auto& options) {
        writePetscBinary(path, table, options.petscIntegers);
    });

std::vector<Path> matrixPaths(const Path& path) {
    if (findFormat(path, FileContent::Matrix, FileUse::Write) != &kNumpyArraysFormat) return {path};
    const auto paths = npyPaths(path);
    return {paths.begin(), paths.end()};
}

template <class Real>
void writeMatrix(const Path& path, const StencilTable<Real>& table,
                 const MatrixFileOptions& options) {
    const Format* format = findFormat(path, FileContent::Matrix, FileUse::Write);
    if (!format)
        throw FileError(path, "is not of a matrix format; expected " +
                                  listOfFormats(FileContent::Matrix, FileUse::Write));
    if constexpr (std::is_same_v<Real, float>)
        format->writeFloats(path, table, options);
    else
        format->writeDoubles(path, table, options);
}

StencilTable<double> readMatrix(const Path& path) {
    readerOf(path);  // throws before the file is read
    return readMatrix(path, readFile(path));
}

StencilTable<double> readMatrix(const Path& path, std::string_view bytes) {
    return explainingContent(path, bytes, [&] { return readerOf(path)(path, bytes); });
}

template void writeMatrix(const std::filesystem::path&, const StencilTable<float>&,
                          const MatrixFileOptions&);
template void writeMatrix(const std::filesystem::path&, const StencilTable<double>&,
                          const MatrixFileOptions&);

}  // namespace espalier::io
