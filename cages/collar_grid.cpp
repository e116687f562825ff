// SPDX-License-Identifier: Apache-2.0
#include "collar_grid.h"

#include <espalier/base/argument_error.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/vector3.h>
#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace espalier::cages {
namespace {

using GridPoint = std::array<Index, 3>;

constexpr std::size_t kNowhere = 6;

/// A side of the lattice: the grid points whose coordinate on an axis is 0 or the largest.
struct GridSide {
    std::size_t axis = 0;
    bool isUpper = false;
    bool isOpen = false;
    Point3 normal = {};         ///< mean, of length 1, outwards
    Point3 direction = {};      ///< of the collar, of length 1
    std::size_t facing = 0;     ///< the number of the coordinate direction that it faces best, or
                                ///< kNowhere if it has no area
    std::vector<double> parts;  ///< layerParts()
};

class GridCollar {
public:
    GridCollar(const Lattice& lattice, const far::BoxGrid& grid, const CollarOptions& options)
        : lattice_(lattice), grid_(grid), options_(options) {
        if (isLeftHanded()) std::swap(order_[0], order_[1]);
        for (std::size_t number = 0; number < 6; ++number) {
            GridSide& side = sides_[number];
            side.axis = number / 2;
            side.isUpper = number % 2 == 1;
            side.normal = side.direction = normalOf(side);
            side.facing = facingOf(side.normal);
        }
        openSides();
    }

    /// Returns the boundary faces of the open sides.
    OpenFaces openFaces() const {
        const far::CellComplex& complex = lattice_.complex;
        OpenFaces result{std::vector<char>(std::size_t(complex.count(2)), 0),
                         std::vector<PlaneNormals>(lattice_.positions.size())};
        for (const GridSide& side : sides_) {
            if (!side.isOpen) continue;
            std::vector<char> isAt(lattice_.positions.size(), 0);
            forEachPoint(side, [&](const GridPoint& at) {
                const Index vertex = grid_.vertexAt(at);
                isAt[vertex] = 1;
                result.planesAt[vertex].add(side.normal);
            });
            for (Index face = 0; face < complex.count(2); ++face)
                if (std::ranges::all_of(complex.relation(2, 0)[face],
                                        [&](Index vertex) { return isAt[vertex] != 0; }))
                    result.isOpen[face] = 1;
        }
        return result;
    }

    /// Returns nothing if a side has no direction to grow in.
    std::optional<CollarCells> cells() {
        if (options_.until)
            requireBox();
        else if (!straighten())
            return std::nullopt;
        for (GridSide& side : sides_)
            if (!side.isOpen)
                side.parts = layerParts(options_.layers, meanReach(side), meanThickness(side));
        CollarCells result;
        result.isGrid = true;
        GridPoint low = {}, high = grid_.cells;
        for (const GridSide& side : sides_)
            if (!side.isOpen)
                (side.isUpper ? high : low)[side.axis] +=
                    side.isUpper ? options_.layers : -options_.layers;
        for (std::size_t a = 0; a < 3; ++a) count_[a] = high[a] - low[a] + 1;
        numbers_.resize(std::size_t(count_[0]) * count_[1] * count_[2]);
        auto next = static_cast<Index>(lattice_.positions.size());
        GridPoint at;
        low_ = low;
        for (at[2] = low[2]; at[2] <= high[2]; ++at[2])
            for (at[1] = low[1]; at[1] <= high[1]; ++at[1])
                for (at[0] = low[0]; at[0] <= high[0]; ++at[0]) {
                    if (isInside(at, 0)) {
                        number(at) = grid_.vertexAt(at);
                        continue;
                    }
                    number(at) = next++;
                    result.vertices.push_back(vertexAt(at));
                }
        for (at[2] = low[2]; at[2] < high[2]; ++at[2])
            for (at[1] = low[1]; at[1] < high[1]; ++at[1])
                for (at[0] = low[0]; at[0] < high[0]; ++at[0])
                    if (!isInside(at, 1)) result.prisms.push_back(prismAt(at));
        return result;
    }

private:
    Index& number(const GridPoint& at) {
        const auto along = [&](std::size_t a) { return std::size_t(at[a] - low_[a]); };
        return numbers_[(along(2) * count_[1] + along(1)) * count_[0] + along(0)];
    }

    /// Tells whether a grid point, or a cell (margin 1) by its lowest point, is in the lattice.
    bool isInside(const GridPoint& at, Index margin) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (at[a] < 0 || at[a] > grid_.cells[a] - margin) return false;
        return true;
    }

    const Point3& positionAt(const GridPoint& at) const {
        return lattice_.positions[grid_.vertexAt(at)];
    }

