// SPDX-License-Identifier: Apache-2.0
#include "surface_samples.h"

#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>

namespace espalier::cages {
namespace {

/// Halves a triangle across its longest side until no side is longer than `spacing`. Adds the
/// middles of the sides that it halves.
void addParts(const std::array<Point3, 3>& triangle, double spacing, std::vector<Point3>& samples) {
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
    samples.push_back(middle);
    addParts({a, middle, c}, spacing, samples);
    addParts({middle, b, c}, spacing, samples);
}

}  // namespace

std::vector<Point3> surfaceSamples(std::span<const Triangle> triangles,
                                   std::span<const Point3> points, double spacing) {
    std::vector<Point3> samples;
    std::vector<char> isUsed(points.size(), 0);
    for (const Triangle& t : triangles) {
        for (const Index corner : t) isUsed[corner] = 1;
        if (t[0] == t[2]) continue;
        const std::array<Point3, 3> corners = {points[t[0]], points[t[1]], points[t[2]]};
        for (int i = 0; i < 3; ++i)
            samples.push_back(between(corners[i], corners[(i + 1) % 3], 0.5));
        samples.push_back(mean(corners));
        addParts(corners, spacing, samples);
    }
    for (std::size_t i = 0; i < points.size(); ++i)
        if (isUsed[i] != 0) samples.push_back(points[i]);
    return samples;
}

}  // namespace espalier::cages
