// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <ostream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "../files/bytes.h"
#include "../files/text_output.h"
#include "file_model.h"
#include "odd_lines.h"
#include "surface_writers.h"

// STL, ASCII or binary. Its points are the three corners of each facet, facet
// after facet; so a vertex of the surface is repeated for each facet around it.
//
// A file is binary if it has exactly the 84 + 50 · n bytes of the n facets that it claims, even if
// its header begins with "solid". A binary file holds floats. Bytes after its last facet are kept,
// and a note counts them. In a text, "endsolidpart" is "endsolid" and a name, with a note.
//
// On writing, a facet with a corner that moved gets the normal of its new corners, or 0 0 0 if
// they lie on a line. All other facets keep their normals. Headers, names and attribute bytes are
// kept.
//
// The file is kept, with 24 bytes per point (binary) or 72 (ASCII).

namespace espalier::io {
namespace {

// The binary format: a header of 80 bytes, the number of facets, and for each facet its normal, its
// corners and two attribute bytes. All numbers are little-endian.
constexpr std::size_t kHeaderSize = 80;
constexpr std::size_t kFirstFacet = kHeaderSize + sizeof(std::uint32_t);
constexpr std::size_t kVectorSize = 3 * sizeof(float);
constexpr std::size_t kFacetSize = 4 * kVectorSize + 2;

/// Returns b - a, scaled so that its largest component is 1; 0 stays 0.
Point3 direction(const Point3& a, const Point3& b) {
    Point3 result{};
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result[axis] = b[axis] - a[axis];
        largest = std::max(largest, std::abs(result[axis]));
    }
    for (double& component : result) component = largest > 0 ? component / largest : 0;
    return result;
}

/// Returns the unit normal on the side from which the corners run counterclockwise; 0 if they lie
/// on a line.
Point3 facetNormal(std::span<const Point3, 3> corners) {
    const Point3 u = direction(corners[0], corners[1]);
    const Point3 v = direction(corners[0], corners[2]);
    const Point3 normal = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                           u[0] * v[1] - u[1] * v[0]};
    const double size = length(normal);
    // Both directions have components of at most 1: a product below this is rounding error.
    if (!(size > 4 * std::numeric_limits<double>::epsilon())) return {0, 0, 0};
    // Adding 0 turns −0 into +0.
    return {normal[0] / size + 0.0, normal[1] / size + 0.0, normal[2] / size + 0.0};
}

void storeVector(std::string& bytes, std::size_t offset, const Point3& vector) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        storeCoordinate(bytes, offset + axis * sizeof(float), vector[axis], Precision::Float,
                        std::endian::little);
}

bool isMoved(const FileView& file, std::size_t facet, std::span<const Point3, 3> corners) {
    return !std::equal(corners.begin(), corners.end(),
                       file.numbers.points.values.data() + 3 * facet);
}

/// Returns the facets. Corners at one position are the first corner there.
ModelFaces weldedFacets(std::span<const Point3> positions) {
    std::vector<std::size_t> order(positions.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    sortCancellably(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::tie(positions[a], a) < std::tie(positions[b], b);
    });
    ModelFaces faces;
    faces.corners.resize(positions.size());
    std::size_t first = 0;  // the first of all corners at a position
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || positions[order[i]] != positions[first]) first = order[i];
        faces.corners[order[i]] = static_cast<Index>(first);
    }
    for (std::size_t end = 3; end <= positions.size(); end += 3) faces.ends.push_back(end);
    return faces;
}

// Binary.

std::size_t normalOffset(std::size_t facet) {
    return kFirstFacet + facet * kFacetSize;
}

std::size_t cornerOffset(std::size_t point) {
    return normalOffset(point / 3) + (point % 3 + 1) * kVectorSize;
}

/// Returns the number of facets that the head of a binary file claims.
std::uint32_t facetCount(std::string_view bytes) {
    return loadNumber<std::uint32_t>(bytes.data() + kHeaderSize, std::endian::little);
}

/// Returns the size of the facets that the head of a binary file claims, and of the head.
std::uint64_t binarySizeOf(std::string_view bytes) {
    return bytes.size() < kFirstFacet ? kFirstFacet
                                      : kFirstFacet + kFacetSize * std::uint64_t{facetCount(bytes)};
}

