// SPDX-License-Identifier: Apache-2.0
#include "model_conversion.h"

#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <ostream>
#include <utility>
#include <vector>

#include "coordinates.h"
#include "surface_writers.h"
#include "triangulation.h"

namespace espalier::io {
namespace {

std::string listOfShapes(const std::vector<std::string>& shapes) {
    constexpr std::size_t kMaxNamed = 5;
    std::string text;
    for (std::size_t i = 0; i < std::min(shapes.size(), kMaxNamed); ++i)
        text += (i == 0 ? "" : i + 1 < shapes.size() ? ", " : " and ") + shapes[i];
    return text + (shapes.size() > kMaxNamed ? ", ..." : "");
}

std::string nameOf(const ModelSurface::OtherData& other) {
    constexpr std::size_t kMaxNameBytes = 40;
    std::vector<std::string> quoted;
    for (const std::string& name : other.names)
        quoted.push_back(concat("'", printable(name, kMaxNameBytes), "'"));
    return concat(other.kind, other.names.empty() ? "" : " ", listed(quoted));
}

std::string counted(std::size_t count, const char* singular, const char* plural) {
    return concat(count, " ", count == 1 ? singular : plural);
}

/// Returns per point whether it is a corner of a face.
std::vector<bool> areInFaces(const ModelFaces& faces, std::size_t pointCount) {
    std::vector<bool> isUsed(pointCount);
    for (const Index corner : faces.corners) isUsed[corner] = true;
    return isUsed;
}

}  // namespace

ModelConversion::ModelConversion(const Model& model, const Format& format,
                                 const std::filesystem::path& path)
    : model_(model), format_(format), surface_(model.readSurface()) {
    const std::string from(model.extension()), to(format.extension());
    if (format.holdsAppearance && surface_.faces.count() > 0) {
        for (const std::string& shape : surface_.otherShapes) surface_.addOther(shape);
        surface_.otherShapes.clear();
    }
    if (!surface_.otherShapes.empty())
        throw FileError(path, "a " + to + " cannot hold " + listOfShapes(surface_.otherShapes) +
                                  " of the model; name the output " +
                                  shownPath(std::filesystem::path(path).replace_extension(from)) +
                                  ", or extract the surface of the model first");
    dropSmallFaces();
    if (format.isFacets() && surface_.faces.count() == 0)
        throw FileError(path,
                        "a " + to +
                            " consists of triangles, and the model has no faces; name the output "
                            ".obj or .ply, which can hold points alone");
    // Zero means that there is no direction, in all formats. Not all programs read NaN.
    for (Point3& normal : surface_.normals)
        if (!std::ranges::all_of(normal, [](double x) { return std::isfinite(x); }))
            normal = {0, 0, 0};
    if (format.holdsAppearance)
        readAppearance(model, surface_);
    else
        dropAppearance();
    if (surface_.dropsLoosePoints) dropRepeatedPoints();
    if (format.normals == Format::Normals::Points) moveNormalsToPoints();
    if (format.normals == Format::Normals::Corners) moveNormalsToCorners();
    if (!format.holdsTriangles) return;
    if (format.isFacets() && !surface_.normals.empty())
        surface_.addOther("normals (triangles have their own)");
    splitIntoTriangles();
    const auto inFaces = areInFaces(surface_.faces, model.positions().size());
    // A file without faces has all its points.
    if (const std::size_t loose = std::ranges::count(inFaces, false);
        loose > 0 && surface_.faces.count() > 0 && !surface_.dropsLoosePoints)
        surface_.addOther(counted(loose, "point in no face", "points in no face"));
    if (model.storage() != CoordinateStorage::Float)
        changes_.push_back("coordinates are rounded to single precision");
}

void ModelConversion::dropSmallFaces() {
    std::size_t dropped = 0, begin = 0;
    for (const std::size_t end : surface_.faces.ends) {
        dropped += end - begin < 3 ? 1 : 0;
        begin = end;
    }
    if (dropped == 0) return;
    const bool hadNormalCorners = !surface_.normalCorners.empty();
    surface_.replaceFaces([&](std::size_t face) -> std::vector<std::vector<std::size_t>> {
        const std::size_t size = surface_.faces[face].size();
        if (size < 3) return {};
        std::vector<std::size_t> all(size);
        std::iota(all.begin(), all.end(), std::size_t{0});
        return {all};
    });
    surface_.addOther(counted(dropped, "face", "faces") + " of fewer than three corners");
    // Without corners, these normals would count as normals of points.
    if (hadNormalCorners && surface_.normalCorners.empty()) surface_.normals.clear();
}

void ModelConversion::dropRepeatedPoints() {
    const auto inFaces = areInFaces(surface_.faces, model_.positions().size());
    points_.emplace();
    std::vector<Index> newNumbers(inFaces.size());
    for (std::size_t point = 0; point < inFaces.size(); ++point) {
        newNumbers[point] = static_cast<Index>(points_->size());
        if (inFaces[point]) points_->push_back(static_cast<Index>(point));
    }
    for (Index& corner : surface_.faces.corners) corner = newNumbers[corner];
    if (!surface_.colors.empty())
        surface_.colors = valuesOf(std::span<const std::array<float, 4>>(surface_.colors));
}

void ModelConversion::splitIntoTriangles() {
    const auto rest = model_.positions();
    std::size_t splitCount = 0, partCount = 0;
    std::vector<Point3> polygon;
    surface_.replaceFaces([&](std::size_t face) {
        // The triangles follow from the positions at rest, so all poses have the same triangles.
        polygon.clear();
        for (const Index corner : surface_.faces[face])
            polygon.push_back(rest[points_ ? (*points_)[corner] : corner]);
        std::vector<std::vector<std::size_t>> parts;
        for (const auto& part : triangulated(polygon)) parts.emplace_back(part.begin(), part.end());
        splitCount += parts.size() > 1 ? 1 : 0;
        partCount += parts.size() > 1 ? parts.size() : 0;
        return parts;
    });
    if (splitCount > 0)
        changes_.push_back(concat(counted(splitCount, "face is", "faces are"), " split into ",
                                  partCount, " triangles"));
}

/// Names texture coordinates, colours and materials, and drops them, if the format lacks them.
void ModelConversion::dropAppearance() {
    if (!surface_.textureCorners.empty()) surface_.addOther("texture coordinates");
    if (!surface_.colors.empty()) surface_.addOther("colours of points");
    if (!surface_.faceMaterials.empty()) surface_.addOther("materials");
    surface_.textures.clear();
    surface_.textureCorners.clear();
    surface_.colors.clear();
    surface_.materials.clear();
    surface_.faceMaterials.clear();
}

/// Gives each point the normal of its corners, if they agree.
void ModelConversion::moveNormalsToPoints() {
    if (surface_.normalCorners.empty()) return;
    const ModelFaces& faces = surface_.faces;
    const std::vector<Index> normalCorners = std::move(surface_.normalCorners);
    surface_.normalCorners.clear();
    std::vector<Point3> atPoints(points_ ? points_->size() : model_.positions().size());
    std::vector<bool> isSet(atPoints.size()), isSplit(atPoints.size());
    for (std::size_t corner = 0; corner < faces.corners.size(); ++corner) {
        const Index point = faces.corners[corner];
        const Point3& normal = surface_.normals[normalCorners[corner]];
        isSplit[point] = isSplit[point] || (isSet[point] && atPoints[point] != normal);
        isSet[point] = true;
        atPoints[point] = normal;
    }
    surface_.normals = std::move(atPoints);
    const std::size_t splitCount = std::ranges::count(isSplit, true);
    if (splitCount == 0) return;
    surface_.normals.clear();
    surface_.addOther(concat("normals (", counted(splitCount, "point has", "points have"),
                             " several, of which a ", format_.extension(), " holds one)"));
}

/// Gives each corner the normal of its point.
void ModelConversion::moveNormalsToCorners() {
    if (surface_.normals.empty() || !surface_.normalCorners.empty()) return;
    surface_.normalCorners = surface_.faces.corners;
    if (!surface_.normalCorners.empty()) return;
    surface_.normals.clear();
    surface_.addOther("normals (the model has no faces)");
}

std::string ModelConversion::losses(const std::filesystem::path& path) const {
    std::vector<std::string> parts = changes_;
    if (!surface_.others.empty()) {
        std::string names;
        for (const auto& other : surface_.others)
            names += (names.empty() ? "" : ", ") + nameOf(other);
        parts.insert(parts.begin(),
                     concat("the ", model_.extension(), " has data that are not written: ", names));
    }
    std::string text;
    for (const std::string& part : parts)
        text += (text.empty() ? shownPath(path) + ": " : "; ") + part;
    return text;
}

void ModelConversion::write(const std::filesystem::path& path, std::span<const Point3> positions,
                            std::span<const DeformationGradient> gradients) const {
    std::vector<Point3> normals = surface_.normals;
    std::vector<Index> normalCorners = surface_.normalCorners;
    if (!gradients.empty()) carryNormals(gradients, normals, normalCorners);
    const std::vector<Point3> written = pointsOf(positions);
    SurfaceView surface = restSurface(path, written);
    surface.normals = normals;
    surface.normalCorners = normalCorners;
    writeFile(path, [&](std::ostream& out) { format_.writeSurface(out, surface); });
}

SurfaceView ModelConversion::restSurface(const std::filesystem::path& path,
                                         std::span<const Point3> points) const {
    return {points, surface_.faces, surface_.normals, surface_.normalCorners, path, &surface_};
}

void ModelConversion::carryNormals(std::span<const DeformationGradient> gradients,
                                   std::vector<Point3>& normals,
                                   std::vector<Index>& normalCorners) const {
    if (normalCorners.empty()) {
        if (!normals.empty())
            normals = carried(normals, valuesOf(gradients), carryNormal, Precision::Double);
        return;
    }
    // Corners that shared a normal share the result, if they agree on it.
    std::map<std::pair<Index, Point3>, Index> numbers;
    std::vector<Point3> results;
    for (std::size_t corner = 0; corner < normalCorners.size(); ++corner) {
        const Index before = normalCorners[corner];
        const Point3& normal = normals[before];
        const Index point = surface_.faces.corners[corner];
        const Point3 result =
            carried({&normal, 1}, {&gradients[points_ ? (*points_)[point] : point], 1}, carryNormal,
                    Precision::Double)[0];
        const auto [number, isNew] =
            numbers.try_emplace({before, result}, static_cast<Index>(results.size()));
        if (isNew) results.push_back(result);
        normalCorners[corner] = number->second;
    }
    normals = std::move(results);
}

}  // namespace espalier::io
