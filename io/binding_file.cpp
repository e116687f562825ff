// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/binding_file.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "files/bytes.h"
#include "files/text_output.h"
#include "format.h"

namespace espalier::io {
namespace {

constexpr std::string_view kBindingMagic = "ESPALIER";
constexpr std::uint32_t kBindingVersion = 8;

using stencils::StencilTable;

/// The numbers in the header of the file after its version.
struct Header {
    bool hasGradients = false;
    std::uint64_t topologyHash = 0;
    double largestResidual = 0;
    std::int64_t rows = 0, columns = 0, entries = 0, faces = 0, corners = 0, nameBytes = 0,
                 modelBytes = 0;
    // The sizes of the gradients.
    std::int64_t vertices = 0, vertexEntries = 0, points = 0, pointEntries = 0, cells = 0,
                 cellPlaces = 0, patches = 0, places = 0, basisPlaces = 0, weights = 0;
};

/// Calls f with each size of the gradients, in the order of the file.
/// \tparam AnyHeader Header, const or not
template <class AnyHeader, class F>
void forEachGradientSize(AnyHeader& header, F f) {
    f(header.vertices);
    f(header.vertexEntries);
    f(header.points);
    f(header.pointEntries);
    f(header.cells);
    f(header.cellPlaces);
    f(header.patches);
    f(header.places);
    f(header.basisPlaces);
    f(header.weights);
}

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
bool fileSizeMatches(const Header& header, std::size_t left) {
    // Subtracts each part from the bytes that are left, so that no claimed size can overflow.
    std::uint64_t room = left;
    const auto take = [&](std::int64_t count, std::uint64_t size) {
        if (count < 0 || static_cast<std::uint64_t>(count) > room / size) return false;
        room -= static_cast<std::uint64_t>(count) * size;
        return true;
    };
    const auto takeTable = [&](std::int64_t rows, std::int64_t entries) {
        return take(1, 8) && take(rows, 8) && take(entries, sizeof(double) + sizeof(Index));
    };
    if (header.hasGradients) {
        if (!take(1, 8 + 4 * 4) || !takeTable(header.vertices, header.vertexEntries) ||
            !take(header.points, 4 + 2 * 8) || !takeTable(header.points, header.pointEntries) ||
            !take(header.cells, sizeof(embed::CellPlaces::Cell)) ||
            !take(header.cellPlaces, 3 * 8 + 2 * 4))
            return false;
    } else {
        bool areThere = false;
        forEachGradientSize(header, [&](std::int64_t size) { areThere = areThere || size != 0; });
        if (areThere) return false;
    }
    if (!take(header.patches, sizeof(embed::SplinePlaces::Patch)) ||
        !take(header.places, 3 * 8 + 2 * 4) || !take(header.basisPlaces, 3 * 8 + 4) ||
        !take(header.weights, 4 * 8))
        return false;
    return takeTable(header.rows, header.entries) && take(header.rows, sizeof(Point3) + 1) &&
           take(header.columns, sizeof(Point3)) && take(header.faces, 8) &&
           take(header.corners, 4) && take(header.nameBytes, 1) && take(header.modelBytes, 1) &&
           room == sizeof(std::uint32_t);
}

Header readHeader(ByteInput& in) {
    constexpr std::size_t kAfterVersion = 4 + 8 + 8 + 17 * 8;
    if (in.left() < kBindingMagic.size() || in.bytes(kBindingMagic.size()) != kBindingMagic)
        throw CodingError("is not a bound model");
    if (in.left() < 4) throw CodingError("is truncated");
    const auto version = in.number<std::uint32_t>();
    if (version != kBindingVersion)
        throw CodingError(concat("is a bound model of version ", version,
                                 ", and this program reads version ", kBindingVersion,
                                 " only: bind the model again (espalier bind)"));
    if (in.left() < kAfterVersion) throw CodingError("is truncated");
    Header header;
    const auto flag = in.number<std::uint32_t>();
    if (flag > 1)
        throw CodingError(concat("has the flag ", flag, " for gradients; expected 0 or 1"));
    header.hasGradients = flag == 1;
    header.topologyHash = in.number<std::uint64_t>();
    header.largestResidual = in.number<double>();
    for (std::int64_t* size : {&header.rows, &header.columns, &header.entries, &header.faces,
                               &header.corners, &header.nameBytes, &header.modelBytes})
        *size = in.number<std::int64_t>();
    forEachGradientSize(header, [&](std::int64_t& size) { size = in.number<std::int64_t>(); });
    if (!fileSizeMatches(header, in.left()))
        throw CodingError("is truncated or corrupted: its size is not what its header says");
    return header;
}

/// Reads a table.
/// \throws CodingError if its arrays are not a table
StencilTable<double> readTable(ByteInput& in, std::int64_t rows, std::int64_t columnCount,
                               std::int64_t entries) {
    auto offsets = readNumbers<Offset>(in, rows + 1);
    auto weights = readWeights(in, entries);
    auto columns = readNumbers<Index>(in, entries);
    try {
        return StencilTable<double>(static_cast<Index>(columnCount), std::move(offsets),
                                    std::move(columns), std::move(weights));
    } catch (const Error& error) {
        throw CodingError(error.what());
    }
}

embed::CellPlaces readCells(ByteInput& in, const Header& header) {
    embed::CellPlaces cells;
    cells.cells.resize(header.cells);
    for (auto& cell : cells.cells)
        for (Index& vertex : cell) vertex = in.number<Index>();
    cells.places.resize(header.cellPlaces);
    for (auto& [point, cell, uvw] : cells.places) {
        point = in.number<Index>();
        cell = in.number<Index>();
        for (double& coordinate : uvw) coordinate = in.number<double>();
    }
    return cells;
}

embed::SplinePlaces readSplines(ByteInput& in, const Header& header) {
    embed::SplinePlaces splines{in.number<double>()};
    splines.patches.resize(header.patches);
    for (auto& patch : splines.patches)
        for (Index& vertex : patch) vertex = in.number<Index>();
    splines.places.resize(header.places);
    for (auto& [point, patch, uvw] : splines.places) {
        point = in.number<Index>();
        patch = in.number<Index>();
        for (double& coordinate : uvw) coordinate = in.number<double>();
    }
    return splines;
}

/// Reads the places in a basis.
/// \throws CodingError for an unknown basis
embed::BasisPlaces readBasis(ByteInput& in, const Header& header) {
    embed::BasisPlaces basis;
    const auto kind = in.number<Index>();
    if (kind != Index(embed::Basis::Bezier) && kind != Index(embed::Basis::BSpline))
        throw CodingError(concat("has the basis ", kind, "; expected 0 or 1"));
    basis.basis = static_cast<embed::Basis>(kind);
    for (Index& along : basis.cells) along = in.number<Index>();
    basis.places.resize(header.basisPlaces);
    for (auto& [point, at] : basis.places) {
        point = in.number<Index>();
        for (double& coordinate : at) coordinate = in.number<double>();
    }
    return basis;
}

std::vector<bind::PointWeight> readPointWeights(ByteInput& in, std::int64_t count) {
    std::vector<bind::PointWeight> weights(count);
    for (auto& [value, slope] : weights) {
        value = in.number<double>();
        for (double& coordinate : slope) coordinate = in.number<double>();
    }
    return weights;
}

/// Reads the faces of the lattice.
/// \throws CodingError if they do not divide the corners, or name a vertex that does not exist
ModelFaces readLatticeFaces(ByteInput& in, const Header& header) {
    ModelFaces faces;
    std::int64_t begin = 0;
    for (std::int64_t face = 0; face < header.faces; ++face) {
        const auto end = in.number<std::int64_t>();
        if (end < begin || end > header.corners)
            throw CodingError(concat("ends face ", face, " of the lattice at corner ", end,
                                     "; expected ", begin, " to ", header.corners));
        faces.ends.push_back(end);
        begin = end;
    }
    if (begin != header.corners)
        throw CodingError(
            concat("has ", header.corners, " corners of faces; the faces use ", begin));
    const auto corners = readNumbers<Index>(in, header.corners);
    faces.corners.assign(corners.begin(), corners.end());
    for (const Index corner : faces.corners)
        if (corner < 0 || corner >= header.columns)
            throw CodingError(concat("has a face of the lattice with vertex ", corner,
                                     "; there are ", header.columns, " vertices"));
    return faces;
}

void write(ByteOutput& out, const std::vector<Point3>& points) {
    for (const Point3& point : points) out.numbers(std::span<const double>(point));
}

void write(ByteOutput& out, const StencilTable<double>& table) {
    out.numbers(table.offsets());
    out.numbers(table.weights());
    out.numbers(table.columns());
}

void write(ByteOutput& out, const embed::CellPlaces& cells) {
    for (const auto& cell : cells.cells) out.numbers(std::span<const Index>(cell));
    for (const auto& [point, cell, uvw] : cells.places) {
        out.number(point);
        out.number(cell);
        out.numbers(std::span<const double>(uvw));
    }
}

void write(ByteOutput& out, const embed::SplinePlaces& splines) {
    out.number(splines.spacing);
    for (const auto& patch : splines.patches) out.numbers(std::span<const Index>(patch));
    for (const auto& [point, patch, uvw] : splines.places) {
        out.number(point);
        out.number(patch);
        out.numbers(std::span<const double>(uvw));
    }
}

void write(ByteOutput& out, const embed::BasisPlaces& basis) {
    out.number(static_cast<Index>(basis.basis));
    out.numbers(std::span<const Index>(basis.cells));
    for (const auto& [point, at] : basis.places) {
        out.number(point);
        out.numbers(std::span<const double>(at));
    }
}

void write(ByteOutput& out, const std::vector<bind::PointWeight>& weights) {
    for (const auto& [value, slope] : weights) {
        out.number(value);
        out.numbers(std::span<const double>(slope));
    }
}

BoundModel decodeBoundModel(std::string_view bytes) {
    ByteInput in(bytes, std::endian::little);
    const Header header = readHeader(in);
    const std::string_view checked = bytes.substr(0, bytes.size() - 4);
    const auto expected =
        loadNumber<std::uint32_t>(checked.data() + checked.size(), std::endian::little);
    if (expected != crc32Of(checked))
        throw CodingError("is corrupted: its checksum does not match");

    // The checksum is right, so the checks below only fail for a file that was made to mislead.
    if (header.columns > kMaxIndex)
        throw CodingError(
            concat("claims ", header.columns, " lattice vertices; expected 0 to ", kMaxIndex));
    if (!(header.largestResidual >= 0) || !std::isfinite(header.largestResidual))
        throw CodingError("has a largest residual that is not a length");
    BoundModel model;
    bind::Binding& binding = model.binding;
    binding.topologyHash = header.topologyHash;
    binding.largestResidual = header.largestResidual;
    binding.table = readTable(in, header.rows, header.columns, header.entries);
    if (header.hasGradients) {
        binding.gradients.emplace();
        auto& [vertices, points, rows, cells, splines, basis] = *binding.gradients;
        vertices = readTable(in, header.vertices, header.columns, header.vertexEntries);
        const auto numbers = readNumbers<Index>(in, header.points);
        points.assign(numbers.begin(), numbers.end());
        rows = readTable(in, 3 * header.points, header.vertices, header.pointEntries);
        cells = readCells(in, header);
        splines = readSplines(in, header);
        basis = readBasis(in, header);
        binding.weights = readPointWeights(in, header.weights);
    }
    binding.points = readPoints(in, header.rows, "point");
    binding.rest = readPoints(in, header.columns, "vertex of the lattice at rest");
    for (const auto status : readNumbers<std::uint8_t>(in, header.rows)) {
        if (status > static_cast<std::uint8_t>(embed::PointStatus::NotBound))
            throw CodingError(concat("has the status ", int{status}, " for point ",
                                     binding.statuses.size(), "; expected 0 to 3"));
        binding.statuses.push_back(static_cast<embed::PointStatus>(status));
    }
    try {
        binding.checkParts();
    } catch (const Error& error) {
        throw CodingError(concat("is damaged: ", error.what()));
    }
    model.faces = readLatticeFaces(in, header);
    model.modelName = in.bytes(header.nameBytes);
    model.modelBytes = in.bytes(header.modelBytes);
    return model;
}

/// Returns an .obj of points, each coordinate with all its digits.
std::string objOf(std::span<const Point3> points) {
    std::ostringstream stream;
    {
        TextOutput out(stream);
        for (const Point3& point : points)
            out.put("v ", point[0], " ", point[1], " ", point[2], "\n");
    }
    return std::move(stream).str();
}

/// Writes the bytes of the file.
void encode(std::ostream& stream, const BoundModel& model) {
    const bind::Binding& binding = model.binding;
    const embed::Gradients none;
    const embed::Gradients& gradients = binding.gradients ? *binding.gradients : none;
    ChecksummedOutput out(stream, std::endian::little);
    out.bytes(kBindingMagic);
    out.number(kBindingVersion);
    out.number(std::uint32_t{binding.gradients.has_value()});
    out.number(binding.topologyHash);
    out.number(binding.largestResidual);
    for (const std::int64_t size :
         {std::int64_t{binding.table.rowCount()}, std::int64_t{binding.table.columnCount()},
          std::int64_t{binding.table.entryCount()}, std::int64_t{std::ssize(model.faces.ends)},
          std::int64_t{std::ssize(model.faces.corners)}, std::int64_t{std::ssize(model.modelName)},
          std::int64_t{std::ssize(model.modelBytes)}, std::int64_t{gradients.vertices.rowCount()},
          gradients.vertices.entryCount(), std::int64_t{std::ssize(gradients.points)},
          gradients.rows.entryCount(), std::int64_t{std::ssize(gradients.cells.cells)},
          std::int64_t{std::ssize(gradients.cells.places)},
          std::int64_t{std::ssize(gradients.splines.patches)},
          std::int64_t{std::ssize(gradients.splines.places)},
          std::int64_t{std::ssize(gradients.basis.places)},
          std::int64_t{std::ssize(binding.weights)}})
        out.number(size);
    write(out, binding.table);
    if (binding.gradients) {
        write(out, gradients.vertices);
        out.numbers(std::span<const Index>(gradients.points));
        write(out, gradients.rows);
        write(out, gradients.cells);
        write(out, gradients.splines);
        write(out, gradients.basis);
        write(out, binding.weights);
    }
    write(out, binding.points);
    write(out, binding.rest);
    for (const embed::PointStatus status : binding.statuses)
        out.number(static_cast<std::uint8_t>(status));
    for (const std::size_t end : model.faces.ends) out.number(static_cast<std::int64_t>(end));
    out.numbers(std::span<const Index>(model.faces.corners));
    out.bytes(model.modelName);
    out.bytes(model.modelBytes);
    out.number(out.checksum());
}

}  // namespace

void writeBoundModel(const std::filesystem::path& path, const BoundModel& model) {
    checkBoundModel(model);
    writeFile(path, [&](std::ostream& stream) { encode(stream, model); });
}

std::string boundModelBytes(const BoundModel& model) {
    checkBoundModel(model);
    std::ostringstream stream;
    encode(stream, model);
    return std::move(stream).str();
}

BoundModel readBoundModel(const std::filesystem::path& path) {
    return readBoundModel(path, readFile(path));
}

BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes) {
    return decodeFile(path, [&] { return decodeBoundModel(bytes); });
}

