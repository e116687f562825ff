// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/extrude.h>
#include <espalier/shapes/inventory.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "cell_loops.h"
#include "checks.h"

namespace espalier::shapes {
namespace {

void check(const BarbellOptions& options) {
    requireAtLeast("barbell", "endSegments", options.endSegments, 3);
    requireAtLeast("barbell", "barSegments", options.barSegments, 1);
    requireAtLeast("barbell", "barAcross", options.barAcross, 1);
    requireAtLeast("barbell", "rings", options.pattern.rings, 1);
    requireAtLeast("barbell", "layers", options.layers, 1);
    requirePositive("barbell", "endRadius", options.endRadius);
    requirePositive("barbell", "barLength", options.barLength);
    requirePositive("barbell", "barHalfWidth", options.barHalfWidth);
    requirePositive("barbell", "height", options.height);
    if (!(options.roundness >= 0 && options.roundness <= 1))
        throw ArgumentError("barbell", "roundness", textOf(options.roundness), "0 to 1");
    // If a round end were only as wide as the bar, its centre would lie on the end of the bar.
    const bool fits = options.roundness < 1 ? options.barHalfWidth <= options.endRadius
                                            : options.barHalfWidth < options.endRadius;
    if (!fits)
        throw ArgumentError(
            "barbell", "barHalfWidth", textOf(options.barHalfWidth),
            options.roundness < 1 ? "a number up to" : "with roundness 1, a number below",
            {"endRadius", textOf(options.endRadius)});
    if (!std::isfinite(options.endRadius * options.endRadius))
        throw ArgumentError("barbell", "endRadius", textOf(options.endRadius),
                            "a radius whose square is finite");
    const Offset sides = options.endSegments + Offset{options.barAcross};
    requireCountable("barbell", {sides, options.pattern.rings, options.layers, 12});
    requireCountable("barbell", {options.barSegments, options.barAcross, options.layers, 24});
}

/// Returns the x coordinate at which the bar meets an end that is centred at the origin.
double neck(const BarbellOptions& options) {
    const double round = std::sqrt(options.endRadius * options.endRadius -
                                   options.barHalfWidth * options.barHalfWidth);
    return std::lerp(options.endRadius, round, options.roundness);
}

/// Returns the point at a fraction of the path along three sides of a square, from (1, 1) via (-1,
/// 1) and (-1, -1) to (1, -1).
Point3 onSquare(double fraction) {
    const double along = 6 * fraction;
    if (along <= 2) return {1 - along, 1, 0};
    if (along <= 4) return {-1, 3 - along, 0};
    return {along - 5, -1, 0};
}

/// Returns the outline of the left end, centred at the origin. Vertex 0 is at the upper side of the
/// bar and vertex endSegments at the lower side; the vertices between them go around the end, and
/// the vertices after them go upwards across the bar.
std::vector<Point3> endOutline(const BarbellOptions& options) {
    const double half = options.barHalfWidth;
    const double x = neck(options);
    const double start = std::asin(half / options.endRadius);
    std::vector<Point3> outline = {{x, half, 0}};
    for (int i = 1; i < options.endSegments; ++i) {
        const double fraction = static_cast<double>(i) / options.endSegments;
        const double angle = std::lerp(start, 2 * std::numbers::pi - start, fraction);
        const Point3 round = {std::cos(angle), std::sin(angle), 0};
        outline.push_back(
            scaled(between(onSquare(fraction), round, options.roundness), options.endRadius));
    }
    for (int row = 0; row < options.barAcross; ++row)
        outline.push_back({x, half * (2.0 * row / options.barAcross - 1), 0});
    return outline;
}

/// Makes the flat mesh: the left end, the right end (the left end rotated by 180 degrees), the bar.
Lattice barbellMesh(const BarbellOptions& options) {
    const std::vector<Point3> outline = endOutline(options);
    const Lattice end = diskMesh(outline, {0, 0, 0}, options.pattern);
    const Index endCount = end.complex.count(0);
    const auto sides = static_cast<Index>(outline.size());
    const Point3 centre = {-(options.barLength / 2 + neck(options)), 0, 0};

    std::vector<Point3> positions;
    for (const Point3& point : end.positions) positions.push_back(sum(point, centre));
    for (std::size_t i = 0; i < end.positions.size(); ++i)
        positions.push_back(scaled(positions[i], -1));

    // Rows of the bar are counted upwards, columns to the right. The first and the last column are
    // vertices of the outlines of the ends. The vertices of an outline are the last vertices of its
    // end.
    const auto onOutline = [&](Index row) {
        return endCount - sides + (options.endSegments + row) % sides;
    };
    const auto vertex = [&](Index column, Index row) {
        if (column == 0) return onOutline(row);
        if (column == options.barSegments) return endCount + onOutline(options.barAcross - row);
        return 2 * endCount + (column - 1) * (options.barAcross + 1) + row;
    };
    for (Index column = 1; column < options.barSegments; ++column)
        for (Index row = 0; row <= options.barAcross; ++row)
            positions.push_back(between(positions[vertex(0, row)],
                                        positions[vertex(options.barSegments, row)],
                                        static_cast<double>(column) / options.barSegments));

    std::vector<Loop> loops;
    for (const Index first : {Index{0}, endCount})
        for (Index face = 0; face < end.complex.count(2); ++face) {
            Loop& loop = loops.emplace_back();
            for (const Index v : end.complex.relation(2, 0)[face]) loop.push_back(first + v);
        }
    for (Index column = 0; column < options.barSegments; ++column)
        for (Index row = 0; row < options.barAcross; ++row)
            loops.push_back({vertex(column, row), vertex(column + 1, row),
                             vertex(column + 1, row + 1), vertex(column, row + 1)});
    return {far::buildMesh(static_cast<Index>(positions.size()), loops), positions, {}, {}};
}

}  // namespace

Lattice barbell(const BarbellOptions& options) {
    check(options);
    const double half = options.height / 2;
    return sweep(barbellMesh(options),
                 stationsBetween({0, 0, -half}, {0, 0, half}, options.layers));
}

}  // namespace espalier::shapes
