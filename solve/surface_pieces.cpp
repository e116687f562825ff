// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "rotation_fit.h"
#include "surface_pieces.h"

namespace espalier::solve {
namespace {

using Positions = std::span<const Point3>;

/// Returns the normal of a face, whose length is the square root of the area.
Point3 normalOf(std::span<const Index> corners, Positions positions) {
    // Relative to a corner, so that a face far from the origin loses no digits.
    std::vector<Point3> loop;
    for (const Index corner : corners)
        loop.push_back(difference(positions[corner], positions[corners[0]]));
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
    Point3 widest{};
    for (Index face = 0; face < mesh_.faceCount(); ++face) {
        checkCancelledEvery(face, 12);
        normals_[face] = normalOf(mesh_.corners(face), rest_);
        if (dot(normals_[face], normals_[face]) <= dot(widest, widest)) continue;
        widest = normals_[face];
        origin_ = rest_[mesh_.points(face)[0]];
    }
    const double width = sizeOf(widest);
    if (width > 0) plane_ = scaled(widest, 1 / width);
    double size = 0;
    for (Index face = 0; face < mesh_.faceCount(); ++face)
        for (const Index point : mesh_.points(face))
            size = std::max(size, sizeOf(difference(rest_[point], origin_)));
    constexpr double kSinglePrecision = 1e-6;
    tolerance_ = kSinglePrecision * size;
    isPlanar_ = liesInPlane(rest_);
    if (isPlanar_)
        for (Point3& normal : normals_)
            normal = scaled(plane_, std::copysign(sizeOf(normal), dot(normal, plane_)));
}

bool SurfacePieces::liesInPlane(Positions positions) const {
    for (Index face = 0; face < mesh_.faceCount(); ++face)
        for (const Index point : mesh_.points(face))
            if (!(std::abs(dot(difference(positions[point], origin_), plane_)) <= tolerance_))
                return false;
    return true;
}

std::vector<Point3> SurfacePieces::withNormals(Positions positions) const {
    std::vector<Point3> result;
    result.reserve(positions.size() + normals_.size());
    result.assign(positions.begin(), positions.end());
    result.insert(result.end(), normals_.begin(), normals_.end());
    const bool isAtRest = std::ranges::equal(positions, rest_);
    if (isAtRest || (isPlanar_ && liesInPlane(positions))) return result;
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
