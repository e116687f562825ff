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
#include <utility>

#include "rotation_fit.h"

namespace espalier::solve {
namespace {

/// Distances at rest below this share of the size of the mesh fulfil a constraint: files of single
/// precision keep 6e-8 of each coordinate.
constexpr double kFulfilled = 1e-6;

/// Distances in a pose above this share of the size break a constraint.
constexpr double kBroken = 1e-10;

std::span<const Index> faceOf(const far::MeshPatch& patch, std::size_t face) {
    return {patch.faces.values.data() + patch.faces.offsets[face],
            patch.faces.values.data() + patch.faces.offsets[face + 1]};
}

std::size_t faceCount(const far::MeshPatch& patch) {
    return patch.faces.offsets.size() - 1;
}

/// Returns the area vector of a face.
Point3 areaOf(std::span<const Index> face, std::span<const Point3> positions) {
    std::vector<Point3> loop;
    for (const Index point : face) loop.push_back(difference(positions[point], positions[face[0]]));
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
    /// The coordinate along a direction in which points of grids do not coincide. Its length is
    /// below 1, so that keys differ by no more than places do.
    static double key(const Point3& place) {
        return 0.61 * place[0] + 0.53 * place[1] + 0.58 * place[2];
    }

    std::vector<Point3> places_;
    std::vector<std::pair<double, std::size_t>> order_;
};

}  // namespace

std::optional<Constraint> constraintOf(const far::MeshPatch& patch) {
    if (patch.type == "symmetry" || patch.type == "symmetryPlane" || patch.type == "wedge")
        return Constraint::Plane;
    if (patch.type == "empty") return Constraint::Sides;
    if (patch.type.starts_with("cyclic") && !patch.partner.empty()) return Constraint::Periodic;
    if (!patch.type.empty() || patch.faces.values.empty()) return std::nullopt;
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
            isFulfilled = findPlanes(patch, checked) &&
                          checked.planes.size() <= (*constraint == Constraint::Sides ? 2u : 1u) &&
                          (checked.planes.size() < 2 || pairSides(checked));
        }
        // Without a second wedge that mirrors it, a wedge is a plane.
        if (isFulfilled && patch.type == "wedge")
            for (const far::MeshPatch& other : patches)
                if (&other != &patch && other.type == "wedge" &&
                    other.points.size() == patch.points.size() && checked.pairs.empty() &&
                    !pairWedges(checked, other))
                    checked.pairs.clear();
        if (isFulfilled)
            checked_.push_back(std::move(checked));
        else
            brokenAtRest_.push_back(number);
    }
}

template <class Visit>
void ConstraintPatches::forEachDistance(const Checked& checked, std::span<const Point3> points,
                                        Visit visit) const {
    for (const Plane& plane : checked.planes)
        for (const Index point : plane.points)
            visit(point, std::abs(dot(difference(points[point], plane.origin), plane.normal)));
    for (const Pair& pair : checked.pairs) {
        if (checked.constraint == Constraint::Sides) {
            visit(pair.point, length(inPlane(difference(points[pair.image], points[pair.point]),
                                             checked.planes[0].normal)));
            continue;
        }
        const Point3 offset = difference(points[pair.point], checked.from);
        const Point3 image = {dot(checked.axes[0], offset), dot(checked.axes[1], offset),
                              dot(checked.axes[2], offset)};
        visit(pair.point, length(difference(points[pair.image], sum(checked.to, image))));
    }
}

