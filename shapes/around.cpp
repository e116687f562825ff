// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/far/standard_cells.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/transform.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <espalier/shapes/smallest_box.h>
#include "checks.h"

namespace espalier::shapes {
namespace {

constexpr const char* kAxisNames[] = {"x", "y", "z"};

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
    if (!options.symmetry) return;
    const auto& [axis, at] = *options.symmetry;
    if (axis < 0 || axis > 2)
        throw ArgumentError("around", "symmetry", std::to_string(axis), "axis 0, 1 or 2");
    if (at) requireFinite("around", "symmetryAt", *at);
    if (options.oriented)
        throw ArgumentError("around", "symmetry", kAxisNames[axis],
                            "a box along the axes, without the option ", {"oriented", ""});
}

/// Where the points are, seen from the plane of symmetry.
enum class SideOfPlane { Both, Above, Below };

/// Returns the coordinate of the plane of symmetry.
/// \throws ArgumentError if the points do not reach to it
double planeOf(const SymmetryPlane& symmetry, const BoundingBox& bounds) {
    const double at = symmetry.at.value_or(0);
    const auto axis = std::size_t(symmetry.axis);
    const double near = kAroundTolerance * bounds.diagonal();
    if (at < bounds.min[axis] - near || at > bounds.max[axis] + near)
        throw ArgumentError(
            "around", "symmetryAt", concat(kAxisNames[axis], " = ", textOf(at)),
            concat("a plane that the model reaches to, from ", kAxisNames[axis], " = ",
                   textOf(bounds.min[axis]), " to ", textOf(bounds.max[axis])));
    return at;
}

SideOfPlane sideOfPlane(const SymmetryPlane& symmetry, const BoundingBox& bounds) {
    const double at = planeOf(symmetry, bounds), near = kAroundTolerance * bounds.diagonal();
    const auto axis = std::size_t(symmetry.axis);
    if (bounds.min[axis] >= at - near) return SideOfPlane::Above;
    return bounds.max[axis] <= at + near ? SideOfPlane::Below : SideOfPlane::Both;
}

/// Puts the vertices of a box exactly into the plane of symmetry, and in a symmetric box the others
/// to mirrored places.
void makeSymmetric(Lattice& lattice, const std::array<int, 3>& cells, std::size_t axis, double at,
                   SideOfPlane side) {
    std::size_t stride = 1;
    for (std::size_t a = 0; a < axis; ++a) stride *= std::size_t(cells[a]) + 1;
    const auto count = std::size_t(cells[axis]);
    for (std::size_t v = 0; v < lattice.positions.size(); ++v) {
        const std::size_t along = v / stride % (count + 1);
        double& coordinate = lattice.positions[v][axis];
        const bool isIn = side == SideOfPlane::Both    ? 2 * along == count
                          : side == SideOfPlane::Above ? along == 0
                                                       : along == count;
        if (isIn)
            coordinate = at;
        else if (side == SideOfPlane::Both && 2 * along > count)
            coordinate = 2 * at - lattice.positions[v - (2 * along - count) * stride][axis];
    }
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

namespace {

/// Returns the box with the plane of symmetry as a side, or in the middle.
/// \param tight the box around the points, without a margin
BoundingBox symmetricBounds(const SymmetryPlane& symmetry, const BoundingBox& tight,
                            BoundingBox bounds) {
    const double at = planeOf(symmetry, tight);
    const auto axis = std::size_t(symmetry.axis);
    const SideOfPlane side = sideOfPlane(symmetry, tight);
    const double farthest = std::max(bounds.max[axis] - at, at - bounds.min[axis]);
    bounds.min[axis] = side == SideOfPlane::Above ? at : at - farthest;
    bounds.max[axis] = side == SideOfPlane::Below ? at : at + farthest;
    return bounds;
}

/// \param counts is changed so that a layer of vertices is in the plane
Lattice symmetricBox(const SymmetryPlane& symmetry, const BoundingBox& tight,
                     const BoundingBox& bounds, std::array<int, 3>& counts) {
    const auto axis = std::size_t(symmetry.axis);
    const SideOfPlane side = sideOfPlane(symmetry, tight);
    if (side == SideOfPlane::Both) counts[axis] += counts[axis] % 2;
    Lattice result = box({counts, bounds.min, bounds.max});
    makeSymmetric(result, counts, axis, planeOf(symmetry, tight), side);
    return result;
}

/// Makes the box, whether or not rounding leaves points outside.
Lattice boxAround(std::span<const Point3> points, const AroundOptions& options,
                  AroundFacts& facts) {
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
    const BoundingBox tight = bounds;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds.min[axis] -= margin;
        bounds.max[axis] += margin;
        if (options.symmetry && std::size_t(options.symmetry->axis) == axis)
            bounds = symmetricBounds(*options.symmetry, tight, bounds);
        if (!std::isfinite(bounds.size()[axis]))
            throw ArgumentError("around", "margin", textOf(options.margin),
                                "a fraction for which the box is finite");
        if (!(bounds.size()[axis] > 0))
            throw ArgumentError("around", "margin", textOf(options.margin),
                                "a number above 0, since the points lie in a plane and the box "
                                "would be flat");
    }
    facts.margin = options.margin;
    facts.wanted = facts.cells = countsOf(bounds.size(), options);
    if (options.symmetry) return symmetricBox(*options.symmetry, tight, bounds, facts.cells);
    const Lattice result = box({facts.cells, bounds.min, bounds.max});
    if (!options.oriented) return result;
    // The columns of the matrix are the axes: coordinates along the axes become positions.
    Affine placement;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            placement.linear[row][column] = axes[column][row];
    return transformed(result, placement);
}

/// Returns the number of points outside a box lattice. Rounding puts points outside only where the
/// box is tiny compared with its distance from the origin.
Offset countOutside(const Lattice& lattice, std::span<const Point3> points) {
    // The axes of the box are the edges of its first cell, in VTK's order.
    const auto corners = *far::hexahedronVertices(lattice.complex, CellId(0));
    const Point3& origin = lattice.positions[corners[0]];
    Axes axes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Index neighbour = corners[far::kHexahedronNeighbours[0][axis]];
        axes[axis] = normalised(difference(lattice.positions[neighbour], origin));
    }
    const auto along = [&](const Point3& point) {
        const Point3 from = difference(point, origin);
        return Point3{dot(from, axes[0]), dot(from, axes[1]), dot(from, axes[2])};
    };
    BoundingBox box;
    for (const Point3& vertex : lattice.positions) box.include(along(vertex));
    const double tolerance = kAroundTolerance * box.diagonal();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.min[axis] -= tolerance;
        box.max[axis] += tolerance;
    }
    Offset count = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        checkCancelledEvery(i, 12);
        if (!box.contains(along(points[i]))) ++count;
    }
    return count;
}

}  // namespace

Lattice around(std::span<const Point3> points, const AroundOptions& options, AroundFacts* facts) {
    check(points, options);
    constexpr double kSmallestMargin = 1e-9;
    constexpr int kMaxRounds = 10;
    AroundOptions wider = options;
    for (int round = 0;; ++round) {
        AroundFacts found;
        Lattice lattice = boxAround(points, wider, found);
        const Offset outside = countOutside(lattice, points);
        if (outside == 0) {
            if (facts != nullptr) *facts = found;
            return lattice;
        }
        if (round == kMaxRounds)
            throw Error(concat(outside,
                               " points are outside the lattice, whatever the margin: the size of "
                               "the model (",
                               textOf(BoundingBox(points).diagonal()),
                               ") is near the rounding of its coordinates; scale it, or move it to "
                               "the origin"));
        wider.margin = std::max(2 * wider.margin, kSmallestMargin);
    }
}

}  // namespace espalier::shapes
