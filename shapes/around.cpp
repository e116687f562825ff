// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/transform.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "checks.h"
#include "smallest_box.h"

namespace espalier::shapes {
namespace {

void check(std::span<const Point3> points, const AroundOptions& options) {
    if (points.empty()) throw Error("there are no points");
    requireFinite("points", points);
    if (options.cells != std::array<int, 3>{})
        for (std::size_t axis = 0; axis < 3; ++axis)
            requireAtLeast("around", indexed("cells", axis), options.cells[axis], 1);
    requireFinite("around", "cellSize", options.cellSize);
    if (options.cellSize < 0)
        throw ArgumentError("around", "cellSize", textOf(options.cellSize), "a length above 0");
    requireAtLeast("around", "cellsAlongLongest", options.cellsAlongLongest, 1);
    requireFinite("around", "margin", options.margin);
    if (options.margin < 0)
        throw ArgumentError("around", "margin", textOf(options.margin), "a fraction of 0 or more");
}

/// Returns the numbers of cells of a box whose sides have the lengths `size`.
std::array<int, 3> countsOf(const Point3& size, const AroundOptions& options) {
    if (options.cells != std::array<int, 3>{}) return options.cells;
    const double longest = std::ranges::max(size);
    std::array<int, 3> counts;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // A length that is a multiple of the size but for rounding gets no extra cell.
        constexpr double kRounding = 1e-9;
        const double count = options.cellSize > 0
                                 ? std::ceil(size[axis] / options.cellSize * (1 - kRounding))
                                 : std::round(size[axis] / longest * options.cellsAlongLongest);
        if (count > std::numeric_limits<int>::max())
            throw ArgumentError("around", "cellSize", textOf(options.cellSize),
                                "a length for which the number of cells fits into 31 bits");
        counts[axis] = std::max(1, static_cast<int>(count));
    }
    return counts;
}

}  // namespace

Lattice around(std::span<const Point3> points, const AroundOptions& options) {
    check(points, options);
    Axes axes = kCoordinateAxes;
    BoundingBox bounds = boxAlong(axes, points);
    const double diagonal = bounds.diagonal();
    if (!std::isfinite(diagonal))
        throw Error("the points are so far apart that the size of their box is infinite");
    if (!(diagonal > 0))
        throw Error("all points are at " + textOf(points.front()) +
                    "; a box needs points at different places");
    if (options.oriented) {
        axes = smallestBox(points, 2 * options.margin * diagonal);
        bounds = boxAlong(axes, points);
    }
    const double margin = options.margin * bounds.diagonal();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds.min[axis] -= margin;
        bounds.max[axis] += margin;
        if (!std::isfinite(bounds.size()[axis]))
            throw ArgumentError("around", "margin", textOf(options.margin),
                                "a fraction for which the box is finite");
        if (!(bounds.size()[axis] > 0))
            throw ArgumentError("around", "margin", textOf(options.margin),
                                "a number above 0, since the points lie in a plane and the box "
                                "would be flat");
    }
    const Lattice result = box({countsOf(bounds.size(), options), bounds.min, bounds.max});
    if (!options.oriented) return result;
    // The columns of the matrix are the axes: coordinates along the axes become positions.
    Affine placement;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            placement.linear[row][column] = axes[column][row];
    return transformed(result, placement);
}

}  // namespace espalier::shapes
