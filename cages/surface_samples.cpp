// SPDX-License-Identifier: Apache-2.0
#include "surface_samples.h"

#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>

namespace espalier::cages {
namespace {

/// Halves a triangle across its longest side until no side is longer than `spacing`. Visits the
/// middles of the sides that it halves.
void visitParts(const std::array<Point3, 3>& triangle, double spacing,
                FunctionRef<void(const Point3&)> visit) {
    int longest = 0;
    double most = -1;
    for (int i = 0; i < 3; ++i) {
        const Point3 way = difference(triangle[(i + 1) % 3], triangle[i]);
        if (dot(way, way) <= most) continue;
        most = dot(way, way);
        longest = i;
    }
    if (!(most > spacing * spacing)) return;
    const Point3 &a = triangle[longest], &b = triangle[(longest + 1) % 3],
                 &c = triangle[(longest + 2) % 3];
    const Point3 middle = between(a, b, 0.5);
    visit(middle);
    visitParts({a, middle, c}, spacing, visit);
    visitParts({middle, b, c}, spacing, visit);
}

}  // namespace

void forEachSample(std::span<const Triangle> triangles, std::span<const Point3> points,
                   double spacing, FunctionRef<void(const Point3&, std::size_t)> visit) {
    for (std::size_t number = 0; number < triangles.size(); ++number) {
        const Triangle& t = triangles[number];
        const std::array<Point3, 3> corners = {points[t[0]], points[t[1]], points[t[2]]};
        for (const Point3& corner : corners) visit(corner, number);
        if (t[0] == t[2]) continue;
        for (std::size_t i = 0; i < 3; ++i)
            visit(between(corners[i], corners[(i + 1) % 3], 0.5), number);
        visit(mean(corners), number);
        visitParts(corners, spacing, [&](const Point3& point) { visit(point, number); });
    }
}

}  // namespace espalier::cages
