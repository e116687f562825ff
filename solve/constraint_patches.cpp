// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/solve/constraint_patches.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "piece.h"
#include "principal_axes.h"
#include "rotation_fit.h"

namespace espalier::solve {
namespace {

/// Distances at rest below this share of the size of the mesh fulfil a constraint: files of single
/// precision keep 6e-8 of each coordinate.
constexpr double kFulfilled = 1e-6;

/// Distances in a pose above this share of the size break a constraint.
constexpr double kBroken = 1e-10;

/// Returns the area vector of a face.
Point3 areaOf(std::span<const Index> face, std::span<const Point3> positions) {
    std::vector<Point3> loop;
    for (const Index point : face) loop.push_back(positions[point]);
    return areaVector(loop);
}

/// Returns a point moved into a plane through the origin.
Point3 inPlane(const Point3& point, const Point3& normal) {
    return difference(point, scaled(normal, dot(point, normal)));
}

/// Finds the nearest of some places.
class PlaceSearch {
public:
    explicit PlaceSearch(std::vector<Point3> places)
        : places_(std::move(places)), order_(places_.size()) {
        for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = {key(places_[i]), i};
        std::ranges::sort(order_);
    }

    /// Returns the nearest place within a distance.
    std::optional<std::size_t> nearest(const Point3& to, double distance) const {
        std::optional<std::size_t> found;
        const double at = key(to);
        auto next = std::lower_bound(order_.begin(), order_.end(),
                                     std::pair(at - distance, std::size_t{0}));
        for (; next != order_.end() && next->first <= at + distance; ++next) {
            const double own = length(difference(places_[next->second], to));
            if (own > distance) continue;
            distance = own;
            found = next->second;
        }
        return found;
    }

private:
    /// Returns the coordinate along an oblique vector, which differs for the points of a grid. The
    /// vector is shorter than 1, so the keys of two places differ by at most their distance.
    static double key(const Point3& place) {
        return 0.61 * place[0] + 0.53 * place[1] + 0.58 * place[2];
    }