/// Throws if some corners of a facet are finite and some are not.
void refusePartlyFinite(const std::filesystem::path& path, std::span<const Point3> points,
                        std::size_t facet) {
    const std::span<const Point3> corners = points.subspan(3 * facet, 3);
    const auto isFinite = [](double x) { return std::isfinite(x); };
    const auto isFinitePoint = [&](const Point3& p) { return std::ranges::all_of(p, isFinite); };
    if (std::ranges::all_of(corners, isFinitePoint) || std::ranges::none_of(corners, isFinitePoint))
        return;
    for (std::size_t point = 3 * facet; true; ++point)
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (!isFinite(points[point][axis]))
                refuseNotFinite(cornerOffset(point) + axis * sizeof(float), axis, point, path);
}

/// Reads a file that has at least the size of its facets. Has no table of offsets, since
/// cornerOffset() gives them.
FileNumbers readBinary(const std::filesystem::path& path, std::string_view bytes) {
    FileNumbers numbers;
    numbers.setBinary(std::endian::little, Precision::Float);
    auto& points = numbers.points.values;
    points.resize(3 * std::size_t{facetCount(bytes)});
    if (const std::size_t more = bytes.size() - normalOffset(facetCount(bytes)); more > 0)
        numbers.notes.push_back(
            concat("kept ", more, more == 1 ? " byte" : " bytes", " after the last facet"));
    for (std::size_t point = 0; point < points.size(); ++point) {
        checkCancelledEvery(point, 14);
        for (std::size_t axis = 0; axis < 3; ++axis)
            points[point][axis] = loadReal(bytes, cornerOffset(point) + axis * sizeof(float),
                                           Precision::Float, std::endian::little);
        if (point % 3 == 2) refusePartlyFinite(path, points, point / 3);
    }
    return numbers;
}

