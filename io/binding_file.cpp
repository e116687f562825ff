// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/binding_file.h>
#include <espalier/io/files/file.h>

#include <array>
#include <cmath>
#include <ostream>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "files/bytes.h"
#include "files/text_output.h"

namespace espalier::io {
namespace {

constexpr std::string_view kBindingMagic = "ESPALIER";
// Versions.
constexpr std::uint32_t kTableOnly = 1, kWithGradients = 2, kWithRest = 3, kWithFaces = 4;

using stencils::StencilTable;

/// The sizes in the header of the file.
struct Sizes {
    std::int64_t rows, columns, entries, kept, nameBytes, modelBytes;
    std::optional<std::array<std::int64_t, 3>> gradientEntries;
    bool hasRest;
    std::int64_t faces = 0, corners = 0;
};

template <class Number>
Array<Number> readNumbers(ByteInput& in, std::int64_t count) {
    return in.numbersAs<Number, Number>(static_cast<std::uint64_t>(count));
}

/// Reads weights.
/// \throws CodingError if a weight is not finite
Array<double> readWeights(ByteInput& in, std::int64_t count) {
    auto result = readNumbers<double>(in, count);
    for (std::size_t i = 0; i < result.size(); ++i)
        if (!std::isfinite(result[i]))
            throw CodingError(
                concat("has a weight that is not finite: number ", i, " of its table"));
    return result;
}

/// Reads positions.
/// \throws CodingError if a coordinate is not finite
std::vector<Point3> readPoints(ByteInput& in, std::int64_t count, const char* name) {
    std::vector<Point3> result(count);
    for (std::size_t i = 0; i < result.size(); ++i)
        for (double& coordinate : result[i]) {
            coordinate = in.number<double>();
            if (!std::isfinite(coordinate))
                throw CodingError(concat("has a position that is not finite: ", name, " ", i));
        }
    return result;
}

/// Returns true if the file is exactly as long as the sizes in its header say.
bool fileSizeMatches(const Sizes& sizes, std::size_t left) {
    // Subtracts each part from the bytes that are left, so that no claimed size can overflow.
    std::uint64_t room = left;
    const auto take = [&](std::int64_t count, std::uint64_t size) {
        if (count < 0 || static_cast<std::uint64_t>(count) > room / size) return false;
        room -= static_cast<std::uint64_t>(count) * size;
        return true;
    };
    const auto takeTable = [&](std::int64_t entries) {
        return take(1, 8) && take(sizes.rows, 8) && take(entries, 8 + 4);
    };
    if (sizes.gradientEntries) {
        for (const std::int64_t entries : *sizes.gradientEntries)
            if (!takeTable(entries)) return false;
    }
    if (sizes.hasRest && !take(sizes.columns, 3 * 8)) return false;
    return take(sizes.faces, 8) && take(sizes.corners, 4) && takeTable(sizes.entries) &&
           take(sizes.kept, 3 * 8 + 4) && take(sizes.nameBytes, 1) && take(sizes.modelBytes, 1) &&
           room == sizeof(std::uint32_t);
}

Sizes readHeader(ByteInput& in, std::uint64_t& hash) {
    constexpr std::size_t kHeaderSize = 8 + 4 + 4 + 8 + 6 * 8;
    if (in.left() < kBindingMagic.size() || in.bytes(kBindingMagic.size()) != kBindingMagic)
        throw CodingError("is not a bound model");
    if (in.left() + kBindingMagic.size() < kHeaderSize) throw CodingError("is truncated");
    const auto version = in.number<std::uint32_t>();
    if (version < kTableOnly || version > kWithFaces)
        throw CodingError(concat("has version ", version, "; expected 1 to ", kWithFaces));
    const auto flag = in.number<std::uint32_t>();
    if (version == kWithFaces && flag > 1)
        throw CodingError(concat("has the flag ", flag, " for gradients; expected 0 or 1"));
    hash = in.number<std::uint64_t>();
    Sizes sizes{};
    for (std::int64_t* size : {&sizes.rows, &sizes.columns, &sizes.entries, &sizes.kept,
                               &sizes.nameBytes, &sizes.modelBytes})
        *size = in.number<std::int64_t>();
    sizes.hasRest = version != kTableOnly;
    const auto read = [&](std::initializer_list<std::int64_t*> values) {
        if (in.left() < values.size() * sizeof(std::int64_t)) throw CodingError("is truncated");
        for (std::int64_t* value : values) *value = in.number<std::int64_t>();
    };
    if (version == kWithGradients || (version == kWithFaces && flag == 1)) {
        auto& entries = sizes.gradientEntries.emplace();
        read({&entries[0], &entries[1], &entries[2]});
    }
    if (version == kWithFaces) read({&sizes.faces, &sizes.corners});
    if (!fileSizeMatches(sizes, in.left()))
        throw CodingError("is truncated or corrupted: its size is not what its header says");
    return sizes;
}

/// Builds a table with `columnCount` columns.
/// \throws CodingError if the arrays are not such a table
StencilTable<double> makeTable(std::int64_t columnCount, Array<Offset> offsets,
                               Array<Index> columns, Array<double> weights) {
    try {
        return StencilTable<double>(static_cast<Index>(columnCount), std::move(offsets),
                                    std::move(columns), std::move(weights));
    } catch (const Error& error) {
        throw CodingError(error.what());
    }
}

bind::Gradients readGradients(const Sizes& sizes, ByteInput& in) {
    bind::Gradients gradients;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t entries = (*sizes.gradientEntries)[axis];
        auto offsets = readNumbers<Offset>(in, sizes.rows + 1);
        auto weights = readWeights(in, entries);
        auto columns = readNumbers<Index>(in, entries);
        gradients[axis] =
            makeTable(sizes.columns, std::move(offsets), std::move(columns), std::move(weights));
    }
    return gradients;
}

/// Reads the faces of the lattice.
/// \throws CodingError if they do not divide the corners, or name a vertex that does not exist
ModelFaces readLatticeFaces(const Sizes& sizes, ByteInput& in) {
    ModelFaces faces;
    std::int64_t begin = 0;
    for (std::int64_t face = 0; face < sizes.faces; ++face) {
        const auto end = in.number<std::int64_t>();
        if (end < begin || end > sizes.corners)
            throw CodingError(concat("ends face ", face, " of the lattice at corner ", end,
                                     "; expected ", begin, " to ", sizes.corners));
        faces.ends.push_back(static_cast<std::size_t>(end));
        begin = end;
    }
    if (begin != sizes.corners)
        throw CodingError(
            concat("has ", sizes.corners, " corners of faces; the faces use ", begin));
    const auto corners = readNumbers<Index>(in, sizes.corners);
    faces.corners.assign(corners.begin(), corners.end());
    for (const Index corner : faces.corners)
        if (corner < 0 || corner >= sizes.columns)
            throw CodingError(concat("has a face of the lattice with vertex ", corner,
                                     "; there are ", sizes.columns, " vertices"));
    return faces;
}

void write(ByteOutput& out, const std::vector<Point3>& points) {
    for (const Point3& point : points) out.numbers(std::span<const double>(point));
}

void write(ByteOutput& out, const bind::Gradients& gradients) {
    for (const StencilTable<double>& table : gradients) {
        out.numbers(table.offsets());
        out.numbers(table.weights());
        out.numbers(table.columns());
    }
}

BoundModel decodeBoundModel(std::string_view bytes) {
    ByteInput in(bytes, std::endian::little);
    BoundModel model;
    const Sizes sizes = readHeader(in, model.binding.topologyHash);
    const std::string_view checked = bytes.substr(0, bytes.size() - 4);
    const auto expected =
        loadNumber<std::uint32_t>(checked.data() + checked.size(), std::endian::little);
    if (expected != crc32Of(checked))
        throw CodingError("is corrupted: its checksum does not match");

    // The checksum is right, so the checks below only fail for a file that was made to mislead.
    if (sizes.columns < 0 || sizes.columns > kMaxIndex)
        throw CodingError(
            concat("claims ", sizes.columns, " lattice vertices; expected 0 to ", kMaxIndex));
    auto offsets = readNumbers<Offset>(in, sizes.rows + 1);
    auto weights = readWeights(in, sizes.entries);
    model.binding.keptAt = readPoints(in, sizes.kept, "kept point");
    auto columns = readNumbers<Index>(in, sizes.entries);
    const auto keptPoints = readNumbers<Index>(in, sizes.kept);
    model.binding.kept.assign(keptPoints.begin(), keptPoints.end());
    for (const Index kept : model.binding.kept)
        if (kept < 0 || kept >= sizes.rows)
            throw CodingError(
                concat("leaves point ", kept, " in place; there are ", sizes.rows, " points"));
    model.binding.table =
        makeTable(sizes.columns, std::move(offsets), std::move(columns), std::move(weights));
    if (sizes.gradientEntries) model.binding.gradients = readGradients(sizes, in);
    if (sizes.hasRest)
        model.binding.rest = readPoints(in, sizes.columns, "vertex of the lattice at rest");
    model.faces = readLatticeFaces(sizes, in);
    model.modelName = in.bytes(sizes.nameBytes);
    model.modelBytes = in.bytes(sizes.modelBytes);
    return model;
}

/// Returns an .obj of points, each coordinate with all its digits.
/// \throws Error if a point is not finite
std::string objOf(std::span<const Point3> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const double coordinate : points[i])
            if (!std::isfinite(coordinate))
                throw Error(concat("point ", i, " is not finite, so the points cannot be stored"));
    std::ostringstream stream;
    {
        TextOutput out(stream);
        for (const Point3& point : points)
            out.put("v ", point[0], " ", point[1], " ", point[2], "\n");
    }
    return std::move(stream).str();
}

