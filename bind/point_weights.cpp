// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/bind/point_weights.h>

#include <Eigen/Geometry>
#include <cmath>

namespace espalier::bind {

using Eigen::Vector3d;

std::vector<Point3> slopesOnSurface(std::span<const Point3> points, std::span<const Index> corners,
                                    std::span<const std::size_t> ends,
                                    std::span<const double> weights) {
    if (weights.size() != points.size())
        throw Error(concat("got ", weights.size(), " weights for ", points.size(), " points"));
    for (const Index corner : corners)
        if (corner < 0 || corner >= std::ssize(points))
            throw Error(
                concat("a face has the point ", corner, "; there are ", points.size(), " points"));
    struct Sum {
        Vector3d slope = Vector3d::Zero();  ///< of the triangles, each times its angle here
        double angle = 0;
    };
    std::vector<Sum> sums(points.size());
    const auto addTriangle = [&](Index a, Index b, Index c) {
        const Vector3d origin(points[a].data());
        const Vector3d ab = Vector3d(points[b].data()) - origin;
        const Vector3d ac = Vector3d(points[c].data()) - origin;
        const Vector3d normal = ab.cross(ac);
        const double area = normal.stableNorm();
        if (!(area > 0)) return;
        // The function that is 1 at b and 0 at a and c rises along ac × n / |n|², and likewise.
        const Vector3d along = (weights[b] - weights[a]) * ac - (weights[c] - weights[a]) * ab;
        const Vector3d slope = along.cross(normal / area) / area;
        const auto add = [&](Index corner, const Vector3d& to, const Vector3d& from) {
            const double angle = std::atan2(area, to.dot(from));
            sums[corner].slope += angle * slope;
            sums[corner].angle += angle;
        };
        add(a, ab, ac);
        add(b, ac - ab, -ab);
        add(c, -ac, ab - ac);
    };
    std::size_t begin = 0;
    for (const std::size_t end : ends) {
        for (std::size_t i = begin + 2; i < end; ++i)
            addTriangle(corners[begin], corners[i - 1], corners[i]);
        begin = end;
    }
    std::vector<Point3> slopes(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; sums[i].angle > 0 && c < 3; ++c)
            slopes[i][c] = sums[i].slope[static_cast<Eigen::Index>(c)] / sums[i].angle;
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