void writeBinary(std::ostream& out, const FileView& file, std::span<const Point3> moved) {
    std::string bytes(file.bytes);
    for (std::size_t facet = 0; facet < moved.size() / 3; ++facet) {
        checkCancelledEvery(facet, 12);
        const std::span<const Point3, 3> corners(moved.data() + 3 * facet, 3);
        std::array<Point3, 3> rounded;
        for (std::size_t corner = 0; corner < 3; ++corner)
            for (std::size_t axis = 0; axis < 3; ++axis)
                rounded[corner][axis] =
                    roundTo(Precision::Float, corners[corner][axis], 3 * facet + corner);
        if (!isMoved(file, facet, rounded)) continue;
        // The normal is computed from the corners before rounding: rounding may turn a small facet,
        // or give a direction to one whose corners lie on a line.
        storeVector(bytes, normalOffset(facet), facetNormal(corners));
        for (std::size_t corner = 0; corner < 3; ++corner)
            storeVector(bytes, cornerOffset(3 * facet + corner), rounded[corner]);
    }
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

// Text.

/// Reads an ASCII STL. Keywords may be in upper case, as some programs write them.
class TextStl {
public:
    TextStl(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes), reader_(path, bytes) {
        while (!reader_.atEnd()) {
            readSolid();
            ++solidCount;
        }
        if (!joined_.empty())
            numbers.notes.push_back("read " + joined_.phrase("as solid or endsolid and a name"));
    }

    FileNumbers numbers;
    /// One per facet. The words are not parsed, because some programs write no numbers here.
    std::vector<std::array<std::string_view, 3>> normals;

    std::size_t solidCount = 0;

private:
    void expect(const char* keyword) {
        const std::string_view word = reader_.token(keyword);
        if (lowerCase(word) != keyword)
            reader_.fail("expected " + inQuotes(keyword) + ", got " + inQuotes(word));
    }

    /// Returns true for a keyword, also if a name follows it without a space.
    bool isBegin(std::string_view keyword, std::string_view word) {
        if (!lowerCase(word.substr(0, keyword.size())).starts_with(keyword)) return false;
        if (word.size() > keyword.size()) joined_.add(word, reader_.line());
        return true;
    }

    void readSolid() {
        const std::string_view solid = reader_.token("solid");
        if (!isBegin("solid", solid)) reader_.fail("expected 'solid', got " + inQuotes(solid));
        reader_.restOfLine();  // the name
        while (true) {
            const std::string_view word = reader_.token("facet or endsolid");
            if (isBegin("endsolid", word)) break;
            if (lowerCase(word) != "facet")
                reader_.fail(inQuotes(word) + "; expected 'facet' or 'endsolid'");
            readFacet();
        }
        reader_.restOfLine();  // the name again
    }

    void readFacet() {
        expect("normal");
        for (std::string_view& word : normals.emplace_back())
            word = reader_.token("a component of a normal");
        expect("outer");
        expect("loop");
        for (std::size_t corner = 0; corner < 3; ++corner) {
            expect("vertex");
            Point3& point = numbers.points.values.emplace_back();
            CoordinateOffsets& offsets = numbers.points.offsets.emplace_back();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::string_view word = reader_.token("a coordinate of a vertex");
                offsets[axis] = word.data() - bytes_.data();
                point[axis] = parseCoordinate(word, axis, Precision::Double, path_, reader_.line());
            }
        }
        expect("endloop");
        expect("endfacet");
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    TextReader reader_;
    OddLines joined_;  ///< lines with a keyword that is joined to a name
};

void writeText(std::ostream& out, const FileView& file, std::span<const Point3> moved) {
    const TextStl stl(file.path, file.bytes);
    const VectorChange points = file.numbers.points.changeTo(moved);
    TextChanges moves(file.bytes, {&points, 1});
    TextPatch patch(out, file.bytes);
    for (std::size_t facet = 0; facet < stl.normals.size(); ++facet) {
        const std::span<const Point3, 3> corners(moved.data() + 3 * facet, 3);
        if (!isMoved(file, facet, corners)) continue;
        const Point3 normal = facetNormal(corners);
        const auto& words = stl.normals[facet];
        moves.applyUpTo(patch, words[0].data() - file.bytes.data());
        for (std::size_t axis = 0; axis < 3; ++axis) patch.replace(words[axis], normal[axis]);
    }
    moves.applyUpTo(patch, file.bytes.size());
    patch.finish();
}

// Both.

bool beginsWithSolid(std::string_view bytes) {
    const std::size_t begin = bytes.find_first_not_of(" \t\r\n");
    return begin != std::string_view::npos && lowerCase(bytes.substr(begin, 5)) == "solid";
}

FileNumbers readStlNumbers(const std::filesystem::path& path, std::string_view bytes) {
    const std::uint64_t binarySize = binarySizeOf(bytes);
    if (bytes.size() == binarySize) return readBinary(path, bytes);
    // A text has no byte 0, and nearly every binary file has one.
    if (beginsWithSolid(bytes) && bytes.find('\0') == std::string::npos)
        return std::move(TextStl(path, bytes).numbers);
    if (bytes.size() > binarySize && binarySize > kFirstFacet) return readBinary(path, bytes);
    throw FileError(path,
                    concat("not an ASCII STL, which begins with 'solid', and not a binary one, ",
                           "which would have ", binarySize, " bytes; got ", bytes.size()));
}

ModelSurface readStlModelSurface(const FileView& file) {
    ModelSurface surface;
    surface.dropsLoosePoints = true;
    surface.faces = weldedFacets(file.numbers.points.values);
    if (!file.numbers.order) {
        if (TextStl(file.path, file.bytes).solidCount > 1) surface.addOther("solids");
        return surface;
    }
    for (std::size_t facet = 0; facet < surface.faces.count(); ++facet)
        if (const std::size_t end = normalOffset(facet + 1);
            file.bytes[end - 2] != 0 || file.bytes[end - 1] != 0) {
            surface.addOther("attribute bytes");
            break;
        }
    return surface;
}

void writeStl(std::ostream& out, const FileView& file, std::span<const Point3> moved,
              std::span<const DeformationGradient>) {
    (file.numbers.order ? writeBinary : writeText)(out, file, moved);
}

constexpr FileModelFormat kStlModel = {
    .readNumbers = readStlNumbers, .readSurface = readStlModelSurface, .write = writeStl};

}  // namespace

void writeStlSurface(std::ostream& out, const SurfaceView& surface) {
    std::string bytes = "Espalier";
    bytes.resize(kFirstFacet, ' ');
    storeNumber(bytes.data() + kHeaderSize, static_cast<std::uint32_t>(surface.faces.count()),
                std::endian::little);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.assign(kFacetSize, '\0');
    for (std::size_t facet = 0; facet < surface.faces.count(); ++facet) {
        checkCancelledEvery(facet, 12);
        std::array<Point3, 3> corners;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Index point = surface.faces[facet][corner];
            corners[corner] = surface.points[point];
            Point3 rounded;
            for (std::size_t axis = 0; axis < 3; ++axis)
                rounded[axis] = roundTo(Precision::Float, corners[corner][axis], point);
            storeVector(bytes, (corner + 1) * kVectorSize, rounded);
        }
        storeVector(bytes, 0, facetNormal(corners));
        out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
}

const Format kStlFormat = {.extensions = {".stl"},
                           .readModel = readFileModel<kStlModel>,
                           .writeSurface = writeStlSurface,
                           .normals = Format::Normals::Facets,
                           .holdsTriangles = true};

}  // namespace espalier::io
