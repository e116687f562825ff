// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/cell_frame.h>
#include <espalier/far/standard_cells.h>

#include <algorithm>

namespace espalier::embed {
namespace {

/// The number in a frame of each corner of a hexahedron in VTK's order.
constexpr std::array<std::size_t, 8> kPlaceOfVtk = {0, 1, 3, 2, 4, 5, 7, 6};

/// Returns the entity that some of the axes span from a corner.
/// \param axes bit a is set if axis a is among them
Entity spannedBy(const far::CellComplex& complex, const CellFrame& frame, std::size_t corner,
                 std::size_t axes) {
    const int dimension = static_cast<int>((axes & 1) + (axes >> 1 & 1) + (axes >> 2 & 1));
    const Index from = frame.corners[corner];
    if (dimension == 0) return {0, from};
    if (dimension == 3) return {3, frame.cell};
    const Index to = frame.corners[corner ^ axes];
    // The edge with both vertices, or the face of the cell in which they are opposite corners.
    for (const Index index : complex.relation(3, dimension)[frame.cell]) {
        const auto vertices = complex.relation(dimension, 0)[index];
        if (far::contains(vertices, from) && far::contains(vertices, to)) return {dimension, index};
    }
    return {dimension, kMaxIndex};  // The frame does not belong to this complex.
}

}  // namespace

std::optional<CellFrame> frameOf(const far::CellComplex& complex, Index cell) {
    const auto vertices = far::hexahedronVertices(complex, CellId(cell));
    if (!vertices) return std::nullopt;
    CellFrame frame{cell, {}};
    for (std::size_t i = 0; i < 8; ++i) frame.corners[kPlaceOfVtk[i]] = (*vertices)[i];
    return frame;
}

std::optional<CellFrame> neighbourOf(const far::CellComplex& complex, const CellFrame& frame,
                                     std::size_t axis, std::size_t side) {
    const std::size_t step = std::size_t{1} << axis;
    const std::size_t corner = side << axis;
    const Entity face = spannedBy(complex, frame, corner, 7 - step);
    const auto cells = complex.relation(2, 3)[face.index];
    const auto other =
        std::find_if(cells.begin(), cells.end(), [&](Index cell) { return cell != frame.cell; });
    if (other == cells.end()) return std::nullopt;
    const auto itsFrame = frameOf(complex, *other);
    if (!itsFrame) return std::nullopt;
    // The places of the face's corners in the other cell's own frame. The face is where one bit of
    // the place, `across`, is the same for all four.
    std::array<std::size_t, 8> places = {};
    std::size_t allOnes = 7, allZeros = 7;
    for (std::size_t i = 0; i < 8; ++i) {
        if (bitOf(i, axis) != side) continue;
        places[i] =
            std::find(itsFrame->corners.begin(), itsFrame->corners.end(), frame.corners[i]) -
            itsFrame->corners.begin();
        allOnes &= places[i];
        allZeros &= ~places[i];
    }
    const std::size_t across = allOnes | allZeros;
    CellFrame result{*other, {}};
    for (std::size_t i = 0; i < 8; ++i) {
        if (bitOf(i, axis) != side) continue;
        result.corners[i ^ step] = frame.corners[i];
        result.corners[i] = itsFrame->corners[places[i] ^ across];
    }
    return result;
}

std::optional<CellFrame> childOf(const far::CellComplex& parent, const far::Refinement& refinement,
                                 const CellFrame& frame, std::size_t corner) {
    const auto cell = refinement.childOf({{0, frame.corners[corner]}, {3, frame.cell}});
    if (!cell) return std::nullopt;
    CellFrame child{cell->index, {}};
    for (std::size_t i = 0; i < 8; ++i) {
        // The child of the entity between the two corners: it is half way along the axes in which
        // they differ.
        const Entity entity = spannedBy(parent, frame, corner, corner ^ i);
        child.corners[i] = refinement.childOf({entity, entity})->index;
    }
    return child;
}

}  // namespace espalier::embed
