// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/file.h>
#include <espalier/io/finite.h>
#include <espalier/io/npy.h>
#include <espalier/io/numpy_matrix.h>
#include <espalier/io/zip_writer.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace espalier::io {
namespace {

using stencils::StencilTable;

/// An array, by the name that SciPy gives it.
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
            out.bytes("csr");
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
