// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/section.h>

#include <cmath>
#include <numbers>
#include <string>

#include "cell_loops.h"
#include "checks.h"

namespace espalier::shapes {

Lattice diskMesh(std::span<const Point3> outline, const Point3& centre,
                 const DiskPattern& pattern) {
    if (outline.size() < 3)
        throw ArgumentError("disk", "outline", std::to_string(outline.size()),
                            "3 or more vertices");
    requireAtLeast("disk", "rings", pattern.rings, 1);
    requireCountable("disk", {static_cast<Offset>(outline.size()), pattern.rings, 4});
    const auto n = static_cast<Index>(outline.size());
    const bool wedges = pattern.core == Core::Wedges;

    std::vector<Point3> positions;
    if (wedges) positions.push_back(centre);
    for (int ring = 1; ring <= pattern.rings; ++ring)
        for (const Point3& point : outline)
            positions.push_back(between(centre, point, static_cast<double>(ring) / pattern.rings));

    const auto at = [&](int ring, Index spoke) {
        return (wedges ? 1 : 0) + (ring - 1) * n + spoke % n;
    };
    std::vector<Loop> loops;
    if (wedges) {
        for (Index s = 0; s < n; ++s) loops.push_back({0, at(1, s), at(1, s + 1)});
    } else {
        loops.emplace_back();
        for (Index s = 0; s < n; ++s) loops.back().push_back(at(1, s));
    }
    for (int ring = 1; ring < pattern.rings; ++ring)
        for (Index s = 0; s < n; ++s)
            loops.push_back({at(ring, s), at(ring + 1, s), at(ring + 1, s + 1), at(ring, s + 1)});
    return {far::buildMesh(static_cast<Index>(positions.size()), loops), positions, {}, {}};
}

std::vector<Point3> regularPolygon(int sides, double radius) {
    requireAtLeast("polygon", "sides", sides, 3);
    requirePositive("polygon", "radius", radius);
    std::vector<Point3> points;
    for (int side = 0; side < sides; ++side) {
        const double angle = 2 * std::numbers::pi * side / sides;
        points.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    return points;
}

Lattice gridMesh(const GridOptions& options) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
        requireAtLeast("grid", indexed("cells", axis), options.cells[axis], 1);
        requireInterval("grid", indexed("min", axis), options.min[axis], indexed("max", axis),
                        options.max[axis]);
    }
    const auto [columns, rows] = options.cells;
    requireCountable("grid", {columns + Offset{1}, rows + Offset{1}, 4});

    std::vector<Point3> positions;
    for (int row = 0; row <= rows; ++row)
        for (int column = 0; column <= columns; ++column)
            positions.push_back(
                {std::lerp(options.min[0], options.max[0], static_cast<double>(column) / columns),
                 std::lerp(options.min[1], options.max[1], static_cast<double>(row) / rows), 0});

    std::vector<Loop> loops;
    const Index width = columns + 1;
    for (Index row = 0; row < rows; ++row)
        for (Index column = 0; column < columns; ++column) {
            const Index corner = row * width + column;
            loops.push_back({corner, corner + 1, corner + width + 1, corner + width});
        }
    return {far::buildMesh(static_cast<Index>(positions.size()), loops), positions, {}, {}};
}

}  // namespace espalier::shapes
