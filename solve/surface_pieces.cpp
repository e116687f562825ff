// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "principal_axes.h"
#include "rotation_fit.h"
#include "surface_pieces.h"

namespace espalier::solve {
namespace {

using Positions = std::span<const Point3>;

/// Returns the normal of a face, whose length is the square root of the area.
Point3 normalOf(std::span<const Index> corners, Positions positions) {
    std::vector<Point3> loop;
    for (const Index corner : corners) loop.push_back(positions[corner]);
    const Point3 area = areaVector(loop);
    const double size = sizeOf(area);
    return size > 0 ? scaled(area, 1 / std::sqrt(size)) : area;
}

/// Sums over pairs of places at rest and in a pose, relative to a point at rest and in the pose.
struct Moments {
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();  ///< Σ y xᵀ
    Eigen::Vector3d rest = Eigen::Vector3d::Zero();      ///< Σ x
    Eigen::Vector3d pose = Eigen::Vector3d::Zero();      ///< Σ y
    double count = 0;

    void add(const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
        products += y * x.transpose();
        rest += x;
        pose += y;
        ++count;
    }

    /// Adds sums relative to another point, which is at (x, y) from the point of these sums.
    void add(const Moments& other, const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
        products += other.products + other.pose * x.transpose() + y * other.rest.transpose() +
                    other.count * y * x.transpose();
        rest += other.rest + other.count * x;
        pose += other.pose + other.count * y;
        count += other.count;
    }

    Eigen::Matrix3d covariance() const { return products - pose * rest.transpose() / count; }
};

/// Returns for each point the sums over the corners of its faces.
std::vector<Moments> momentsOfPoints(const far::SurfaceMesh& mesh, Positions rest, Positions pose) {
    std::vector<Moments> result(mesh.pointCount());
    for (Index face = 0; face < mesh.faceCount(); ++face) {
        checkCancelledEvery(face, 12);
        const auto corners = mesh.corners(face);
        for (const Index point : corners)
            for (const Index corner : corners)
                result[point].add(toEigen(difference(rest[corner], rest[point])),
                                  toEigen(difference(pose[corner], pose[point])));
    }
    return result;
}

}  // namespace

SurfacePieces::SurfacePieces(const far::SurfaceMesh& mesh, Positions rest)
    : mesh_(mesh), rest_(rest.begin(), rest.end()), normals_(mesh.faceCount()) {
    std::vector<Index> facesAt(mesh_.pointCount(), 0);
    for (Index face = 0; face < mesh_.faceCount(); ++face) {
        checkCancelledEvery(face, 12);
        normals_[face] = normalOf(mesh_.corners(face), rest_);
        for (const Index point : mesh_.points(face)) ++facesAt[point];
    }
    for (Index point = 0; point < mesh_.pointCount(); ++point)
        if (facesAt[point] > 0) points_.push_back(point);
    for (Index face = 0; face < mesh_.faceCount(); ++face)
        isolatedFaces_ += std::ranges::all_of(mesh_.corners(face),
                                              [&](Index point) { return facesAt[point] == 1; });
    // Files of single precision keep 6e-8 of each coordinate.
    constexpr double kPlanar = 1e-6;
    plane_ = planeNormal(rest_, kPlanar);
}

std::optional<Point3> SurfacePieces::planeNormal(Positions positions, double tolerance) const {
    if (points_.size() < 3) return std::nullopt;
    const PrincipalAxes axes(points_, positions);
    const Point3& normal = axes.directions[2];
    double thickness = 0, size = 0;
    for (const Index point : points_) {
        const Point3 offset = difference(positions[point], axes.mean);
        thickness = std::max(thickness, std::abs(dot(offset, normal)));
        size = std::max(size, sizeOf(offset));
    }
    if (!(thickness <= tolerance * size)) return std::nullopt;
    return normal;
}

bool SurfacePieces::usesNeighbours(Positions positions) const {
    return !planeOf(positions);
}

std::optional<Point3> SurfacePieces::planeOf(Positions positions) const {
    // cos 30°. Beyond it, a plane that turned over could not be told from a mirrored one.
    constexpr double kLeastCosine = 0.866;
    constexpr double kNearlyPlanar = 0.01;
    if (!plane_) return std::nullopt;
    const auto normal = planeNormal(positions, kNearlyPlanar);
    if (!normal) return std::nullopt;
    const double cosine = dot(*normal, *plane_);
    if (!(std::abs(cosine) >= kLeastCosine)) return std::nullopt;
    return scaled(*normal, std::copysign(1.0, cosine));
}

std::vector<Point3> SurfacePieces::withNormals(Positions positions) const {
    std::vector<Point3> result;
    result.reserve(positions.size() + normals_.size());
    result.assign(positions.begin(), positions.end());
    result.insert(result.end(), normals_.begin(), normals_.end());
    if (std::ranges::equal(positions, rest_)) return result;
    if (const auto plane = planeOf(positions)) {
        for (Index face = 0; face < mesh_.faceCount(); ++face)
            result[positions.size() + face] =
                scaled(*plane, std::copysign(sizeOf(normals_[face]), dot(normals_[face], *plane_)));
        return result;
    }
    const std::vector<Moments> moments = momentsOfPoints(mesh_, rest_, positions);
    constexpr Offset kFaces = 1024;  // of one task
    parallelFor(mesh_.faceCount(), kFaces, [&](Offset first, Offset last) {
        for (auto face = static_cast<Index>(first); face < last; ++face) {
            checkCancelledEvery(face, 8);
            Moments around;
            const auto corners = mesh_.corners(face);
            for (const Index corner : corners)
                around.add(moments[corner], toEigen(difference(rest_[corner], rest_[corners[0]])),
                           toEigen(difference(positions[corner], positions[corners[0]])));
            const Eigen::Vector3d normal =
                rotationBySingularValues(around.covariance()) * toEigen(normals_[face]);
            result[positions.size() + face] = {normal[0], normal[1], normal[2]};
        }
    });
    return result;
}

Piece<0> SurfacePieces::triangle(Index face, std::size_t corner, Positions positions) const {
    const auto corners = mesh_.corners(face);
    const auto at = [&](std::size_t i) -> const Point3& {
        return positions[corners[(corner + i) % corners.size()]];
    };
    Piece<0> piece;
    piece.derivatives[0][0] = difference(at(1), at(0));
    piece.derivatives[1][0] = difference(at(corners.size() - 1), at(0));
    piece.derivatives[2][0] = positions[mesh_.pointCount() + face];
    for (std::size_t axis = 0; axis < 3; ++axis)
        piece.size.lengths[axis] = sizeOf(piece.derivatives[axis][0]);
    piece.size.uncertainty = meshUncertainty(corners, positions);
    return piece;
}

}  // namespace espalier::solve
