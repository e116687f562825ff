// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/models/stl.h>

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
#include "coordinates.h"
#include "surface_writers.h"

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

void storeVector(std::string& bytes, std::size_t place, const Point3& vector) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        storeCoordinate(bytes, place + axis * sizeof(float), vector[axis], Precision::Float,
                        std::endian::little);
}

/// The base of both kinds of STL: holds the corners, and tells which facets move.
class StlModel : public Model {
public:
    std::span<const Point3> positions() const override { return positions_; }
    std::string_view extension() const override { return ".stl"; }
    bool hasDirections() const override { return false; }

    ModelSurface readSurface() const override {
        ModelSurface surface;
        surface.repeatsPoints = true;
        surface.faces = weldedFacets();
        nameOtherData(surface);
        return surface;
    }

protected:
    explicit StlModel(std::string bytes) : bytes_(std::move(bytes)) {}

    std::size_t facetCount() const { return positions_.size() / 3; }

    bool isMoved(std::size_t facet, std::span<const Point3, 3> corners) const {
        return !std::equal(corners.begin(), corners.end(), positions_.data() + 3 * facet);
    }

    std::string bytes_;
    std::vector<Point3> positions_;

private:
    virtual void nameOtherData(ModelSurface& surface) const = 0;

    /// Returns the facets. Corners at one place are the first corner there.
    ModelFaces weldedFacets() const {
        std::vector<std::size_t> order(positions_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        sortCancellably(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return std::tie(positions_[a], a) < std::tie(positions_[b], b);
        });
        ModelFaces faces;
        faces.corners.resize(positions_.size());
        std::size_t first = 0;  // the first of all corners at a place
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (i == 0 || positions_[order[i]] != positions_[first]) first = order[i];
            faces.corners[order[i]] = static_cast<Index>(first);
        }
        for (std::size_t facet = 1; facet <= facetCount(); ++facet) faces.ends.push_back(3 * facet);
        return faces;
    }
};

class BinaryStl final : public StlModel {
public:
    BinaryStl(const std::filesystem::path& path, std::string bytes) : StlModel(std::move(bytes)) {
        const std::size_t pointCount = 3 * ((bytes_.size() - kFirstFacet) / kFacetSize);
        positions_.resize(pointCount);
        for (std::size_t point = 0; point < pointCount; ++point) {
            checkCancelledEvery(point, 14);
            for (std::size_t axis = 0; axis < 3; ++axis)
                positions_[point][axis] =
                    loadCoordinate(bytes_, placeOf(point, axis), Precision::Float,
                                   std::endian::little, axis, point, path);
        }
    }

    CoordinateStorage storage() const override { return CoordinateStorage::Float; }

private:
    static std::size_t normalPlace(std::size_t facet) { return kFirstFacet + facet * kFacetSize; }
    static std::size_t placeOf(std::size_t point, std::size_t axis) {
        return normalPlace(point / 3) + (point % 3 + 1) * kVectorSize + axis * sizeof(float);
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient>) const override {
        std::string bytes = bytes_;
        for (std::size_t facet = 0; facet < facetCount(); ++facet) {
            checkCancelledEvery(facet, 12);
            const std::span<const Point3, 3> corners(moved.data() + 3 * facet, 3);
            std::array<Point3, 3> rounded;
            for (std::size_t corner = 0; corner < 3; ++corner)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    rounded[corner][axis] =
                        roundTo(Precision::Float, corners[corner][axis], 3 * facet + corner);
            if (!isMoved(facet, rounded)) continue;
            // The normal is computed from the corners before rounding: rounding may turn a small
            // facet, or give a direction to one whose corners lie on a line.
            storeVector(bytes, normalPlace(facet), facetNormal(corners));
            for (std::size_t corner = 0; corner < 3; ++corner)
                storeVector(bytes, placeOf(3 * facet + corner, 0), rounded[corner]);
        }
        writeFile(path, [&](std::ostream& out) {
            out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        });
    }

    void nameOtherData(ModelSurface& surface) const override {
        for (std::size_t facet = 0; facet < facetCount(); ++facet)
            if (const std::size_t end = normalPlace(facet + 1);
                bytes_[end - 2] != 0 || bytes_[end - 1] != 0)
                return surface.addOther("attribute bytes");
    }
};