    std::vector<Point3> places_;
    std::vector<std::pair<double, std::size_t>> order_;
};

}  // namespace

std::optional<Constraint> constraintOf(const far::MeshPatch& patch) {
    for (const char* type : {"symmetry", "symmetryPlane", "wedge", "BCSymmetryPlane"})
        if (patch.type == type) return Constraint::Plane;
    if (patch.type == "empty") return Constraint::Sides;
    if (!patch.partner.empty() && (patch.type.empty() || patch.type.starts_with("cyclic") ||
                                   patch.type == "periodic" || patch.type == "shadow"))
        return Constraint::Periodic;
    if (!patch.type.empty() || patch.dimension == 3) return std::nullopt;
    std::string name = patch.name;
    for (char& c : name)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return name.find("symm") == std::string::npos ? std::nullopt : std::optional(Constraint::Plane);
}

ConstraintPatches::ConstraintPatches(std::span<const far::MeshPatch> patches,
                                     std::span<const Point3> rest)
    : rest_(rest.begin(), rest.end()) {
    if (!rest.empty()) {
        Point3 low = rest[0], high = rest[0];
        for (const Point3& point : rest)
            for (std::size_t c = 0; c < 3; ++c) {
                low[c] = std::min(low[c], point[c]);
                high[c] = std::max(high[c], point[c]);
            }
        size_ = length(difference(high, low));
        constexpr double kUnits = 8 * std::numeric_limits<double>::epsilon();
        rounding_ = kUnits * std::max(largestCoordinate(low), largestCoordinate(high));
    }
    for (std::size_t number = 0; number < patches.size(); ++number) {
        const far::MeshPatch& patch = patches[number];
        const auto constraint = constraintOf(patch);
        if (!constraint || patch.points.empty()) continue;
        Checked checked{number, *constraint};
        bool isFulfilled = false;
        if (*constraint == Constraint::Periodic) {
            const auto partner = std::ranges::find(patches, patch.partner, &far::MeshPatch::name);
            isFulfilled = partner != patches.end() && findMotion(patch, *partner, checked);
        } else {
            // A family of CGNS may have the symmetry planes on both sides of a mesh.
            const bool isOne = patch.type == "symmetryPlane" || patch.type == "wedge";
            const std::size_t mostPlanes = isOne ? 1 : 2;
            isFulfilled = findPlanes(patch, checked) && checked.planes.size() <= mostPlanes;
        }
        if (isFulfilled)
            checked_.push_back(std::move(checked));
        else
            brokenAtRest_.push_back(number);
    }
    pairPlanes(patches);
    std::ranges::sort(brokenAtRest_);
}

void ConstraintPatches::pairPlanes(std::span<const far::MeshPatch> patches) {
    std::vector<Checked> kept;
    const auto pairWith = [&](Checked& checked, const auto& pair) {
        // A wedge has its partner in another patch, and so may a side.
        for (const Checked& other : checked_) {
            if (other.patch == checked.patch || other.constraint != checked.constraint ||
                patches[other.patch].type != patches[checked.patch].type ||
                other.planes.size() != 1)
                continue;
            if (pair(other.planes[0])) return true;
            checked.pairs.clear();
        }
        return false;
    };
    for (Checked checked : checked_) {
        bool isFulfilled = true;
        if (checked.constraint == Constraint::Sides && checked.planes.size() == 2)
            isFulfilled = pairSides(checked, checked.planes[0], checked.planes[1]);
        else if (checked.constraint == Constraint::Sides)
            // Without another side, the points have no opposite ones.
            pairWith(checked, [&](const Plane& back) {
                return pairSides(checked, checked.planes[0], back);
            });
        else if (patches[checked.patch].type == "wedge")
            pairWith(checked, [&](const Plane& other) { return pairWedges(checked, other); });
        if (isFulfilled)
            kept.push_back(std::move(checked));
        else
            brokenAtRest_.push_back(checked.patch);
    }
    checked_ = std::move(kept);
}

template <class Visit>
void ConstraintPatches::forEachDistance(const Checked& checked, std::span<const Point3> points,
                                        Visit visit) const {
    for (const Plane& plane : checked.planes)
        for (const Index point : plane.points)
            visit(point, std::abs(dot(difference(points[point], plane.origin), plane.normal)),
                  false);
    for (const Pair& pair : checked.pairs) {
        if (checked.constraint == Constraint::Sides) {
            visit(pair.point,
                  length(inPlane(difference(points[pair.image], points[pair.point]),
                                 checked.planes[0].normal)),
                  true);
            continue;
        }
        const Point3 offset = difference(points[pair.point], checked.from);
        const Point3 image = {dot(checked.axes[0], offset), dot(checked.axes[1], offset),
                              dot(checked.axes[2], offset)};
        visit(pair.point, length(difference(points[pair.image], sum(checked.to, image))), true);
    }
}

/// Fits the plane to its points, if they are not on a line.
void ConstraintPatches::fitPlane(Plane& plane) const {
    sortUnique(plane.points);
    const PrincipalAxes axes(plane.points, rest_);
    if (!(axes.extents[1] > kFulfilled * axes.extents[0])) return;
    plane.origin = axes.mean;
    plane.normal = axes.directions[2];
}

bool ConstraintPatches::findPlanes(const far::MeshPatch& patch, Checked& checked) const {
    const auto isFar = [&](const Plane& plane, double tolerance) {
        return [&plane, tolerance, this](Index point) {
            return !(std::abs(dot(difference(rest_[point], plane.origin), plane.normal)) <=
                     tolerance);
        };
    };
    if (patch.dimension <= 1) {
        std::vector<Index> all(rest_.size());
        std::iota(all.begin(), all.end(), 0);
        const PrincipalAxes ofMesh(all, rest_), ofPatch(patch.points, rest_);
        const bool isPlanarMesh = ofMesh.extents[2] <= kFulfilled * size_;
        // A line of a mesh in a plane: the plane through the line, perpendicular to the mesh. A set
        // of points in space: their plane, unless they are on a line.
        if (!isPlanarMesh &&
            (patch.dimension == 1 || !(ofPatch.extents[1] > kFulfilled * ofPatch.extents[0])))
            return false;
        checked.planes.push_back({ofPatch.mean,
                                  isPlanarMesh ? cross(ofMesh.directions[2], ofPatch.directions[0])
                                               : ofPatch.directions[2],
                                  patch.points});
        return std::ranges::none_of(patch.points, isFar(checked.planes[0], kFulfilled * size_));
    }
    if (patch.faces.empty()) {
        Plane plane{{}, {}, patch.points};
        fitPlane(plane);
        checked.planes.push_back(std::move(plane));
        return length(checked.planes[0].normal) > 0 &&
               std::ranges::none_of(patch.points, isFar(checked.planes[0], kFulfilled * size_));
    }
    std::vector<Index> left(patch.faceCount());
    std::iota(left.begin(), left.end(), 0);
    std::vector<Point3> areas;
    for (const Index face : left) areas.push_back(areaOf(patch.faces[face], rest_));
    while (!left.empty()) {
        if (checked.planes.size() == 2) return false;
        // The normal of one face is as precise as the face is small. So the plane of the largest
        // face collects faces roughly, and then its points determine it.
        constexpr double kRoughly = 1e-3;
        const Index largest = *std::max_element(left.begin(), left.end(), [&](Index a, Index b) {
            return dot(areas[a], areas[a]) < dot(areas[b], areas[b]);
        });
        const double size = length(areas[largest]);
        if (!(size > 0)) return false;
        Plane plane{rest_[patch.faces[largest][0]], scaled(areas[largest], 1 / size), {}};
        for (const double tolerance : {kRoughly * size_, kFulfilled * size_}) {
            std::vector<Index> points;
            for (const Index face : left) {
                const auto corners = patch.faces[face];
                if (std::ranges::none_of(corners, isFar(plane, tolerance)))
                    points.insert(points.end(), corners.begin(), corners.end());
            }
            if (points.empty()) return false;
            plane.points = std::move(points);
            fitPlane(plane);
        }
        std::vector<Index> others;
        for (const Index face : left)
            if (!std::ranges::none_of(patch.faces[face], isFar(plane, kFulfilled * size_)))
                others.push_back(face);
        if (others.size() == left.size()) return false;
        left = std::move(others);
        checked.planes.push_back(std::move(plane));
    }
    return !checked.planes.empty();
}

bool ConstraintPatches::pairSides(Checked& checked, const Plane& front, const Plane& back) const {
    if (length(cross(front.normal, back.normal)) > kFulfilled) return false;
    const auto project = [&](Index point) {
        return inPlane(difference(rest_[point], front.origin), front.normal);
    };
    std::vector<Point3> places;
    for (const Index point : back.points) places.push_back(project(point));
    const PlaceSearch opposite(std::move(places));
    for (const Index point : front.points) {
        const auto found = opposite.nearest(project(point), kFulfilled * size_);
        if (!found) return false;
        checked.pairs.push_back({point, back.points[*found]});
    }
    return true;
}

bool ConstraintPatches::pairWedges(Checked& checked, const Plane& other) const {
    if (other.points.size() != checked.planes[0].points.size()) return false;
    const auto meanOf = [&](std::span<const Index> points) {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        for (const Index point : points)
            mean += toEigen(difference(rest_[point], rest_[points[0]])) /
                    static_cast<double>(points.size());
        return sum(rest_[points[0]], {mean[0], mean[1], mean[2]});
    };
    const Point3 from = meanOf(checked.planes[0].points), to = meanOf(other.points);
    const Point3 between = difference(to, from);
    const double distance = length(between);
    if (!(distance > 0)) return false;
    const Point3 normal = scaled(between, 1 / distance);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        checked.axes[axis] = scaled(normal, -2 * normal[axis]);
        checked.axes[axis][axis] += 1;
    }
    checked.from = from;
    checked.to = to;
    std::vector<Point3> places;
    for (const Index point : other.points) places.push_back(rest_[point]);
    const PlaceSearch images(std::move(places));
    for (const Index point : checked.planes[0].points) {
        const Point3 offset = difference(rest_[point], from);
        const auto found =
            images.nearest(sum(to, {dot(checked.axes[0], offset), dot(checked.axes[1], offset),
                                    dot(checked.axes[2], offset)}),
                           kFulfilled * size_);
        if (!found) return false;
        checked.pairs.push_back({point, other.points[*found]});
    }
    return true;
}

