// SPDX-License-Identifier: Apache-2.0
#include "model_conversion.h"

#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cmath>
#include <map>
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

/// Returns the values of some points.
template <class Value>
std::vector<Value> at(const std::vector<Index>& points, std::span<const Value> values) {
    std::vector<Value> result;
    for (const Index point : points) result.push_back(values[point]);
    return result;
}

}  // namespace

ModelConversion::ModelConversion(const Model& model, const Format& format,
                                 const std::filesystem::path& path)
    : model_(model), format_(format), surface_(model.readSurface()) {
    const std::string from(model.extension()), to(format.extension());
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
    if (surface_.repeatsPoints) dropRepeatedPoints();
    if (format.normals == Format::Normals::Points) moveNormalsToPoints();
    if (format.normals == Format::Normals::Corners) moveNormalsToCorners();
    if (!format.isFacets()) return;
    if (!surface_.normals.empty()) surface_.addOther("normals (triangles have their own)");
    splitIntoTriangles();
    const auto inFaces = areInFaces(surface_.faces, model.positions().size());
    if (const std::size_t loose = std::ranges::count(inFaces, false);
        loose > 0 && !surface_.repeatsPoints)
        surface_.addOther(counted(loose, "point in no face", "points in no face"));
    if (model.storage() != CoordinateStorage::Float)
        changes_.push_back("coordinates are rounded to single precision");
}

void ModelConversion::dropSmallFaces() {
    const ModelFaces faces = std::move(surface_.faces);
    const std::vector<Index> normalCorners = std::move(surface_.normalCorners);
    surface_.faces = {};
    surface_.normalCorners.clear();
    std::size_t dropped = 0;
    for (std::size_t face = 0; face < faces.count(); ++face) {
        const auto loop = faces[face];
        if (loop.size() < 3) {
            ++dropped;
            continue;
        }
        for (std::size_t i = faces.ends[face] - loop.size(); i < faces.ends[face]; ++i) {
            surface_.faces.corners.push_back(faces.corners[i]);
            if (!normalCorners.empty()) surface_.normalCorners.push_back(normalCorners[i]);
        }
        surface_.faces.endFace();
    }
    if (dropped == 0) return;
    surface_.addOther(counted(dropped, "face", "faces") + " of fewer than three corners");
    // Without corners, these normals would count as normals of points.
    if (!normalCorners.empty() && surface_.normalCorners.empty()) surface_.normals.clear();
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
}

void ModelConversion::splitIntoTriangles() {
    const auto rest = model_.positions();
    ModelFaces triangles;
    std::size_t splitCount = 0, partCount = 0;
    std::vector<Point3> polygon;
    for (std::size_t face = 0; face < surface_.faces.count(); ++face) {
        const auto loop = surface_.faces[face];
        // The triangles follow from the positions at rest, so all poses have the same triangles.
        polygon.clear();
        for (const Index corner : loop)
            polygon.push_back(rest[points_ ? (*points_)[corner] : corner]);
        const auto parts = triangulated(polygon);
        splitCount += parts.size() > 1 ? 1 : 0;
        partCount += parts.size() > 1 ? parts.size() : 0;
        for (const auto& part : parts) {
            for (const std::size_t corner : part) triangles.corners.push_back(loop[corner]);
            triangles.endFace();
        }
    }
    surface_.faces = std::move(triangles);
    if (splitCount > 0)
        changes_.push_back(concat(counted(splitCount, "face is", "faces are"), " split into ",
                                  partCount, " triangles"));
}

/// Gives each point the normal of its corners, if they agree.
void ModelConversion::moveNormalsToPoints() {
    if (surface_.normalCorners.empty()) return;
    const ModelFaces& faces = surface_.faces;
    const std::vector<Index> normalCorners = std::move(surface_.normalCorners);
    surface_.normalCorners.clear();
    std::vector<Point3> atPoints(model_.positions().size());
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
    std::vector<Point3> written;
    if (points_) positions = written = at(*points_, positions);
    writeFile(path, [&](std::ostream& out) {
        format_.writeSurface(out, {positions, surface_.faces, normals, normalCorners});
    });
}

void ModelConversion::carryNormals(std::span<const DeformationGradient> gradients,
                                   std::vector<Point3>& normals,
                                   std::vector<Index>& normalCorners) const {
    if (normalCorners.empty()) {
        if (!normals.empty()) normals = carried(normals, gradients, carryNormal, Precision::Double);
        return;
    }
    // Corners that shared a normal share the result, if they agree on it.
    std::map<std::pair<Index, Point3>, Index> numbers;
    std::vector<Point3> results;
    for (std::size_t corner = 0; corner < normalCorners.size(); ++corner) {
        const Index before = normalCorners[corner];
        const Point3& normal = normals[before];
        const Point3 result = carried({&normal, 1}, {&gradients[surface_.faces.corners[corner]], 1},
                                      carryNormal, Precision::Double)[0];
        const auto [number, isNew] =
            numbers.try_emplace({before, result}, static_cast<Index>(results.size()));
        if (isNew) results.push_back(result);
        normalCorners[corner] = number->second;
    }
    normals = std::move(results);
}

}  // namespace espalier::io
