// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/io/files/file.h>
#include <espalier/io/matrices/numpy_matrix.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "../files/bytes.h"
#include "../files/zip.h"
#include "matrix_rows.h"
#include "npy.h"

namespace espalier::io {
namespace {

using stencils::StencilTable;

/// SciPy's name for compressed sparse rows.
constexpr std::string_view kFormat = "csr";

/// An array with SciPy's name for it.
struct NamedArray {
    std::string name;
    std::function<void(ByteOutput&)> write;
};

template <class Integer, class Real>
std::array<NamedArray, 3> arraysWith(const StencilTable<Real>& table) {
    return {{{"indptr", [&](ByteOutput& out) { writeNpy<Integer>(out, table.offsets()); }},
             {"indices", [&](ByteOutput& out) { writeNpy<Integer>(out, table.columns()); }},
             {"data", [&](ByteOutput& out) { writeNpy<Real>(out, table.weights()); }}}};
}

template <class Real>
std::array<NamedArray, 3> arraysOf(const StencilTable<Real>& table) {
    checkFinite(table);
    return table.entryCount() <= std::numeric_limits<std::int32_t>::max()
               ? arraysWith<std::int32_t>(table)
               : arraysWith<std::int64_t>(table);
}

/// Reads an array of an archive, and returns use(array).
/// \param maxItems largest allowed number of items; more are refused before anything is inflated
template <class Use>
auto readArray(const ZipReader& zip, const std::string& name, std::size_t maxItems, Use use) {
    constexpr std::size_t kMaxItemBytes = 8, kMaxHeadBytes = 1 << 17;
    const std::string member = name + ".npy";
    try {
        const std::uint64_t claimed = zip.size(member);
        if (claimed > kMaxHeadBytes && (claimed - kMaxHeadBytes) / kMaxItemBytes > maxItems)
            throw CodingError(
                concat("claims ", claimed, " bytes for at most ", maxItems, " numbers"));
        std::string room;
        return use(readNpy(zip.read(member, room)));
    } catch (const CodingError& error) {
        throw CodingError(member + ": " + error.what());
    }
}

void checkFormat(const ZipReader& zip) {
    const std::string format = readArray(zip, "format", kFormat.size(), npyText);
    if (format != kFormat)
        throw CodingError("the matrix is in the format " + inQuotes(format) + "; expected '" +
                          std::string(kFormat) + "' (in SciPy: matrix.tocsr())");
}

StencilTable<double> readArchive(const ZipReader& zip) {
    checkFormat(zip);
    const auto shape = readArray(zip, "shape", 2, npyNumbers<Offset>);
    if (shape.size() != 2)
        throw CodingError(
            concat("the matrix has ", shape.size(), " axes; expected rows and columns"));
    const Index rowCount = matrixSize(shape[0], "rows");
    const Index columnCount = matrixSize(shape[1], "columns");
    const std::size_t offsetCount = Offset{rowCount} + 1;
    auto offsets = readArray(zip, "indptr", offsetCount, npyNumbers<Offset>);
    if (offsets.size() != offsetCount)
        throw CodingError(concat("indptr.npy: has ", offsets.size(), " numbers for ", rowCount,
                                 " rows; expected one more than there are rows"));
    const std::size_t entries =
        sizeInMemory(static_cast<std::uint64_t>(std::max<Offset>(offsets[offsets.size() - 1], 0)));
    auto columns = readArray(zip, "indices", entries, npyNumbers<Index>);
    auto weights = readArray(zip, "data", entries, npyNumbers<double>);
    return tableOfRows(columnCount, std::move(offsets), std::move(columns), std::move(weights));
}

}  // namespace

template <class Real>
void writeNpz(const std::filesystem::path& path, const StencilTable<Real>& table) {
    const auto arrays = arraysOf(table);
    writeFile(path, [&](std::ostream& stream) {
        ZipWriter zip(stream);
        for (const NamedArray& array : arrays) zip.add(array.name + ".npy", array.write);
        zip.add("shape.npy", [&](ByteOutput& out) {
            const std::array<std::int64_t, 2> shape = {table.rowCount(), table.columnCount()};
            writeNpy<std::int64_t>(out, std::span<const std::int64_t>(shape));
        });
        zip.add("format.npy", [](ByteOutput& out) {
            writeNpyHead(out, "|S3", {});
            out.bytes(kFormat);
        });
        zip.finish();
    });
}

std::array<std::filesystem::path, 3> npyPaths(const std::filesystem::path& path) {
    const auto named = [&](const char* name) {
        std::filesystem::path result = path;
        return result.replace_extension(std::string(".") + name + path.extension().string());
    };
    return {named("indptr"), named("indices"), named("data")};
}

StencilTable<double> readNpz(const std::filesystem::path& path, std::string_view bytes) {
    return decodeFile(path, [&] { return readArchive(ZipReader(bytes)); });
}

StencilTable<double> readNpyArrays(const std::filesystem::path& path, Index columnCount) {
    std::array<std::string, 3> files;
    std::array<std::string_view, 3> bytes;
    const auto paths = npyPaths(path);
    for (std::size_t i = 0; i < paths.size(); ++i) bytes[i] = files[i] = readFile(paths[i]);
    return readNpyArrays(path, columnCount, bytes);
}

StencilTable<double> readNpyArrays(const std::filesystem::path& path, Index columnCount,
                                   const std::array<std::string_view, 3>& bytes) {
    const auto paths = npyPaths(path);
    const auto read = [&](std::size_t i, auto numbers) {
        return decodeFile(paths[i], [&] { return numbers(readNpy(bytes[i])); });
    };
    auto offsets = read(0, npyNumbers<Offset>);
    auto columns = read(1, npyNumbers<Index>);
    auto weights = read(2, npyNumbers<double>);
    return decodeFile(path, [&] {
        return tableOfRows(matrixSize(columnCount, "columns"), std::move(offsets),
                           std::move(columns), std::move(weights));
    });
}

template <class Real>
void writeNpyArrays(const std::filesystem::path& path, const StencilTable<Real>& table) {
    const auto arrays = arraysOf(table);
    const auto paths = npyPaths(path);
    std::vector<FileToWrite> files;
    for (std::size_t i = 0; i < arrays.size(); ++i)
        files.push_back({paths[i], [&array = arrays[i]](std::ostream& stream) {
                             ByteOutput out(stream, std::endian::little);
                             array.write(out);
                         }});
    writeFiles(files);
}

template void writeNpz(const std::filesystem::path&, const StencilTable<float>&);
template void writeNpz(const std::filesystem::path&, const StencilTable<double>&);
template void writeNpyArrays(const std::filesystem::path&, const StencilTable<float>&);
template void writeNpyArrays(const std::filesystem::path&, const StencilTable<double>&);

}  // namespace espalier::io