bool ConstraintPatches::findMotion(const far::MeshPatch& patch, const far::MeshPatch& partner,
                                   Checked& checked) const {
    std::vector<Pair>& pairs = checked.pairs;
    for (const auto& [point, image] : patch.images) pairs.push_back({point, image});
    const bool hasImages = !patch.images.empty();
    if (!hasImages && patch.faceCount() != partner.faceCount()) return false;
    for (Index number = 0; !hasImages && number < patch.faceCount(); ++number) {
        const auto face = patch.faces[number], image = partner.faces[number];
        if (face.size() != image.size()) return false;
        for (std::size_t i = 0; i < face.size(); ++i)
            pairs.push_back({face[i], image[(image.size() - i) % image.size()]});
    }
    if (pairs.empty()) return false;
    std::ranges::sort(pairs, [](const Pair& a, const Pair& b) {
        return std::pair(a.point, a.image) < std::pair(b.point, b.image);
    });
    const auto twice = std::unique(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
        return a.point == b.point && a.image == b.image;
    });
    pairs.erase(twice, pairs.end());
    const Point3 base = rest_[pairs[0].point], imageBase = rest_[pairs[0].image];
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), imageMean = mean;
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    const auto count = static_cast<double>(pairs.size());
    for (const Pair& pair : pairs) {
        mean += toEigen(difference(rest_[pair.point], base)) / count;
        imageMean += toEigen(difference(rest_[pair.image], imageBase)) / count;
    }
    for (const Pair& pair : pairs)
        products += (toEigen(difference(rest_[pair.image], imageBase)) - imageMean) *
                    (toEigen(difference(rest_[pair.point], base)) - mean).transpose();
    if (patch.dimension == 1) {
        // A line determines no rotation around itself. The normal of the plane mesh stays.
        std::vector<Index> all(rest_.size());
        std::iota(all.begin(), all.end(), 0);
        const Eigen::Vector3d normal = toEigen(PrincipalAxes(all, rest_).directions[2]);
        products += count * size_ * size_ * normal * normal.transpose();
    }
    const Eigen::Matrix3d rotation = rotationBySingularValues(products);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        checked.axes[axis] = {rotation(axis, 0), rotation(axis, 1), rotation(axis, 2)};
    checked.from = sum(base, {mean[0], mean[1], mean[2]});
    checked.to = sum(imageBase, {imageMean[0], imageMean[1], imageMean[2]});
    double largest = 0;
    forEachDistance(checked, rest_,
                    [&](Index, double distance, bool) { largest = std::max(largest, distance); });
    return largest <= kFulfilled * size_;
}

