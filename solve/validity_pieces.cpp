// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/embed/cell_place.h>
#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "mesh_centres.h"
#include "validity_pieces.h"

namespace espalier::solve {
namespace {

/// Returns the corner of a hexahedron, in VTK's order, at the end 0 or 1 of u, v and w.
std::size_t cornerAt(const std::array<std::size_t, 3>& place) {
    return 4 * place[2] + (place[1] == 1 ? 3 - place[0] : place[0]);
}

/// Volume of a box whose edge lengths change linearly from `first` to `last`, as Bernstein
/// coefficients.
std::array<double, 4> volumes(const std::array<double, 3>& first,
                              const std::array<double, 3>& last) {
    const auto mean = [](const std::array<double, 3>& one, const std::array<double, 3>& others) {
        return (one[0] * others[1] * others[2] + others[0] * one[1] * others[2] +
                others[0] * others[1] * one[2]) /
               3;
    };
    return {first[0] * first[1] * first[2], mean(last, first), mean(first, last),
            last[0] * last[1] * last[2]};
}

/// Returns the rounding error that coefficients may have while a piece changes from `first` to
/// `last`.
std::array<double, 4> floorsOf(const PieceSize& first, const PieceSize& last, double rounding) {
    const auto exact = volumes(first.lengths, last.lengths);
    const auto longer = volumes(first.longest(), last.longest());
    std::array<double, 4> floor;
    for (std::size_t i = 0; i < 4; ++i) floor[i] = floorOf(exact[i], longer[i], rounding);
    return floor;
}

using Positions = std::span<const Point3>;

double largestAmong(std::span<const Index> vertices, Positions positions) {
    double largest = 0;
    for (const Index vertex : vertices)
        largest = std::max(largest, largestCoordinate(positions[vertex]));
    return largest;
}

/// Returns the rounding error of the points of a mesh. They are given exactly, but the points on
/// the way to a pose are rounded: a product, and a sum.
double meshUncertainty(std::span<const Index> points, Positions positions) {
    return 2 * kEpsilon * largestAmong(points, positions);
}

/// Returns a map from its Bézier points: point (i, j, k) is at index i + n (j + n k).
template <std::size_t Degree>
Piece<Degree> pieceOf(
    const std::array<Point3, (Degree + 1) * (Degree + 1) * (Degree + 1)>& points) {
    Piece<Degree> piece;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t stride = kAxisStride<Degree>[axis];
        std::size_t count = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (i / stride % (Degree + 1) == Degree) continue;
            const Point3 derivative =
                scaled(difference(points[i + stride], points[i]), static_cast<double>(Degree));
            piece.derivatives[axis][count++] = derivative;
            piece.size.lengths[axis] = std::max(piece.size.lengths[axis], sizeOf(derivative));
        }
    }
    return piece;
}

/// Returns the map of a hexahedron, without its uncertainty.
/// \param corners in VTK's order
Piece<1> trilinear(std::span<const Index> corners, Positions positions) {
    std::array<Point3, 8> points;
    for (std::size_t i = 0; i < 8; ++i)
        points[i] = positions[corners[cornerAt({i % 2, i / 2 % 2, i / 4})]];
    return pieceOf<1>(points);
}

/// Returns the tetrahedron of four points of a mesh.
Piece<0> tetrahedronOf(Positions positions, const std::array<Index, 4>& points) {
    Piece<0> piece;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Point3 edge = difference(positions[points[axis + 1]], positions[points[0]]);
        piece.derivatives[axis][0] = edge;
        piece.size.lengths[axis] = sizeOf(edge);
    }
    piece.size.uncertainty = meshUncertainty(points, positions);
    return piece;
}

}  // namespace

Piece<3> pieceOf(const limit::BezierPatch& patch) {
    Piece<3> piece = pieceOf<3>(patch.points);
    piece.size.uncertainty = 3 * 48 * kEpsilon * patch.largestCoordinate;
    return piece;
}

CellPieces::CellPieces(const far::CellComplex& complex, Index cell)
    : complex_(complex), cell_(cell), corners_(far::hexahedronVertices(complex, cell_)) {}

Index CellPieces::tetrahedronCount() const {
    return embed::tetrahedronCount(complex_, cell_);
}

double CellPieces::uncertainty(Positions positions) const {
    return 16 * kEpsilon * largestAmong(complex_.relation(3, 0)[cell_.value], positions);
}

