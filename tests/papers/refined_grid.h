// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/composition.h>

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "support/complexes.h"
#include "support/rows.h"

namespace espalier::test {

/// Steps along x, y and z; 0 along axes that a grid does not have.
using Place = std::array<Index, 3>;

/// A refined control polygon, net of quadrilaterals or lattice of hexahedra, with the place of each
/// vertex on each level.
///
/// Point P_i, P_ij or P_ijk of the papers is the vertex at (i, 0, 0), (i, j, 0) or (i, j, k). Under
/// Boundary::Open the outermost points of the refined grid do not exist: the new point at place p
/// comes from the old points at (p + 1)/2, rounded down and up. Under Boundary::Sharp they are at
/// p/2.
class RefinedGrid {
public:
    /// \param cells numbers of cells along the axes: one for a polygon, two for a net, three for a
    ///        lattice
    RefinedGrid(const std::vector<Index>& cells, int levels, Boundary boundary = Boundary::Open,
                far::Rules rules = far::Rules::Siggraph96)
        : refiner_(complexOf(cells), {.rules = rules, .boundary = boundary}) {
        refiner_.refineUniform(levels);
        std::vector<Place> places;
        Place size = {};
        for (std::size_t axis = 0; axis < cells.size(); ++axis) size[axis] = cells[axis];
        for (Index k = 0; k <= size[2]; ++k)
            for (Index j = 0; j <= size[1]; ++j)
                for (Index i = 0; i <= size[0]; ++i) places.push_back({i, j, k});
        const Index margin = boundary == Boundary::Open ? 1 : 0;
        for (int level = 0;; ++level) {
            sizes_.push_back(size);
            places_.push_back(places);
            vertices_.emplace_back();
            for (std::size_t v = 0; v < places.size(); ++v) vertices_.back()[places[v]] = Index(v);
            if (level == levels) break;
            places.clear();
            for (Index v = 0; v < refiner_.level(level + 1).complex.count(0); ++v) {
                Place doubled = doubledMiddle(level, parentOf(refiner_, level + 1, v));
                for (std::size_t axis = 0; axis < cells.size(); ++axis) doubled[axis] -= margin;
                places.push_back(doubled);
            }
            for (std::size_t axis = 0; axis < cells.size(); ++axis)
                size[axis] = 2 * (size[axis] - margin);
        }
    }

    const TopologyRefiner& refiner() const { return refiner_; }
    const CellComplex& complex(int level) const { return refiner_.level(level).complex; }

    /// Number of cells along each axis.
    const Place& size(int level) const { return sizes_[level]; }

    /// The place of each vertex.
    const std::vector<Place>& places(int level) const { return places_[level]; }

    Index vertexAt(int level, const Place& place) const { return vertices_[level].at(place); }

    /// The vertex at a place, as a row.
    Row at(int level, const Place& place) const { return point(vertexAt(level, place)); }

    /// The entity that became the vertex at a place.
    Entity parentAt(int level, const Place& place) const {
        return parentOf(refiner_, level, vertexAt(level, place));
    }

private:
    static CellComplex complexOf(const std::vector<Index>& cells) {
        if (cells.size() == 1) return far::buildCurve(cells[0] + 1, false);
        if (cells.size() == 2) return gridMesh(cells[0], cells[1]);
        return grid({cells[0], cells[1], cells[2]});
    }

    /// The entities of a grid are boxes: twice the middle of an entity is a place of a grid with
    /// twice the resolution.
    Place doubledMiddle(int level, Entity entity) const {
        const auto vertices = complex(level).relation(entity.dimension, 0)[entity.index];
        Place sum = {};
        for (const Index vertex : vertices)
            for (std::size_t axis = 0; axis < 3; ++axis)
                sum[axis] += 2 * places(level)[vertex][axis];
        for (Index& x : sum) x /= Index(vertices.size());
        return sum;
    }

    TopologyRefiner refiner_;
    std::vector<Place> sizes_;
    std::vector<std::vector<Place>> places_;
    std::vector<std::map<Place, Index>> vertices_;
};

/// Multiplies rows along different axes of a net or a lattice of level 0: P_i, P_j and P_k give
/// P_ijk.
inline Row tensorProduct(const RefinedGrid& grid, const Row& x, const Row& y,
                         const Row& z = point(0)) {
    Row product;
    for (const auto& [i, a] : x.weights)
        for (const auto& [j, b] : y.weights)
            for (const auto& [k, c] : z.weights)
                product.weights[grid.vertexAt(0, {i, j, k})] = a * b * c;
    return product;
}

/// Returns the weights of the cubic uniform B-spline P(t) = [1 t t² t³] M [P_(s−1) P_s P_(s+1)
/// P_(s+2)]ᵀ of Joy's notes at s + t, for a polygon P_0, P_1, …; the range is from 1 to the number
/// of edges − 1.
inline Row splineAt(double place, Index edges) {
    const Index first = std::min(Index(place), edges - 2);
    const double t = place - first;
    return {{{first - 1, (1 - t) * (1 - t) * (1 - t) / 6},
             {first, (4 - 6 * t * t + 3 * t * t * t) / 6},
             {first + 1, (1 + 3 * t + 3 * t * t - 3 * t * t * t) / 6},
             {first + 2, t * t * t / 6}}};
}

}  // namespace espalier::test