std::unique_ptr<Model> modelOf(const BoundModel& model, const std::filesystem::path& path) {
    if (model.modelName.empty()) return readModel("points.obj", objOf(model.binding.points));
    auto read = readModel(model.modelName, model.modelBytes);
    if (read->positions().size() != model.binding.points.size())
        throw FileError(path, concat("is damaged: the number of points of its model is ",
                                     read->positions().size(), ", and ",
                                     model.binding.points.size(), " points were bound"));
    return read;
}

void checkBoundModel(const BoundModel& model) {
    const bind::Binding& binding = model.binding;
    binding.checkParts();
    const auto refuse = [](const std::string& what) { throw Error("a bound model has " + what); };
    const auto checkFinite = [&](const std::vector<Point3>& positions, const std::string& what) {
        for (std::size_t i = 0; i < positions.size(); ++i)
            for (const double coordinate : positions[i])
                if (!std::isfinite(coordinate)) refuse(concat(what, " ", i, " that is not finite"));
    };
    checkFinite(binding.points, "point");
    checkFinite(binding.rest, "vertex");
    if (!(binding.largestResidual >= 0) || !std::isfinite(binding.largestResidual))
        refuse("a largest residual that is not a length");
    const ModelFaces& faces = model.faces;
    if (!std::is_sorted(faces.ends.begin(), faces.ends.end()) ||
        faces.corners.size() != (faces.ends.empty() ? 0 : faces.ends.back()))
        refuse("faces that do not divide their corners");
    for (const Index corner : faces.corners)
        if (corner < 0 || corner >= binding.table.columnCount())
            refuse(concat("a face of vertex ", corner));
}

const Format kBoundModelFormat = {.extensions = {".espb"}, .isBoundModel = true};

}  // namespace espalier::io
