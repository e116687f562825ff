// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/standard_cells.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// The standard cells of second order, whose edges are parabolas. Such a cell has further points in
// the middle of its edges, and perhaps of its quadrilaterals and of its inside.
namespace espalier::far {

/// The corners between which a point of a cell lies, as bits: bit c stands for corner c. A corner
/// has one bit, the middle of an edge two, the middle of a quadrilateral four. In the middle of a
/// cell, all corners have their bits.
using CornerBits = std::uint8_t;

/// Returns the bits of some corners: between(0, 1) is the middle of the edge from corner 0 to 1.
template <class... Corners>
constexpr CornerBits between(Corners... corners) {
    return static_cast<CornerBits>(((1u << corners) | ...));
}

/// Returns the kind of a cell by its number of points. Of first order: 4, 5, 6, 8, as
/// vertexCount(). Of second order:
///
/// | kind        | points | besides the corners                                        |
/// |-------------|--------|------------------------------------------------------------|
/// | Tetrahedron | 10     | edges                                                      |
/// | Pyramid     | 13     | edges                                                      |
/// |             | 14     | edges, the base                                            |
/// | Wedge       | 15     | edges                                                      |
/// |             | 18     | edges, quadrilaterals                                      |
/// | Hexahedron  | 20     | edges                                                      |
/// |             | 27     | edges, faces, the inside                                   |
///
/// Returns nothing for all other numbers.
ESPALIER_API std::optional<StandardCell> kindOfCell(std::size_t pointCount);

/// Returns true for 10, 13, 14, 15, 18, 20 and 27.
ESPALIER_API bool isSecondOrder(std::size_t pointCount);

/// Returns the place of each point of a cell in VTK's order: the types 24 (tetrahedron), 25 and 29
/// (hexahedron), 26 and 32 (wedge), and 27 (pyramid). VTK has no pyramid of 14 points; its last
/// point is the middle of the base.
/// \param pointCount a number that kindOfCell() accepts
ESPALIER_API std::span<const CornerBits> cellPoints(std::size_t pointCount);

/// Brings the points of a cell into another order.
///
/// \param points the points of a cell
/// \param places the place of each point, with the corners as the file numbers them
/// \param corners the numbers in the file of the corners in VTK's order
/// \return the points in the order of cellPoints()
/// \throws Error if no point has one of the places there
ESPALIER_API std::vector<Index> reorderedCell(std::span<const Index> points,
                                              std::span<const CornerBits> places,
                                              std::span<const std::size_t> corners);

/// Turns a cell of either order into its mirror image, which has the opposite orientation.
/// \param points in the order of cellPoints()
ESPALIER_API void mirrorCell(std::span<Index> points);

}  // namespace espalier::far