Piece<1> CellPieces::hexahedron(Positions positions) const {
    Piece<1> piece = trilinear(*corners_, positions);
    piece.size.uncertainty = uncertainty(positions);
    return piece;
}

Piece<0> CellPieces::tetrahedron(Index number, Positions positions) const {
    // Measure from one of the vertices, so that a cell far from the origin loses no digits.
    const auto vertices = complex_.relation(3, 0)[cell_.value];
    const Point3& origin = positions[vertices.front()];
    Point3 apex{};
    double size = 0;
    for (const Index vertex : vertices) {
        const Point3 offset = difference(positions[vertex], origin);
        size = std::max(size, length(offset));
        for (std::size_t c = 0; c < 3; ++c)
            apex[c] += offset[c] / static_cast<double>(vertices.size());
    }
    auto base = embed::tetrahedronBase(complex_, cell_, number);
    const std::size_t face = number / 2;
    if (complex_.boundary(3).signs(cell_.value)[face] < 0) std::swap(base[1], base[2]);
    Piece<0> piece;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        piece.derivatives[axis][0] = difference(difference(positions[base[axis]], origin), apex);
        piece.size.lengths[axis] = size;
    }
    piece.size.uncertainty = uncertainty(positions);
    return piece;
}

MeshPieces::MeshPieces(const far::VolumeMesh& mesh, Positions rest) : mesh_(mesh) {
    std::vector<Index> polyhedra;
    for (Index cell = 0; cell < mesh.cellCount(); ++cell)
        if (!mesh.kind(cell)) polyhedra.push_back(cell);
    if (polyhedra.empty()) return;

    std::size_t rowCount = polyhedra.size(), valueCount = 0;
    for (const Index cell : polyhedra) {
        valueCount += mesh.faces(cell).size();
        for (const Index face : mesh.faces(cell))
            if (mesh.owner(face) == cell || mesh.kind(mesh.owner(face))) {
                ++rowCount;
                valueCount += mesh.face(face).size();
            }
    }
    centres_.offsets.reserve(rowCount + 1);
    centres_.values.reserve(valueCount);

    Index next = mesh.pointCount();
    std::vector<Point3> faceCentres(mesh.faceCount()), faceAreas(mesh.faceCount());
    centreOfFace_.assign(mesh.faceCount(), 0);
    std::vector<double> weights;
    for (const Index cell : polyhedra)
        for (const Index face : mesh.faces(cell)) {
            if (centreOfFace_[face] != 0) continue;
            centreOfFace_[face] = next++;
            const auto loop = mesh.face(face);
            const FaceCentre centre = faceCentre(loop, rest, &weights);
            faceCentres[face] = centre.centre;
            faceAreas[face] = centre.area;
            for (std::size_t i = 0; i < loop.size(); ++i)
                centres_.values.push_back({loop[i], weights[i]});
            centres_.offsets.push_back(std::ssize(centres_.values));
        }
    centreOfCell_.assign(mesh.cellCount(), 0);
    for (const Index cell : polyhedra) {
        centreOfCell_[cell] = next++;
        cellCentre(mesh, cell, faceCentres, faceAreas, &weights);
        const auto faces = mesh.faces(cell);
        for (std::size_t i = 0; i < faces.size(); ++i)
            centres_.values.push_back({centreOfFace_[faces[i]], weights[i]});
        centres_.offsets.push_back(std::ssize(centres_.values));
    }
}

std::vector<Point3> MeshPieces::withCentres(Positions positions) const {
    std::vector<Point3> result;
    result.reserve(positions.size() + centres_.offsets.size() - 1);
    result.assign(positions.begin(), positions.end());
    for (std::size_t row = 0; row + 1 < centres_.offsets.size(); ++row) {
        const auto begin = centres_.offsets[row], end = centres_.offsets[row + 1];
        if (begin == end) {  // A cell without faces.
            result.push_back({});
            continue;
        }
        // Measured from the first of them, so that a cell far from the origin loses no digits.
        const Point3 origin = result[centres_.values[begin].position];
        Point3 offset{};
        for (auto i = begin; i < end; ++i)
            offset = sum(offset, scaled(difference(result[centres_.values[i].position], origin),
                                        centres_.values[i].weight));
        result.push_back(sum(origin, offset));
    }
    return result;
}

