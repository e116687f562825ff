// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/error.h>
#include <espalier/bind/point_weights.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

namespace espalier::bind {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Returns for each point the first one that has its position, its weight and its shape.
std::vector<Index> firstOfAlike(std::span<const Point3> points, std::span<const double> weights,
                                std::span<const Index> shapes) {
    std::vector<Index> order(points.size());
    std::iota(order.begin(), order.end(), Index{0});
    const auto key = [&](Index i) {
        return std::tuple(points[i], weights[i], shapes.empty() ? 0 : shapes[i]);
    };
    stableSortCancellably(order.begin(), order.end(),
                          [&](Index a, Index b) { return key(a) < key(b); });
    std::vector<Index> first(points.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] =
            i > 0 && key(order[i - 1]) == key(order[i]) ? first[order[i - 1]] : order[i];
    return first;
}

}  // namespace

std::vector<Point3> slopesOnSurface(std::span<const Point3> points, std::span<const Index> corners,
                                    std::span<const std::size_t> ends,
                                    std::span<const double> weights,
                                    std::span<const Index> shapes) {
    if (weights.size() != points.size())
        throw Error(concat("got ", weights.size(), " weights for ", points.size(), " points"));
    for (std::size_t i = 0; i < weights.size(); ++i)
        if (!std::isfinite(weights[i]))
            throw Error(concat("the weight of point ", i, " is not finite"));
    if (!shapes.empty() && shapes.size() != points.size())
        throw Error(concat("got ", shapes.size(), " shapes for ", points.size(), " points"));
    for (const Index corner : corners)
        if (corner < 0 || corner >= std::ssize(points))
            throw Error(
                concat("a face has the point ", corner, "; there are ", points.size(), " points"));
    const std::vector<Index> first = firstOfAlike(points, weights, shapes);
    struct Sum {
        Matrix3d normals = Matrix3d::Zero();  ///< Σ n nᵀ over the faces, times their angles here
        Matrix3d edges = Matrix3d::Zero();    ///< Σ e eᵀ over the edges e
        Vector3d changes = Vector3d::Zero();  ///< Σ e Δw
    };
    std::vector<Sum> sums(points.size());
    const auto addCorner = [&](Index before, Index at, Index after) {
        const Vector3d place(points[at].data());
        Sum& sum = sums[first[at]];
        std::array<Vector3d, 2> along;
        for (std::size_t k = 0; k < 2; ++k) {
            const Index end = k == 0 ? after : before;
            const Vector3d edge = Vector3d(points[end].data()) - place;
            sum.edges += edge * edge.transpose();
            sum.changes += (weights[end] - weights[at]) * edge;
            along[k] = edge;
        }
        const Vector3d normal = along[0].cross(along[1]);
        if (const double area = normal.stableNorm(); area > 0)
            sum.normals += std::atan2(area, along[0].dot(along[1])) * (normal / area) *
                           (normal / area).transpose();
    };
    std::size_t begin = 0;
    for (const std::size_t end : ends) {
        const std::size_t count = end - begin;
        for (std::size_t i = 0; i < count && count > 2; ++i)
            addCorner(corners[begin + (i + count - 1) % count], corners[begin + i],
                      corners[begin + (i + 1) % count]);
        begin = end;
    }
    std::vector<Point3> slopes(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Sum& sum = sums[first[i]];
        if (!(sum.normals.trace() > 0)) continue;
        // The plane is perpendicular to the mean direction of the normals of the faces. Since Σ n
        // nᵀ has no signs, faces may be clockwise or anticlockwise.
        const Eigen::SelfAdjointEigenSolver<Matrix3d> directions(sum.normals);
        const Eigen::Matrix<double, 3, 2> plane = directions.eigenvectors().leftCols<2>();
        const Eigen::Matrix2d edges = plane.transpose() * sum.edges * plane;
        const Eigen::Vector2d slope =
            edges.completeOrthogonalDecomposition().solve(plane.transpose() * sum.changes);
        const Vector3d inSpace = plane * slope;
        if (inSpace.allFinite()) slopes[i] = {inSpace[0], inSpace[1], inSpace[2]};
    }
    return slopes;
}

PointWeight falloffWeight(const Point3& away, double radius) {
    const Vector3d vector(away.data());
    const double distance = vector.stableNorm();
    const double r = distance / radius;
    if (distance == 0) return {};
    if (!(r < 1)) return {0, {}};
    const Vector3d slope = -6 * r * (1 - r) / radius / distance * vector;
    return {1 - r * r * (3 - 2 * r), {slope[0], slope[1], slope[2]}};
}

}  // namespace espalier::bind
