// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <cstddef>
#include <span>
#include <vector>

namespace espalier::bind {

/// How far a point follows the lattice, and how this changes from point to point.
struct PointWeight {
    double value = 1;   ///< 0 to 1
    Point3 slope = {};  ///< by the coordinates of the point at rest
    friend bool operator==(const PointWeight&, const PointWeight&) = default;
};

/// How far each point follows the lattice: x' = x + w · D · (p' − p), with a weight w for each
/// point.
///
/// The deformation gradient is then F = 1 + w · (F₁ − 1) + d ∇wᵀ, where F₁ and d are the gradient
/// and the displacement of a point that follows fully. A weight of 0 keeps the point and F = 1,
/// whatever its slope.
struct PointWeights {
    std::vector<double> values = {};  ///< w, 0 to 1, one per point; or empty, and all weights are 1
    std::vector<Point3> slopes = {};  ///< ∇w by the points at rest; or empty, and all are 0

    friend bool operator==(const PointWeights&, const PointWeights&) = default;
};

/// Returns the slopes of weights along a surface.
///
/// The slope at a point lies in the tangent plane there, and fits the weights at the ends of its
/// edges by least squares. Long edges count more, so that an edge that is shorter than the rounding
/// of the weights does no harm. The tangent plane is perpendicular to the mean direction of the
/// normals of the faces around the point, weighted by their angles there; the faces may be
/// clockwise or anticlockwise. Points of one shape that have equal positions and weights, as at a
/// seam, count as one point. The result is exact where the weight is a linear function of the place
/// on a flat surface.
///
/// A slope along a surface is all that the surface's normals and tangents need. A point in no face
/// with an area has the slope 0.
///
/// \param corners the points of all faces, and `ends` where the corners of each face end
/// \param weights one per point
/// \param shapes the shape of each point, such as a morph target; or empty, if all are of one
/// \throws Error unless there is one finite weight per point, and the corners are points
/// \cost O(corners + points log points), and 180 bytes for each point
/// \cite Thürmer & Wüthrich 1998, for the normals
ESPALIER_API std::vector<Point3> slopesOnSurface(std::span<const Point3> points,
                                                 std::span<const Index> corners,
                                                 std::span<const std::size_t> ends,
                                                 std::span<const double> weights,
                                                 std::span<const Index> shapes = {});

/// Returns the weight of a point outside a lattice that follows with a falloff, and its slope:
/// 1 − r² (3 − 2r) for a distance of r · radius; 0 for r ≥ 1. The slope is 0 at both ends, so the
/// deformation is smooth where the falloff begins and ends.
///
/// \param away the vector from the nearest place in the lattice to the point
/// \param radius > 0
ESPALIER_API PointWeight falloffWeight(const Point3& away, double radius);

}  // namespace espalier::bind