    bool isLeftHanded() const {
        // The cell at the origin of the grid has its corners in VTK's order.
        const Index origin = grid_.vertexAt({0, 0, 0});
        const Index along[] = {grid_.vertexAt({1, 0, 0}), grid_.vertexAt({0, 1, 0}),
                               grid_.vertexAt({0, 0, 1})};
        const Index cell = lattice_.complex.relation(0, 3)[origin][0];
        const auto corners = *far::hexahedronVertices(lattice_.complex, CellId(cell));
        const auto at = std::ranges::find(corners, origin) - corners.begin();
        std::size_t first = 0;
        const auto& neighbours = far::kHexahedronNeighbours[std::size_t(at)];
        while (corners[neighbours[first]] != along[0]) ++first;
        return corners[neighbours[(first + 1) % 3]] != along[1];
    }

    /// Calls use(at) for each grid point of a side.
    template <class Use>
    void forEachPoint(const GridSide& side, Use use) const {
        const std::size_t b = (side.axis + 1) % 3, c = (side.axis + 2) % 3;
        GridPoint at = {};
        at[side.axis] = side.isUpper ? grid_.cells[side.axis] : 0;
        for (at[c] = 0; at[c] <= grid_.cells[c]; ++at[c])
            for (at[b] = 0; at[b] <= grid_.cells[b]; ++at[b]) use(std::as_const(at));
    }

    /// Returns the next grid point inwards from a side.
    static GridPoint inwards(GridPoint at, const GridSide& side) {
        at[side.axis] += side.isUpper ? -1 : 1;
        return at;
    }

    Point3 normalOf(const GridSide& side) const {
        const std::size_t b = (side.axis + 1) % 3, c = (side.axis + 2) % 3;
        Point3 total = {};
        forEachPoint(side, [&](const GridPoint& at) {
            if (at[b] == grid_.cells[b] || at[c] == grid_.cells[c]) return;
            GridPoint right = at, up = at;
            ++right[b];
            ++up[c];
            GridPoint both = right;
            ++both[c];
            const Point3 loop[] = {positionAt(at), positionAt(right), positionAt(both),
                                   positionAt(up)};
            total = sum(total, areaVector(loop));
        });
        const bool isOutwards = side.isUpper != (order_[0] == 1);
        if (!(dot(total, total) > 0)) return {0, 0, 0};
        return scaled(normalised(total), isOutwards ? 1 : -1);
    }

    /// Returns the mean of the vertices of a side.
    Point3 middleOf(const GridSide& side) const {
        std::vector<Point3> positions;
        forEachPoint(side, [&](const GridPoint& at) { positions.push_back(positionAt(at)); });
        return mean(positions);
    }

    static std::size_t facingOf(const Point3& normal) {
        if (!(dot(normal, normal) > 0)) return kNowhere;
        std::size_t best = 0;
        for (std::size_t side = 1; side < 6; ++side)
            if (dot(normal, sideDirection(side)) > dot(normal, sideDirection(best))) best = side;
        return best;
    }

    /// Returns how well a side faces one of kSideWords: the cosine of the angle.
    static double facing(const GridSide& side, std::size_t direction) {
        return dot(side.normal, sideDirection(direction));
    }

    void openSides() {
        constexpr double kLeastFacing = 0.5, kAlike = 0.02;
        for (std::size_t open = 0; open < 6; ++open) {
            if (!options_.open[open]) continue;
            const auto isLess = [&](const GridSide& a, const GridSide& b) {
                return facing(a, open) < facing(b, open);
            };
            const auto refuse = [&](const std::string& expected) {
                throw ArgumentError("collar", "open", kSideWords[open], expected);
            };
            const auto side = std::max_element(sides_.begin(), sides_.end(), isLess);
            if (!(facing(*side, open) > kLeastFacing))
                refuse("a direction that a side of the lattice faces");
            for (auto other = sides_.begin(); other != sides_.end(); ++other)
                if (other != side && facing(*other, open) > facing(*side, open) - kAlike)
                    refuse(
                        concat("a direction that one side of the lattice faces; two sides face "
                               "it, with their middles at ",
                               textOf(middleOf(*side)), " and ", textOf(middleOf(*other)),
                               ": turn the lattice, or leave this direction out"));
            if (side->isOpen)
                refuse(concat(
                    "two directions, each of a side of its own; the side with its middle "
                    "at ",
                    textOf(middleOf(*side)), " faces this one and another: leave one of them out"));
            side->isOpen = true;
        }
        if (std::ranges::all_of(sides_, [](const GridSide& side) { return side.isOpen; }))
            throw Error("a collar: all six sides of the lattice are open; leave one of them out");
    }

    /// Makes the direction of each side perpendicular to the open sides next to it. Returns false
    /// if a side is nearly parallel to an open one, or has no area.
    bool straighten() {
        for (GridSide& side : sides_) {
            if (side.isOpen) continue;
            PlaneNormals planes;
            for (const GridSide& open : sides_)
                if (open.isOpen && open.axis != side.axis) planes.add(open.normal);
            side.direction = planes.inPlanes(side.direction);
            if (!(length(side.direction) > 0.5)) return false;
            side.direction = normalised(side.direction);
        }
        return true;
    }

