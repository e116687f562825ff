// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/box_grid.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/topology_error.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace espalier::far {
namespace {

using GridPoint = std::array<Index, 3>;

/// The vertices of a hexahedron by position in the grid: bit a of the index is 1 at the far end of
/// axis a.
using Corners = std::array<Index, 8>;

constexpr std::array<std::size_t, 3> kAxisBits = {1, 2, 4};

[[noreturn]] void refuse(Entity entity, const std::string& cause) {
    throw TopologyError(TopologyCause::NotABox, entity,
                        "the lattice is not a box of hexahedra: " + cause);
}

std::string inBrackets(const GridPoint& point) {
    std::string text = "(";
    text += concat(point[0], ", ", point[1]);
    return concat(text, ", ", point[2], ")");
}

Corners cornersOf(const CellComplex& complex, CellId cell) {
    const auto vertices = hexahedronVertices(complex, cell);
    if (!vertices) refuse(cell, concat("cell ", cell.value, " is not a hexahedron"));
    // VTK's order runs round the quadrilateral.
    constexpr std::array<std::size_t, 8> kPosition = {0, 1, 3, 2, 4, 5, 7, 6};
    Corners corners;
    for (std::size_t i = 0; i < 8; ++i) corners[kPosition[i]] = (*vertices)[i];
    return corners;
}

std::size_t positionOf(const Corners& corners, Index vertex) {
    return std::find(corners.begin(), corners.end(), vertex) - corners.begin();
}

/// Returns the three neighbours, along edges of the hexahedron, of the corner at a position.
std::array<Index, 3> neighbours(const Corners& corners, std::size_t position) {
    return {corners[position ^ 1], corners[position ^ 2], corners[position ^ 4]};
}

/// Returns the same hexahedron with `origin` at position 0 and its neighbours next[a] along the
/// axes.
Corners seenFrom(const Corners& corners, Index origin, const std::array<Index, 3>& next) {
    const std::size_t from = positionOf(corners, origin);
    Corners turned;
    for (std::size_t i = 0; i < 8; ++i) {
        std::size_t position = from;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (i & kAxisBits[axis]) position ^= from ^ positionOf(corners, next[axis]);
        turned[i] = corners[position];
    }
    return turned;
}

/// A cell with its corners in the order of the grid's axes.
struct PlacedCell {
    CellId cell;
    Corners corners;
};

/// Returns the face of a cell at the far end of an axis.
FaceId farFace(const CellComplex& complex, const PlacedCell& placed, std::size_t axis) {
    for (const FaceId face : complex.faces(placed.cell)) {
        const auto loop = complex.relation(2, 0)[face.value];
        bool isFar = true;
        for (std::size_t i = 0; i < 8; ++i)
            isFar = isFar && (!(i & kAxisBits[axis]) || contains(loop, placed.corners[i]));
        if (isFar) return face;
    }
    refuse(placed.cell, concat("cell ", placed.cell.value, " lacks one of its six faces"));
}

/// Returns the next cell along an axis; nothing at the boundary.
std::optional<PlacedCell> nextCell(const CellComplex& complex, const PlacedCell& placed,
                                   std::size_t axis) {
    const auto cells = complex.cells(farFace(complex, placed, axis));
    if (cells.size() != 2) return std::nullopt;
    const CellId cell = cells[0] == placed.cell ? cells[1] : cells[0];
    const Corners corners = cornersOf(complex, cell);
    const std::size_t bit = kAxisBits[axis];
    const Index origin = placed.corners[bit];
    const Index second = placed.corners[bit | kAxisBits[(axis + 1) % 3]];
    const Index third = placed.corners[bit | kAxisBits[(axis + 2) % 3]];
    std::array<Index, 3> next = {};
    next[(axis + 1) % 3] = second;
    next[(axis + 2) % 3] = third;
    for (const Index vertex : neighbours(corners, positionOf(corners, origin)))
        if (vertex != second && vertex != third) next[axis] = vertex;
    return PlacedCell{cell, seenFrom(corners, origin, next)};
}

/// Finds the grid point of each vertex, cell by cell.
class GridPointFinder {
public:
    explicit GridPointFinder(const CellComplex& complex)
        : complex_(complex),
          points_(complex.count(0)),
          isPlaced_(complex.count(3), 0),
          first_(firstCell()) {
        for (std::size_t axis = 0; axis < 3; ++axis) grid_.cells[axis] = cellsAlong(axis);
        placeCells();
        checkCells();
        placeVertices();
        checkFaces();
    }

    BoxGrid takeGrid() { return std::move(grid_); }

private:
    PlacedCell firstCell() const {
        for (Index vertex = 0; vertex < complex_.count(0); ++vertex) {
            const auto cells = complex_.relation(0, 3)[vertex];
            if (cells.size() != 1) continue;
            const Corners corners = cornersOf(complex_, CellId(cells[0]));
            auto next = neighbours(corners, positionOf(corners, vertex));
            std::sort(next.begin(), next.end());
            return {CellId(cells[0]), seenFrom(corners, vertex, next)};
        }
        refuse(CellId(0),
               "there is no corner: each vertex of cell 0, and of all others, is in two or "
               "more cells");
    }

