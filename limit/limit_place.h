// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/cell_place.h>
#include <espalier/stencils/levels.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "limit_tangents.h"
#include "tricubic_patch.h"

// Places in the limit volume, and their weights over the vertices of the level that they are in.
namespace espalier::limit {

/// In a hexahedron: (u, v, w) in its frame. `offset`, in the same coordinates, goes on from there
/// along the tangent.
struct FramePlace {
    embed::CellFrame frame;
    std::array<double, 3> uvw = {};
    std::array<double, 3> offset = {};
    bool isBlended = false;  ///< of the limits of its corners; else the cell is regular
};

/// A place in a cell of a level, either as above, or as in a level (of any cell), but between the
/// limits of its vertices.
struct LimitPlace {
    int level = 0;
    std::variant<FramePlace, embed::CellPlace> where;
};

/// Derivatives by u, v and w: each 0, 1 or 2; all 0 is the position.
using Orders = std::array<int, 3>;

/// Which derivatives of places are asked for: rows of tables in this order.
inline constexpr Orders kPosition = {0, 0, 0};
inline constexpr std::array<Orders, 3> kFirst = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
inline constexpr std::array<Orders, 6> kSecond = {
    {{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}}};

/// The limits of vertices of a level, as they are blended: a vertex on the open boundary, which has
/// none, is itself. It is within the size of a cell of where it goes.
stencils::StencilTable<double> blendedRows(const stencils::Levels& levels, int level,
                                           std::span<const Index> vertices);

/// Which cells of the finest level, 1 or above, are so small that they may be blended: no two of
/// their vertices are further apart than a fraction of the size of level 0, in any pose.
std::vector<std::uint8_t> areSmall(const stencils::Levels& levels, std::span<const Index> cells,
                                   double tolerance);

/// \throws Error if it is not 1e-14 to 0.1
void checkLimitTolerance(double tolerance);

/// The level from which on cells may be that small: refining halves a cell at best, or nearly so.
int leastLevelOfSmall(double tolerance);

/// The weights of places of one level over its vertices.
class PlaceRows {
public:
    /// \param levels, places must outlive this
    /// \param level of the places
    /// \cost that of the limits of vertices at irregular features
    PlaceRows(const stencils::Levels& levels, int level, std::span<const LimitPlace> places);

    /// A derivative at place i, along its tangent if it has an offset: that changes the position
    /// alone. Second ones of a FramePlace alone; those of a blend by u, v or w twice are 0.
    std::vector<embed::VertexWeight> weights(std::size_t i, const Orders& orders) const;

    /// Rows 3i to 3i + 2 give three directions of the limit at place i. They sum to 0. In a regular
    /// cell they are the derivatives by u, v and w. In a blend, they are the directions in which
    /// the cell leaves the nearest of its vertices (see buildTangentTable()).
    stencils::StencilTable<double> tangents() const;

private:
    CellCorner nearestCorner(std::size_t i) const;
    std::vector<embed::VertexWeight> inLimits(std::span<const embed::VertexWeight> weights) const;

    const stencils::Levels& levels_;
    int levelNumber_;
    const far::Level& level_;
    std::span<const LimitPlace> places_;
    std::vector<std::optional<TricubicPatch>> patches_;  ///< one a place
    std::vector<Index> vertices_;                        ///< whose limits are known, ascending
    stencils::StencilTable<double> limits_;              ///< a row for each of these
};

}  // namespace espalier::limit