std::vector<CoupledFace> ConstraintPatches::coupledFaces(
    std::span<const far::MeshPatch> patches) const {
    std::vector<CoupledFace> coupled;
    for (const Checked& checked : checked_) {
        const far::MeshPatch& patch = patches[checked.patch];
        if (patch.type != "cyclic") continue;
        const auto partner = std::ranges::find(patches, patch.partner, &far::MeshPatch::name);
        if (!patch.firstFace || !partner->firstFace) continue;
        // The motion goes from the patch to its partner.
        CoupledFace face;
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 3; ++column)
                face.rotation[row][column] = checked.axes[column][row];
        for (Index i = 0; i < patch.faceCount(); ++i) {
            face.face = *patch.firstFace + i;
            face.image = *partner->firstFace + i;
            coupled.push_back(face);
        }
    }
    return coupled;
}

std::vector<PatchDeviation> ConstraintPatches::check(std::span<const Point3> points) const {
    if (points.size() != rest_.size())
        throw Error(concat("got ", points.size(), " positions for ", rest_.size(), " points"));
    std::vector<PatchDeviation> result;
    for (const Checked& checked : checked_) {
        std::vector<double> atRest;
        forEachDistance(checked, rest_,
                        [&](Index, double distance, bool) { atRest.push_back(distance); });
        PatchDeviation& deviation =
            result.emplace_back(PatchDeviation{checked.patch, checked.constraint});
        std::size_t number = 0;
        forEachDistance(checked, points, [&](Index point, double distance, bool isFromImage) {
            const double more = distance - atRest[number++];
            if (more > deviation.distance) {
                deviation.distance = more;
                deviation.point = point;
                deviation.isFromImage = isFromImage;
            }
        });
        deviation.isBroken = deviation.distance > std::max(kBroken * size_, rounding_);
    }
    return result;
}

}  // namespace espalier::solve
