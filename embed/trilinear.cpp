// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/map_inversion.h>
#include <espalier/embed/trilinear.h>

#include <Eigen/Geometry>
#include <cmath>

namespace espalier::embed {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Coordinates of each corner in the parameter cube.
constexpr std::array<std::array<int, 3>, 8> kCorner = {
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};

/// Interpolates between a at t = 0 and b at t = 1, exact at both ends.
Vector3d between(const Vector3d& a, const Vector3d& b, double t) {
    // For each axis, since GCC stops inlining Eigen's expressions when a file is large.
    return {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1], (1 - t) * a[2] + t * b[2]};
}

/// Returns the factor of a corner's weight along one axis.
double factor(std::size_t corner, std::size_t axis, double t) {
    return kCorner[corner][axis] ? t : 1 - t;
}

}  // namespace

Trilinear::Weights Trilinear::weights(const Vector3d& uvw) {
    Weights result;
    for (std::size_t i = 0; i < 8; ++i)
        result[i] = factor(i, 0, uvw[0]) * factor(i, 1, uvw[1]) * factor(i, 2, uvw[2]);
    return result;
}

std::array<Trilinear::Weights, 3> Trilinear::weightDerivatives(const Vector3d& uvw) {
    std::array<Weights, 3> result;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t second = (axis + 1) % 3, third = (axis + 2) % 3;
        for (std::size_t i = 0; i < 8; ++i)
            result[axis][i] = (kCorner[i][axis] ? 1 : -1) *
                              factor(i, second, uvw[static_cast<Eigen::Index>(second)]) *
                              factor(i, third, uvw[static_cast<Eigen::Index>(third)]);
    }
    return result;
}

Trilinear::Tangent Trilinear::tangent(const Vector3d& uvw) const {
    const auto& c = corners_;
    const double u = uvw[0], v = uvw[1], w = uvw[2];
    // Interpolate along the four edges in direction u, between these in direction v, then in
    // direction w.
    const Vector3d bottomFront = between(c[0], c[1], u), bottomBack = between(c[3], c[2], u);
    const Vector3d topFront = between(c[4], c[5], u), topBack = between(c[7], c[6], u);
    const Vector3d bottom = between(bottomFront, bottomBack, v);
    const Vector3d top = between(topFront, topBack, v);
    Tangent result;
    result.position = between(bottom, top, w);
    result.jacobian.col(0) =
        between(between(c[1] - c[0], c[2] - c[3], v), between(c[5] - c[4], c[6] - c[7], v), w);
    result.jacobian.col(1) = between(bottomBack - bottomFront, topBack - topFront, w);
    result.jacobian.col(2) = top - bottom;
    return result;
}

std::optional<Vector3d> Trilinear::findOrigin(const Vector3d& start) const {
    return embed::findOrigin(*this, start);
}

std::optional<Vector3d> Trilinear::findOriginInside(double tolerance) const {
    // At the finest, 8³ parts: if a cell has two solutions closer than that, it is nearly singular
    // there.
    constexpr int kDeepest = 3;
    struct Part {
        Vector3d low;
        int depth;
    };
    std::array<Part, 8 * kDeepest + 1> stack = {Part{Vector3d::Zero(), 0}};
    for (std::size_t size = 1; size > 0;) {
        const Part part = stack[--size];
        const double side = std::ldexp(1.0, -part.depth);
        Eigen::AlignedBox<double, 3> box;
        for (const auto& corner : kCorner)
            box.extend(position(part.low + side * Vector3d(corner[0], corner[1], corner[2])));
        // By rounding of its corners, the box may miss a point on its face.
        const double slack = 1e-12 * box.diagonal().norm();
        if (box.exteriorDistance(Vector3d(Vector3d::Zero())) > slack) continue;
        const auto place = findOrigin(part.low + Vector3d::Constant(side / 2));
        if (place && isInUnitCube(*place, tolerance)) return place;
        if (part.depth == kDeepest) continue;
        for (const auto& corner : kCorner)
            stack[size++] = {part.low + side / 2 * Vector3d(corner[0], corner[1], corner[2]),
                             part.depth + 1};
    }
    return std::nullopt;
}

Vector3d Trilinear::nearestToOrigin() const {
    return embed::nearestToOrigin(*this);
}

bool isInUnitCube(const Vector3d& uvw, double tolerance) {
    return (uvw.array() >= -tolerance).all() && (uvw.array() <= 1 + tolerance).all();
}

}  // namespace espalier::embed