Piece<0> MeshPieces::tetrahedron(Index cell, Positions positions) const {
    const auto corners = mesh_.corners(cell);
    return tetrahedronOf(positions, {corners[0], corners[1], corners[2], corners[3]});
}

Piece<0> MeshPieces::pyramid(Index cell, std::size_t corner, Positions positions) const {
    const auto corners = mesh_.corners(cell);
    return tetrahedronOf(positions, {corners[corner], corners[(corner + 1) % 4],
                                     corners[(corner + 3) % 4], corners[4]});
}

Piece<1> MeshPieces::wedge(Index cell, std::size_t edge, Positions positions) const {
    // VTK's first triangle is clockwise seen from the other one.
    constexpr std::array<std::size_t, 3> kOrder = {0, 2, 1};
    const auto corners = mesh_.corners(cell);
    const auto at = [&](std::size_t corner, std::size_t end) -> const Point3& {
        return positions[corners[kOrder[corner] + 3 * end]];
    };
    Piece<1> piece;
    // Coefficient i of the derivatives by u and v is at the end i / 2 of w.
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t axis = 0; axis < 2; ++axis)
            piece.derivatives[axis][i] = difference(at(axis + 1, i / 2), at(0, i / 2));
        piece.derivatives[2][i] = difference(at(edge, 1), at(edge, 0));
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const Point3& derivative : piece.derivatives[axis])
            piece.size.lengths[axis] = std::max(piece.size.lengths[axis], sizeOf(derivative));
    piece.size.uncertainty = meshUncertainty(corners, positions);
    return piece;
}

Piece<1> MeshPieces::hexahedron(Index cell, Positions positions) const {
    const auto corners = mesh_.corners(cell);
    Piece<1> piece = trilinear(corners, positions);
    piece.size.uncertainty = meshUncertainty(corners, positions);
    return piece;
}

std::array<double, 4> determinantFloor(const PieceSize& first, const PieceSize& last) {
    return floorsOf(first, last, 2 * kRounding);
}

CheckedVolume::CheckedVolume(const far::CellComplex& level) : cells_(level) {
    if (level.dimension() != 3)
        throw Error(concat("cells are checked in a lattice only, not in a complex of dimension ",
                           level.dimension()));
    for (Index face = 0; face < level.count(2); ++face)
        if (level.relation(2, 0)[face].size() != 4)
            throw Error(
                concat("face ", face,
                       " is not a quadrilateral: checking cells needs a lattice refined at least "
                       "once"));
}

CheckedVolume::CheckedVolume(const limit::LimitParts& limit)
    : cells_(limit.base()), limit_(limit) {}

CheckedVolume::CheckedVolume(const far::VolumeMesh& mesh, Positions rest)
    : mesh_(std::make_shared<MeshPieces>(mesh, rest)) {}

Index CheckedVolume::partCount() const {
    return limit_ ? static_cast<Index>(limit_->parts().size()) : cellCount();
}

Index CheckedVolume::cellOf(Index part) const {
    return limit_ ? limit_->parts()[part].baseCell : part;
}

std::vector<Index> CheckedVolume::orientationGroups() const {
    std::vector<Index> groups(cellCount(), -1);
    if (mesh_) {
        for (Index cell = 0; cell < cellCount(); ++cell) {
            const auto kind = mesh_->mesh().kind(cell);
            groups[cell] = kind ? 1 + static_cast<Index>(*kind) : 0;
        }
        return groups;
    }
    const far::Incidence& faces = cells_.relation(3, 2);
    const far::Incidence& cells = cells_.relation(2, 3);
    std::vector<Index> joined;
    Index count = 0;
    for (Index start = 0; start < cellCount(); ++start) {
        if (groups[start] >= 0) continue;
        joined = {start};
        groups[start] = count;
        for (std::size_t i = 0; i < joined.size(); ++i)
            for (const Index face : faces[joined[i]])
                for (const Index cell : cells[face]) {
                    if (groups[cell] >= 0) continue;
                    groups[cell] = count;
                    joined.push_back(cell);
                }
        ++count;
    }
    return groups;
}

limit::LimitPositions CheckedVolume::place(Positions positions) const {
    if (limit_) return limit_->place(positions);
    if (mesh_) return {{}, mesh_->withCentres(positions)};
    return {{}, {positions.begin(), positions.end()}};
}

}  // namespace espalier::solve