    /// Counts the cells along an axis. The loop ends at the boundary: a step straight on can be
    /// undone, so it does not reach a cell twice in the same direction, and never the first cell
    /// again, which has no cell behind it.
    Index cellsAlong(std::size_t axis) const {
        Index count = 1;
        for (auto at = nextCell(complex_, first_, axis); at; at = nextCell(complex_, *at, axis))
            ++count;
        return count;
    }

    /// Places row after row and slab after slab. Stops by an error before it places more cells than
    /// exist: a cell that comes up a second time has vertices that were placed elsewhere.
    void placeCells() {
        const auto& n = grid_.cells;
        PlacedCell slab = first_;
        for (Index k = 0; k < n[2]; ++k) {
            PlacedCell row = slab;
            for (Index j = 0; j < n[1]; ++j) {
                PlacedCell cell = row;
                for (Index i = 0; i < n[0]; ++i) {
                    placeCell(cell, {i, j, k});
                    if (i + 1 < n[0]) cell = stepFrom(cell, 0);
                }
                if (j + 1 < n[1]) row = stepFrom(row, 1);
            }
            if (k + 1 < n[2]) slab = stepFrom(slab, 2);
        }
    }

    void placeCell(const PlacedCell& placed, const GridPoint& low) {
        isPlaced_[placed.cell.value] = 1;
        for (std::size_t i = 0; i < 8; ++i) {
            GridPoint point = low;
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (i & kAxisBits[axis]) ++point[axis];
            auto& known = points_[placed.corners[i]];
            if (known && *known != point)
                refuse(VertexId(placed.corners[i]),
                       concat("vertex ", placed.corners[i], " would have two places in the box, ",
                              inBrackets(*known), " and ", inBrackets(point)));
            known = point;
        }
    }

    PlacedCell stepFrom(const PlacedCell& placed, std::size_t axis) const {
        const auto next = nextCell(complex_, placed, axis);
        if (next) return *next;
        const FaceId face = farFace(complex_, placed, axis);
        refuse(face, concat("face ", face.value, " of cell ", placed.cell.value,
                            " is on the boundary, but a box of ", sizes(), " cells goes on there"));
    }

    void checkCells() const {
        for (Index cell = 0; cell < complex_.count(3); ++cell)
            if (!isPlaced_[cell])
                refuse(CellId(cell),
                       concat("cell ", cell, " is not part of the box of ", sizes(),
                              " cells with its corner at vertex ", first_.corners[0]));
    }

    /// Fills the grid. Every grid point has a vertex of some cell, but it has two vertices if cells
    /// that meet there have no common face.
    void placeVertices() {
        std::vector<std::optional<Index>> vertices(grid_.indexOf(grid_.cells) + 1);
        for (Index vertex = 0; vertex < complex_.count(0); ++vertex) {
            const auto& point = points_[vertex];
            if (!point) refuse(VertexId(vertex), concat("vertex ", vertex, " is in no cell"));
            auto& there = vertices[grid_.indexOf(*point)];
            if (there)
                refuse(VertexId(vertex),
                       concat("vertices ", *there, " and ", vertex,
                              " would have the same place in the box, ", inBrackets(*point)));
            there = vertex;
        }
        for (const auto& vertex : vertices) grid_.vertices.push_back(vertex.value());
    }

    /// Checks that all boundary faces are on the surface of the box. Fails if there is a slit
    /// inside: two cells with the same vertices but with separate faces.
    void checkFaces() const {
        for (Index face = 0; face < complex_.count(2); ++face) {
            if (complex_.relation(2, 3)[face].size() == 2) continue;
            GridPoint low = grid_.cells, high = {};
            for (const Index vertex : complex_.relation(2, 0)[face])
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const Index at = (*points_[vertex])[axis];
                    low[axis] = std::min(low[axis], at);
                    high[axis] = std::max(high[axis], at);
                }
            bool isOutside = false;
            for (std::size_t axis = 0; axis < 3; ++axis)
                isOutside = isOutside || high[axis] == 0 || low[axis] == grid_.cells[axis];
            if (!isOutside)
                refuse(FaceId(face),
                       concat("face ", face, " is inside the box, but lies in one cell only"));
        }
    }

    std::string sizes() const {
        return concat(grid_.cells[0], " × ", grid_.cells[1], " × ", grid_.cells[2]);
    }

    const CellComplex& complex_;
    std::vector<std::optional<GridPoint>> points_;  ///< the grid point of each vertex
    std::vector<char> isPlaced_;                    ///< whether each cell is placed
    PlacedCell first_;
    BoxGrid grid_;
};

}  // namespace

BoxGrid asBoxGrid(const CellComplex& complex) {
    if (complex.dimension() != 3)
        throw TopologyError(
            TopologyCause::WrongDimension, {complex.dimension(), 0},
            concat("expected a lattice that is a box of hexahedra, got a complex of dimension ",
                   complex.dimension()));
    // First of all, so that the error names the first cell that is not a hexahedron.
    for (Index cell = 0; cell < complex.count(3); ++cell) cornersOf(complex, CellId(cell));
    return GridPointFinder(complex).takeGrid();
}

}  // namespace espalier::far