bool ConstraintPatches::findPlanes(const far::MeshPatch& patch, Checked& checked) const {
    for (std::size_t number = 0; number < faceCount(patch); ++number) {
        checkCancelledEvery(number, 12);
        const auto face = faceOf(patch, number);
        const auto contains = [&](const Plane& plane) {
            return std::ranges::all_of(face, [&](Index point) {
                return std::abs(dot(difference(rest_[point], plane.origin), plane.normal)) <=
                       kFulfilled * size_;
            });
        };
        auto plane = std::ranges::find_if(checked.planes, contains);
        if (plane == checked.planes.end()) {
            if (checked.planes.size() == 2) return false;
            const Point3 area = areaOf(face, rest_);
            const double size = length(area);
            if (!(size > 0)) return false;
            checked.planes.push_back({rest_[face[0]], scaled(area, 1 / size), {}});
            plane = checked.planes.end() - 1;
        }
        plane->points.insert(plane->points.end(), face.begin(), face.end());
    }
    for (Plane& plane : checked.planes) {
        sortUnique(plane.points);
        // The normal of a single face would be as precise as the face is small: the sum of all is
        // better, and the smallest principal axis of the points is best.
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        for (const Index point : plane.points)
            mean += toEigen(difference(rest_[point], plane.origin));
        mean /= static_cast<double>(plane.points.size());
        Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
        for (const Index point : plane.points) {
            const Eigen::Vector3d offset = toEigen(difference(rest_[point], plane.origin)) - mean;
            moments += offset * offset.transpose();
        }
        const Eigen::JacobiSVD<Eigen::Matrix3d> axes(moments, Eigen::ComputeFullU);
        // Points on a line have no plane of their own: the face has.
        if (axes.singularValues()[1] > kFulfilled * axes.singularValues()[0]) {
            const Eigen::Vector3d normal = axes.matrixU().col(2);
            plane.normal = {normal[0], normal[1], normal[2]};
            plane.origin = sum(plane.origin, {mean[0], mean[1], mean[2]});
        }
    }
    double largest = 0;
    forEachDistance(checked, rest_,
                    [&](Index, double distance) { largest = std::max(largest, distance); });
    return !checked.planes.empty() && largest <= kFulfilled * size_;
}

bool ConstraintPatches::pairSides(Checked& checked) const {
    const Plane &front = checked.planes[0], &back = checked.planes[1];
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

bool ConstraintPatches::pairWedges(Checked& checked, const far::MeshPatch& other) const {
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
    // Face i of one patch is face i of the other one, which goes around in the other direction from
    // the same first corner.
    if (faceCount(patch) != faceCount(partner)) return false;
    std::vector<Pair>& pairs = checked.pairs;
    for (std::size_t number = 0; number < faceCount(patch); ++number) {
        const auto face = faceOf(patch, number), image = faceOf(partner, number);
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
    const Eigen::Matrix3d rotation = rotationBySingularValues(products);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        checked.axes[axis] = {rotation(axis, 0), rotation(axis, 1), rotation(axis, 2)};
    checked.from = sum(base, {mean[0], mean[1], mean[2]});
    checked.to = sum(imageBase, {imageMean[0], imageMean[1], imageMean[2]});
    double largest = 0;
    forEachDistance(checked, rest_,
                    [&](Index, double distance) { largest = std::max(largest, distance); });
    return largest <= kFulfilled * size_;
}

std::vector<PatchDeviation> ConstraintPatches::check(std::span<const Point3> points) const {
    if (points.size() != rest_.size())
        throw Error(concat("got ", points.size(), " positions for ", rest_.size(), " points"));
    std::vector<PatchDeviation> result;
    for (const Checked& checked : checked_) {
        std::vector<double> atRest;
        forEachDistance(checked, rest_,
                        [&](Index, double distance) { atRest.push_back(distance); });
        PatchDeviation& deviation =
            result.emplace_back(PatchDeviation{checked.patch, checked.constraint});
        std::size_t number = 0;
        forEachDistance(checked, points, [&](Index point, double distance) {
            const double more = distance - atRest[number++];
            if (more > deviation.distance) {
                deviation.distance = more;
                deviation.point = point;
            }
        });
        deviation.isBroken = deviation.distance > kBroken * size_;
    }
    return result;
}

}  // namespace espalier::solve