    /// Lets the sides grow along the axes, to the box of CollarOptions::until.
    void requireBox() {
        std::array<bool, 6> isFaced = {};
        for (GridSide& side : sides_) {
            if (side.facing == kNowhere)
                throw Error("a collar: a side of the box lattice has no area");
            if (std::exchange(isFaced[side.facing], true))
                throw ArgumentError("collar", "until", "",
                                    concat("a lattice whose six sides face the six directions of "
                                           "the axes; two sides face ",
                                           kSideWords[side.facing], ": set reach instead"));
            side.direction = sideDirection(side.facing);
        }
        for (const GridSide& side : sides_) {
            if (side.isOpen) continue;
            const std::size_t c = side.facing / 2;
            const double end = untilOf(side), sign = side.facing % 2 == 1 ? 1 : -1;
            forEachPoint(side, [&](const GridPoint& at) {
                if (sign * (end - positionAt(at)[c]) > 0) return;
                throw ArgumentError(
                    "collar", "until", textOf(end),
                    concat("a box around the lattice; its side ", kSideWords[side.facing],
                           " has a vertex at ", textOf(positionAt(at)[c]),
                           ". Leave that side without a collar, or give a larger box"));
            });
        }
    }

    /// Returns the coordinate at which the box of CollarOptions::until ends over a side.
    double untilOf(const GridSide& side) const {
        const auto& [a, b] = *options_.until;
        const std::size_t c = side.facing / 2;
        return side.facing % 2 == 1 ? std::max(a[c], b[c]) : std::min(a[c], b[c]);
    }

    double meanReach(const GridSide& side) const {
        if (!options_.until) return options_.reach;
        double total = 0, count = 0;
        forEachPoint(side, [&](const GridPoint& at) {
            total += std::abs(untilOf(side) - positionAt(at)[side.facing / 2]);
            ++count;
        });
        return total / count;
    }

    double meanThickness(const GridSide& side) const {
        double total = 0, count = 0;
        forEachPoint(side, [&](const GridPoint& at) {
            total += std::abs(
                dot(difference(positionAt(at), positionAt(inwards(at, side))), side.direction));
            ++count;
        });
        return total / count;
    }

    CollarVertex vertexAt(const GridPoint& at) const {
        GridPoint nearest = at;
        for (std::size_t a = 0; a < 3; ++a) nearest[a] = std::clamp(at[a], 0, grid_.cells[a]);
        CollarVertex vertex{grid_.vertexAt(nearest), 0, positionAt(nearest)};
        int axes = 0;
        for (const GridSide& side : sides_) {
            const Index beyond = side.isUpper ? at[side.axis] - nearest[side.axis]
                                              : nearest[side.axis] - at[side.axis];
            const bool isEnd = nearest[side.axis] == (side.isUpper ? grid_.cells[side.axis] : 0);
            if (beyond <= 0) {
                if (side.isOpen && isEnd) vertex.planes.add(side.normal);
                continue;
            }
            ++axes;
            vertex.layer = std::max(vertex.layer, static_cast<int>(beyond));
            const double part = side.parts[std::size_t(beyond)];
            if (options_.until) {
                const std::size_t c = side.facing / 2;
                vertex.position[c] = std::lerp(vertex.position[c], untilOf(side), part);
            } else {
                vertex.position =
                    sum(vertex.position, scaled(side.direction, part * options_.reach));
            }
        }
        vertex.isStraight = axes == 1;
        return vertex;
    }

    CollarPrism prismAt(const GridPoint& at) {
        const auto corner = [&](Index first, Index second, Index third) {
            GridPoint point = at;
            point[order_[0]] += first;
            point[order_[1]] += second;
            point[2] += third;
            return number(point);
        };
        CollarPrism prism;
        for (const Index third : {0, 1})
            (third == 0 ? prism.bottom : prism.top) = {corner(0, 0, third), corner(1, 0, third),
                                                       corner(1, 1, third), corner(0, 1, third)};
        return prism;
    }

    const Lattice& lattice_;
    const far::BoxGrid& grid_;
    const CollarOptions& options_;
    std::array<std::size_t, 2> order_ = {0, 1};  ///< two axes that with axis 2 are right-handed
    std::array<GridSide, 6> sides_;
    GridPoint low_ = {}, count_ = {};
    std::vector<Index> numbers_;  ///< the vertex at each point of the larger grid
};

}  // namespace

OpenFaces openFacesOfBox(const Lattice& lattice, const far::BoxGrid& grid,
                         const CollarOptions& options) {
    return GridCollar(lattice, grid, options).openFaces();
}

std::optional<CollarCells> gridCollar(const Lattice& lattice, const far::BoxGrid& grid,
                                      const CollarOptions& options) {
    return GridCollar(lattice, grid, options).cells();
}

}  // namespace espalier::cages
