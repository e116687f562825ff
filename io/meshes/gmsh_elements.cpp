// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/second_order_cells.h>

#include <utility>

#include "gmsh_elements.h"

namespace espalier::io {
namespace {

using far::between, far::CornerBits;

// The nodes of cells of second order as Gmsh orders them. The smaller number of nodes of a kind is
// a prefix of the larger one.
constexpr CornerBits kTetrahedronNodes[] = {
    between(0),    between(1),    between(2),    between(3),    between(0, 1),
    between(1, 2), between(2, 0), between(3, 0), between(2, 3), between(1, 3)};
constexpr CornerBits kHexahedronNodes[] = {
    between(0),          between(1),          between(2),
    between(3),          between(4),          between(5),
    between(6),          between(7),          between(0, 1),
    between(0, 3),       between(0, 4),       between(1, 2),
    between(1, 5),       between(2, 3),       between(2, 6),
    between(3, 7),       between(4, 5),       between(4, 7),
    between(5, 6),       between(6, 7),       between(0, 3, 2, 1),
    between(0, 1, 5, 4), between(0, 4, 7, 3), between(1, 2, 6, 5),
    between(2, 3, 7, 6), between(4, 5, 6, 7), between(0, 1, 2, 3, 4, 5, 6, 7)};
constexpr CornerBits kPrismNodes[] = {
    between(0),          between(1),          between(2),         between(3),    between(4),
    between(5),          between(0, 1),       between(0, 2),      between(0, 3), between(1, 2),
    between(1, 4),       between(2, 5),       between(3, 4),      between(3, 5), between(4, 5),
    between(0, 1, 4, 3), between(0, 2, 5, 3), between(1, 2, 5, 4)};
constexpr CornerBits kPyramidNodes[] = {
    between(0),    between(1),    between(2),    between(3),         between(4),
    between(0, 1), between(0, 3), between(0, 4), between(1, 2),      between(1, 4),
    between(2, 3), between(2, 4), between(3, 4), between(0, 1, 2, 3)};

/// Returns the nodes of a kind of cell in Gmsh's order, and the corners in VTK's order by their
/// numbers there. Gmsh's first triangle of a prism is anticlockwise seen from the other one, unlike
/// VTK's.
std::pair<std::span<const CornerBits>, std::span<const std::size_t>> nodesOf(
    far::StandardCell kind) {
    static constexpr std::size_t kCorners[] = {0, 1, 2, 3, 4, 5, 6, 7};
    static constexpr std::size_t kPrismCorners[] = {0, 2, 1, 3, 5, 4};
    const auto corners = std::span(kCorners).first(far::vertexCount(kind));
    switch (kind) {
        case far::StandardCell::Tetrahedron:
            return {kTetrahedronNodes, corners};
        case far::StandardCell::Pyramid:
            return {kPyramidNodes, corners};
        case far::StandardCell::Wedge:
            return {kPrismNodes, kPrismCorners};
        case far::StandardCell::Hexahedron:
            break;
    }
    return {kHexahedronNodes, corners};
}

constexpr GmshElementType kElementTypes[] = {
    {15, 0, 1, {}, false},
    {1, 1, 2, {}, false},
    {2, 2, 3, {}, false},
    {3, 2, 4, {}, false},
    {4, 3, 4, far::StandardCell::Tetrahedron, false},
    {5, 3, 8, far::StandardCell::Hexahedron, false},
    {6, 3, 6, far::StandardCell::Wedge, false},
    {7, 3, 5, far::StandardCell::Pyramid, false},
    {8, 1, 3},
    {26, 1, 4},
    {27, 1, 5},
    {28, 1, 6},
    {9, 2, 6, {}, true, true},
    {20, 2, 9},
    {21, 2, 10},
    {22, 2, 12},
    {23, 2, 15},
    {24, 2, 15},
    {25, 2, 21},
    {10, 2, 9, {}, true, true},
    {16, 2, 8, {}, true, true},
    {36, 2, 16},
    {37, 2, 25},
    {11, 3, 10, far::StandardCell::Tetrahedron},
    {29, 3, 20},
    {30, 3, 35},
    {31, 3, 56},
    {12, 3, 27, far::StandardCell::Hexahedron},
    {17, 3, 20, far::StandardCell::Hexahedron},
    {92, 3, 64},
    {93, 3, 125},
    {13, 3, 18, far::StandardCell::Wedge},
    {18, 3, 15, far::StandardCell::Wedge},
    {90, 3, 40},
    {91, 3, 75},
    {14, 3, 14, far::StandardCell::Pyramid},
    {19, 3, 13, far::StandardCell::Pyramid},
};

}  // namespace

std::optional<GmshElementType> gmshElementType(std::int64_t number) {
    for (const GmshElementType& type : kElementTypes)
        if (type.number == number) return type;
    return std::nullopt;
}

std::vector<Index> gmshCellInVtkOrder(far::StandardCell kind, std::span<const Index> nodes) {
    const auto [places, corners] = nodesOf(kind);
    return far::reorderedCell(nodes, places, corners);
}

}  // namespace espalier::io
