// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "../lattices/lattice_parts.h"
#include "vtk_cells.h"

namespace espalier::io {

using far::StandardCell;

namespace {

constexpr std::int64_t kVtkPixel = 8;
constexpr std::int64_t kVtkQuadrilateral = 9;
constexpr std::int64_t kVtkVoxel = 11;

/// The largest number of edges of a standard cell; a hexahedron has it.
constexpr std::size_t kMaxEdges = 12;

struct CellType {
    std::int64_t number;
    StandardCell kind;
};

constexpr CellType kCellTypes[] = {{10, StandardCell::Tetrahedron},
                                   {kVtkVoxel, StandardCell::Hexahedron},
                                   {12, StandardCell::Hexahedron},
                                   {13, StandardCell::Wedge},
                                   {14, StandardCell::Pyramid}};

/// Returns 5 or 6 for a pentagonal or hexagonal prism; 0 for all other types.
std::size_t sidesOfPrism(std::int64_t type) {
    return type == 15 ? 5 : type == 16 ? 6 : 0;
}

std::optional<StandardCell> kindOf(std::int64_t type) {
    for (const CellType& entry : kCellTypes)
        if (entry.number == type) return entry.kind;
    return std::nullopt;
}

std::uint8_t typeOf(StandardCell kind) {
    const auto at = std::find_if(
        std::begin(kCellTypes), std::end(kCellTypes),
        [&](const CellType& entry) { return entry.kind == kind && entry.number != kVtkVoxel; });
    return static_cast<std::uint8_t>(at->number);
}

/// Returns the number of points of a cell of a volume of second order; 0 for all other types. Among
/// cells of any order (Lagrange), only the order of the points of tetrahedra is the same in all
/// versions of VTK.
std::size_t secondOrderCellPoints(std::int64_t type) {
    constexpr std::pair<std::int64_t, std::size_t> kTypes[] = {
        {24, 10}, {25, 20}, {29, 27}, {26, 15}, {32, 18}, {27, 13}, {71, 10}};
    for (const auto& [number, points] : kTypes)
        if (number == type) return points;
    return 0;
}

/// Returns the number of points of a face of first or second order; 0 for all other types. A
/// polygon has any number of points.
std::size_t facePoints(std::int64_t type, std::size_t pointCount) {
    constexpr std::pair<std::int64_t, std::size_t> kTypes[] = {{5, 3},  {8, 4},  {9, 4},  {22, 6},
                                                               {23, 8}, {28, 9}, {69, 6}, {70, 9}};
    if (type == kVtkPolygon) return pointCount;
    for (const auto& [number, points] : kTypes)
        if (number == type) return points;
    return 0;
}

/// Returns true for volume cells of higher order: quadratic, Lagrange and Bézier.
bool isCurved(std::int64_t type) {
    constexpr std::int64_t kCurved[] = {24, 25, 26, 27, 29, 31, 32, 33, 37,
                                        71, 72, 73, 74, 78, 79, 80, 81};
    return std::ranges::count(kCurved, type) > 0;
}

/// Returns " (tetrahedron)" and the like for cells of a volume that are not curved; else nothing.
const char* nameOfType(std::int64_t type) {
    switch (type) {
        case 10:
            return " (tetrahedron)";
        case kVtkVoxel:
            return " (voxel)";
        case 12:
            return " (hexahedron)";
        case 13:
            return " (wedge)";
        case 14:
            return " (pyramid)";
        case 15:
            return " (pentagonal prism)";
        case 16:
            return " (hexagonal prism)";
        case kVtkPolyhedron:
            return " (polyhedron)";
        default:
            return "";
    }
}

}  // namespace

std::optional<int> lowDimensionOf(std::int64_t type) {
    constexpr std::int64_t kLines[] = {3, 4, 21, 35, 68, 75};
    constexpr std::int64_t kSurfaces[] = {5, 6, 7, 8, 9, 22, 23, 28, 30, 34, 36, 69, 70, 76, 77};
    if (type == 1 || type == 2) return 0;
    if (std::ranges::count(kLines, type) > 0) return 1;
    if (std::ranges::count(kSurfaces, type) > 0) return 2;
    return std::nullopt;
}

void VtkFaceReader::beginPiece(std::size_t firstPoint, std::size_t pointCount) {
    firstPoint_ = firstPoint;
    pointCount_ = pointCount;
}

void VtkFaceReader::add(std::int64_t type, std::span<const std::int64_t> points) {
    if (type < 5 || type > 9) {
        ++otherCells_[type];
        return;
    }
    std::vector<Index> corners;
    for (const std::int64_t point : points) {
        if (point < 0 || static_cast<std::uint64_t>(point) >= pointCount_)
            throw FileError(path_, concat("a face names point ", point, "; there are ", pointCount_,
                                          " points"));
        corners.push_back(static_cast<Index>(firstPoint_ + point));
    }
    if (type == kVtkStrip) return faces_.addStrip(corners);
    // A pixel orders its points by rows; a quadrilateral goes around.
    if (type == kVtkPixel && corners.size() == 4) std::swap(corners[2], corners[3]);
    faces_.corners.insert(faces_.corners.end(), corners.begin(), corners.end());
    faces_.endFace();
}

void VtkFaceReader::giveTo(ModelSurface& surface) {
    constexpr std::int64_t kEmptyCell = 0;
    surface.faces = std::move(faces_);
    for (const auto& [type, count] : otherCells_) {
        const auto dimension = lowDimensionOf(type);
        if (dimension == 0 || dimension == 1)
            surface.addOther(dimension == 0 ? "vertex cells" : "lines");
        else if (type != kEmptyCell)
            surface.otherShapes.push_back(concat(count, count == 1 ? " cell" : " cells",
                                                 " of VTK's type ", type, nameOfType(type)));
    }
}

void VtkCellReader::beginPiece(Index firstVertex, Index vertexCount) {
    firstVertex_ = firstVertex;
    pieceVertexCount_ = vertexCount;
}

void VtkCellReader::add(std::int64_t type, std::span<const std::int64_t> vertices) {
    if (const auto dimension = lowDimensionOf(type)) {
        if (*dimension == 2)
            addFace(type, vertices);
        else
            visitor_.smallCell(*dimension, {});
        ++cellInFile_;
        return;
    }
    if (const std::size_t sides = sidesOfPrism(type)) return addPrism(sides, vertices);
    const std::optional<StandardCell> kind = kindOf(type);
    if (!kind && acceptsCurved_ && isCurved(type)) {
        std::vector<Index> points;
        if (secondOrderCellPoints(type) == vertices.size())
            for (const std::int64_t vertex : vertices) points.push_back(checkedVertex(vertex));
        ++cellInFile_;
        return visitor_.curvedCell(3, points);
    }
    if (!kind)
        fail(concat("is of VTK's type ", type, "; only the types 10 to 16 and 42 can be read"));
    std::vector<Index> checked;
    for (const std::int64_t vertex : vertices) checked.push_back(checkedVertex(vertex));
    if (type == kVtkVoxel && checked.size() == 8) {
        // A voxel orders its vertices by z, then y, then x; a hexahedron goes around its faces.
        std::swap(checked[2], checked[3]);
        std::swap(checked[6], checked[7]);
    }
    visitor_.cell(*kind, checked);
    ++cellCount_;
    ++cellInFile_;
    maxEdges_ += kMaxEdges;
}

void VtkCellReader::addFace(std::int64_t type, std::span<const std::int64_t> vertices) {
    std::vector<Index> points;
    for (const std::int64_t vertex : vertices) points.push_back(checkedVertex(vertex));
    if (type == kVtkStrip) {
        ModelFaces triangles;
        triangles.addStrip(points);
        for (std::size_t face = 0; face < triangles.count(); ++face) visitor_.face(triangles[face]);
        return;
    }
    // A pixel orders its points by rows; a quadrilateral goes around.
    if (type == kVtkPixel && points.size() == 4) std::swap(points[2], points[3]);
    const bool isKnown = facePoints(type, points.size()) == points.size();
    if (isKnown && type <= kVtkQuadrilateral) return visitor_.face(points);
    visitor_.curvedCell(2, isKnown ? points : std::vector<Index>{});
}

void VtkCellReader::addPrism(std::size_t sides, std::span<const std::int64_t> vertices) {
    if (vertices.size() != 2 * sides)
        fail(concat("is a prism of ", sides, " sides and has ", vertices.size(),
                    " vertices; expected ", 2 * sides));
    // The lower vertices go around anticlockwise, seen from the upper ones, which follow in the
    // same order.
    std::vector<std::vector<std::int64_t>> loops(2);
    for (std::size_t i = 0; i < sides; ++i) {
        const std::size_t next = (i + 1) % sides;
        loops[0].insert(loops[0].begin(), vertices[i]);
        loops[1].push_back(vertices[sides + i]);
        loops.push_back({vertices[i], vertices[next], vertices[sides + next], vertices[sides + i]});
    }
    addPolyhedron(std::vector<std::span<const std::int64_t>>(loops.begin(), loops.end()));
}

void VtkCellReader::addPolyhedron(const std::vector<std::span<const std::int64_t>>& loops) {
    std::vector<std::vector<Index>> checked(loops.size());
    for (std::size_t i = 0; i < loops.size(); ++i)
        for (const std::int64_t vertex : loops[i]) checked[i].push_back(checkedVertex(vertex));
    visitor_.polyhedron(checked);
    ++cellCount_;
    ++cellInFile_;
    for (const auto& loop : loops) maxEdges_ += loop.size();
}

void VtkCellReader::addPolyhedron(std::span<const std::int64_t> faceStream) {
    std::vector<std::span<const std::int64_t>> loops;
    std::size_t at = 0;
    const auto takeCount = [&](const char* what) {
        if (at == faceStream.size()) fail(std::string("has faces that end before ") + what);
        const std::int64_t count = faceStream[at++];
        if (count < 0 || static_cast<std::uint64_t>(count) > faceStream.size() - at)
            fail(concat(what, " is ", count, ", but ", faceStream.size() - at,
                        " numbers are left for it"));
        return static_cast<std::size_t>(count);
    };
    const std::size_t faceCount = takeCount("the number of its faces");
    for (std::size_t face = 0; face < faceCount; ++face) {
        const std::size_t size = takeCount("the number of vertices of a face");
        loops.push_back(faceStream.subspan(at, size));
        at += size;
    }
    if (at != faceStream.size())
        fail(concat("has ", faceStream.size() - at, " numbers after its last face"));
    addPolyhedron(loops);
}

Index VtkCellReader::checkedVertex(std::int64_t vertex) const {
    if (vertex < 0 || vertex >= pieceVertexCount_)
        throw far::TopologyError(far::TopologyCause::VertexOutOfRange, {3, cellCount_},
                                 concat(shownPath(path_), ": cell ", cellInFile_, " names vertex ",
                                        vertex, "; there are ", pieceVertexCount_));
    return firstVertex_ + static_cast<Index>(vertex);
}

void VtkCellReader::fail(const std::string& cause) const {
    throw FileError(path_, concat("cell ", cellInFile_, " ", cause));
}

VtkCells vtkCells(const far::CellComplex& complex) {
    VtkCells cells;
    const std::size_t count = complex.count(3);
    cells.types.reserve(count);
    cells.offsets.reserve(count);
    cells.connectivity.reserve(8 * count);
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        checkCancelledEvery(cell, 12);
        if (const auto standard = far::asStandardCell(complex, CellId(cell))) {
            cells.types.push_back(typeOf(standard->kind));
            cells.connectivity.insert(cells.connectivity.end(), standard->vertices.begin(),
                                      standard->vertices.end());
        } else {
            const auto vertices = complex.relation(3, 0)[cell];
            cells.types.push_back(static_cast<std::uint8_t>(kVtkPolyhedron));
            cells.connectivity.insert(cells.connectivity.end(), vertices.begin(), vertices.end());
            const auto loops = far::outwardLoops(complex, CellId(cell));
            cells.faces.push_back(static_cast<Index>(loops.size()));
            for (const auto& loop : loops) {
                cells.faces.push_back(static_cast<Index>(loop.size()));
                cells.faces.insert(cells.faces.end(), loop.begin(), loop.end());
            }
            cells.faceOffsets.resize(cells.types.size(), -1);
            cells.faceOffsets.back() = static_cast<std::int64_t>(cells.faces.size());
        }
        cells.offsets.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
    }
    if (cells.havePolyhedra()) cells.faceOffsets.resize(count, -1);
    return cells;
}

}  // namespace espalier::io