/// Returns the version of the format that holds all parts of a model.
std::uint32_t versionOf(const BoundModel& model) {
    if (model.faces.count() > 0) return kWithFaces;
    if (model.binding.gradients) return kWithGradients;
    return model.binding.rest.empty() ? kTableOnly : kWithRest;
}

}  // namespace

void writeBoundModel(const std::filesystem::path& path, const BoundModel& model) {
    const StencilTable<double>& table = model.binding.table;
    const std::vector<Point3>& points = model.binding.points;
    checkBoundModel(model);
    if (!points.empty() && std::ssize(points) != table.rowCount())
        throw Error(concat("a bound model of ", table.rowCount(), " points is to be written with ",
                           points.size(), " points at rest"));
    const bool hasModel = !model.modelName.empty() || points.empty();
    const std::string name = hasModel ? model.modelName : "points.obj";
    const std::string ofPoints = hasModel ? std::string() : objOf(points);
    const std::string& bytes = hasModel ? model.modelBytes : ofPoints;
    writeFile(path, [&](std::ostream& stream) {
        ChecksummedOutput out(stream, std::endian::little);
        out.bytes(kBindingMagic);
        const std::uint32_t version = versionOf(model);
        const bool isFlagged = version == kWithFaces && model.binding.gradients;
        out.number(version);
        out.number(std::uint32_t{isFlagged});
        out.number(model.binding.topologyHash);
        out.number(std::int64_t{table.rowCount()});
        out.number(std::int64_t{table.columnCount()});
        out.number(std::int64_t{table.entryCount()});
        out.number(static_cast<std::int64_t>(model.binding.kept.size()));
        out.number(static_cast<std::int64_t>(name.size()));
        out.number(static_cast<std::int64_t>(bytes.size()));
        if (model.binding.gradients)
            for (const auto& each : *model.binding.gradients)
                out.number(std::int64_t{each.entryCount()});
        if (version == kWithFaces)
            for (const std::size_t size : {model.faces.count(), model.faces.corners.size()})
                out.number(static_cast<std::int64_t>(size));
        out.numbers(table.offsets());
        out.numbers(table.weights());
        write(out, model.binding.keptAt);
        out.numbers(table.columns());
        out.numbers(std::span<const Index>(model.binding.kept));
        if (model.binding.gradients) write(out, *model.binding.gradients);
        write(out, model.binding.rest);
        for (const std::size_t end : model.faces.ends) out.number(static_cast<std::int64_t>(end));
        out.numbers(std::span<const Index>(model.faces.corners));
        out.bytes(name);
        out.bytes(bytes);
        out.number(out.checksum());
    });
}