/// An ASCII STL. Keywords may be in upper case, as some programs write them.
class AsciiStl final : public StlModel {
public:
    AsciiStl(const std::filesystem::path& path, std::string bytes) : StlModel(std::move(bytes)) {
        TextReader reader(path, bytes_);
        while (!reader.atEnd()) {
            readSolid(reader, path);
            ++solidCount_;
        }
    }

    CoordinateStorage storage() const override { return CoordinateStorage::Text; }

private:
    using Place = std::array<std::string_view, 3>;

    static void expect(TextReader& reader, const char* keyword) {
        const std::string_view word = reader.token(keyword);
        if (lowerCase(word) != keyword)
            reader.fail("expected " + inQuotes(keyword) + ", got " + inQuotes(word));
    }

    void readSolid(TextReader& reader, const std::filesystem::path& path) {
        expect(reader, "solid");
        reader.restOfLine();  // the name
        while (true) {
            const std::string_view word = reader.token("facet or endsolid");
            if (lowerCase(word) == "endsolid") break;
            if (lowerCase(word) != "facet")
                reader.fail(inQuotes(word) + "; expected 'facet' or 'endsolid'");
            readFacet(reader, path);
        }
        reader.restOfLine();  // the name again
    }

    void readFacet(TextReader& reader, const std::filesystem::path& path) {
        expect(reader, "normal");
        // The words are not parsed: they are not used, and some programs write no numbers here.
        for (std::string_view& word : normals_.emplace_back())
            word = reader.token("a component of a normal");
        expect(reader, "outer");
        expect(reader, "loop");
        for (std::size_t corner = 0; corner < 3; ++corner) {
            expect(reader, "vertex");
            Point3& point = positions_.emplace_back();
            Place& place = places_.emplace_back();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                place[axis] = reader.token("a coordinate of a vertex");
                point[axis] =
                    parseCoordinate(place[axis], axis, Precision::Double, path, reader.line());
            }
        }
        expect(reader, "endloop");
        expect(reader, "endfacet");
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient>) const override {
        writeFile(path, [&](std::ostream& out) {
            TextPatch patch(out, bytes_);
            for (std::size_t facet = 0; facet < facetCount(); ++facet) {
                const std::span<const Point3, 3> corners(moved.data() + 3 * facet, 3);
                if (isMoved(facet, corners)) replaceFacet(patch, facet, corners);
            }
            patch.finish();
        });
    }

    void nameOtherData(ModelSurface& surface) const override {
        if (solidCount_ > 1) surface.addOther("solids");
    }

    void replaceFacet(TextPatch& patch, std::size_t facet,
                      std::span<const Point3, 3> corners) const {
        const Point3 normal = facetNormal(corners);
        for (std::size_t axis = 0; axis < 3; ++axis)
            patch.replace(normals_[facet][axis], normal[axis]);
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::size_t point = 3 * facet + corner;
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (corners[corner][axis] != positions_[point][axis])
                    patch.replace(places_[point][axis], corners[corner][axis]);
        }
    }

    std::size_t solidCount_ = 0;
    // Views of bytes_. They stay valid because a model is never copied or moved.
    std::vector<Place> places_;   ///< one per point
    std::vector<Place> normals_;  ///< one per facet
};

bool beginsWithSolid(std::string_view bytes) {
    const std::size_t begin = bytes.find_first_not_of(" \t\r\n");
    return begin != std::string_view::npos && lowerCase(bytes.substr(begin, 5)) == "solid";
}

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

std::unique_ptr<Model> readStl(const std::filesystem::path& path, std::string bytes) {
    std::uint64_t binarySize = kFirstFacet;
    if (bytes.size() >= kFirstFacet)
        binarySize += kFacetSize * std::uint64_t{loadNumber<std::uint32_t>(
                                       bytes.data() + kHeaderSize, std::endian::little)};
    if (bytes.size() == binarySize) return std::make_unique<BinaryStl>(path, std::move(bytes));
    // A text has no byte 0, and nearly every binary file has one.
    if (beginsWithSolid(bytes) && bytes.find('\0') == std::string::npos)
        return std::make_unique<AsciiStl>(path, std::move(bytes));
    throw FileError(path,
                    concat("not an ASCII STL, which begins with 'solid', and not a binary one, ",
                           "which would have ", binarySize, " bytes; got ", bytes.size()));
}

}  // namespace espalier::io
