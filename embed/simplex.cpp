// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/simplex.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace espalier::embed {
namespace {

using Eigen::Vector3d;

/// Returns where the segment from a to b is nearest to the origin: 0 at a, 1 at b.
double nearestOnSegment(const Vector3d& a, const Vector3d& b) {
    const Vector3d along = b - a;
    const double squared = along.squaredNorm();
    return squared > 0 ? std::clamp(-a.dot(along) / squared, 0.0, 1.0) : 0.0;
}

}  // namespace

Vector3d nearestToOrigin(const Triangle& triangle) {
    // The foot of the perpendicular, if it is in the triangle.
    const Vector3d ab = triangle[1] - triangle[0], ac = triangle[2] - triangle[0];
    const Vector3d normal = ab.cross(ac);
    const double squared = normal.squaredNorm();
    if (squared > 0) {
        const double v = normal.dot(ac.cross(triangle[0])) / squared;
        const double w = normal.dot(triangle[0].cross(ab)) / squared;
        if (v >= 0 && w >= 0 && v + w <= 1) return {1 - v - w, v, w};
    }
    // Otherwise, the nearest point of the three edges.
    Vector3d best = Vector3d::Zero();
    double bestSquared = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Eigen::Index j = (i + 1) % 3;
        const Vector3d& a = triangle[i];
        const Vector3d& b = triangle[j];
        const double t = nearestOnSegment(a, b);
        const double d = ((1 - t) * a + t * b).squaredNorm();
        if (d >= bestSquared) continue;
        bestSquared = d;
        best.setZero();
        best[i] = 1 - t;
        best[j] = t;
    }
    return best;
}

}  // namespace espalier::embed