BoundModel readBoundModel(const std::filesystem::path& path) {
    return readBoundModel(path, readFile(path));
}

BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes) {
    return decodeFile(path, [&] { return decodeBoundModel(bytes); });
}

std::optional<std::vector<Point3>> pointsAtRest(const BoundModel& model) {
    const Index count = model.binding.table.rowCount();
    if (count == 0) return std::vector<Point3>();
    if (model.modelName.empty()) return std::nullopt;
    const auto file = readModel(model.modelName, model.modelBytes);
    const auto points = file->positions();
    if (std::ssize(points) != count)
        throw Error(concat("binds ", count, " points, but its model has ", points.size()));
    return std::vector<Point3>(points.begin(), points.end());
}

std::optional<std::vector<Point3>> pointsAtRest(const BoundModel& model,
                                                const std::filesystem::path& path) {
    try {
        return pointsAtRest(model);
    } catch (const MemoryError&) {
        throw;
    } catch (const Error& error) {
        throw FileError(path, error.what());
    }
}

void checkBoundModel(const BoundModel& model) {
    const StencilTable<double>& table = model.binding.table;
    const auto refuse = [&](const std::string& what, const std::string& got) {
        throw Error(concat("a bound model of ", table.rowCount(), " points and ",
                           table.columnCount(), " lattice vertices has ", what, " of ", got));
    };
    if (model.binding.gradients)
        for (const auto& each : *model.binding.gradients)
            if (each.rowCount() != table.rowCount() || each.columnCount() != table.columnCount())
                refuse("gradients",
                       concat(each.rowCount(), " points and ", each.columnCount(), " vertices"));
    const bool needsRest =
        model.binding.gradients || model.faces.count() > 0 || !model.binding.rest.empty();
    if (needsRest && std::ssize(model.binding.rest) != table.columnCount())
        refuse("a lattice at rest", concat(model.binding.rest.size(), " vertices"));
    for (const Index corner : model.faces.corners)
        if (corner < 0 || corner >= table.columnCount())
            refuse("a face", concat("vertex ", corner));
}

}  // namespace espalier::io
