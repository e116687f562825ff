// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/cell_place.h>
#include <espalier/embed/gradients.h>
#include <espalier/embed/tricubic_patch.h>
#include <espalier/stencils/levels.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "layered_edge.h"
#include "limit_tangents.h"

// Places in the limit volume, and their weights over the vertices of their level.
namespace espalier::limit {

/// A place in a hexahedron: (u, v, w) in its frame. `offset`, in the same coordinates, continues
/// from there along the tangent.
struct FramePlace {
    embed::CellFrame frame;
    std::array<double, 3> uvw = {};
    std::array<double, 3> offset = {};
    bool isBlended = false;  ///< the limits of the corners are blended; else the cell is regular
};

/// A place on a layered edge. `offset`, in the directions of the rows, continues from there along
/// the tangent.
struct EdgePlace {
    std::shared_ptr<const EdgeRows> rows;
    std::array<double, 3> offset = {};
};

/// A place in a cell or on an edge of a level. A FramePlace is in a hexahedron. A CellPlace is in a
/// cell of any type, with the meaning it has in a level, except that the vertices are at their
/// limits.
struct LimitPlace {
    int level = 0;
    std::variant<FramePlace, embed::CellPlace, EdgePlace> where;
};

/// Orders of a derivative by u, v and w, each 0, 1 or 2. All 0 is the position.
using Orders = std::array<int, 3>;

/// Derivatives of each order. Tables have their rows in this order.
inline constexpr Orders kPosition = {0, 0, 0};
inline constexpr std::array<Orders, 3> kFirst = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
inline constexpr std::array<Orders, 6> kSecond = {
    {{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}}};

/// Returns the rows of the limits of vertices of a level, for blending. A vertex on the open
/// boundary has no limit; its row is the vertex itself. Refinement moves this vertex by less than
/// the size of a cell.
stencils::StencilTable<double> blendedRows(const stencils::Levels& levels, int level,
                                           std::span<const Index> vertices);

/// Returns an upper bound of the size of each cell of the finest level, in units of the size of
/// level 0. In any pose, no two vertices of the cell are further apart than this. If the bound is
/// at most the tolerance, the cell is blended.
/// \pre the finest level is 1 or above
/// \cost the cost of the rows of S around the cells, on all levels
std::vector<double> cellSizes(const stencils::Levels& levels, std::span<const Index> cells);

/// \param name of the tolerance, for the error
/// \throws ArgumentError unless the tolerance is 1e-14 to 0.1
void checkLimitTolerance(double tolerance, const std::string& name);

/// Returns the least number of levels, 1 or more, after which a cell of a given size may be as
/// small as the tolerance. A level cannot make a cell much smaller than half its size.
int levelsToShrink(double size, double tolerance);

/// Computes the weights of places of one level over the vertices of the level.
class PlaceRows {
public:
    /// \param levels, places must outlive this
    /// \param level level of the places
    /// \cost the cost of the limits of vertices at irregular features
    PlaceRows(const stencils::Levels& levels, int level, std::span<const LimitPlace> places);

    int level() const { return levelNumber_; }

    /// Returns a derivative at place i. An offset of the place continues the position along the
    /// tangent; it does not change derivatives. On an edge, the first derivatives are the
    /// directions of the edge's rows. Second derivatives exist for a FramePlace only. In a blend,
    /// second derivatives by the same coordinate twice are 0.
    std::vector<embed::VertexWeight> weights(std::size_t i, const Orders& orders) const;

    /// Rows 3i to 3i + 2 give three directions of the limit at place i. They sum to 0. In a regular
    /// cell and on an edge they are the first derivatives. In a blend, they are the directions in
    /// which the edges of the cell leave the vertex that has the largest weight (see
    /// buildTangentTable()).
    stencils::StencilTable<double> tangents() const;

    /// Returns the places in regular cells, with patches over the vertices of the level. Leaves out
    /// places at which the derivatives almost lie in a plane, where rows are more accurate.
    embed::SplinePlaces splinePlaces() const;

private:
    CellCorner nearestCorner(std::size_t i) const;
    std::vector<embed::VertexWeight> inLimits(std::span<const embed::VertexWeight> weights) const;
    /// Returns true if limits of vertices are blended at place i.
    bool isBlended(std::size_t i) const {
        const auto* place = std::get_if<FramePlace>(&places_[i].where);
        return place ? place->isBlended
                     : std::holds_alternative<embed::CellPlace>(places_[i].where);
    }

    const stencils::Levels& levels_;
    int levelNumber_;
    const far::Level& level_;
    std::span<const LimitPlace> places_;
    std::vector<embed::TricubicPatch> patches_;  ///< one for each regular cell
    std::vector<Index> patchOf_;             ///< the patch of each place; kMaxIndex if it has none
    std::vector<Index> vertices_;            ///< vertices whose limits are known, ascending
    stencils::StencilTable<double> limits_;  ///< a row for each of `vertices_`
};

}  // namespace espalier::limit
