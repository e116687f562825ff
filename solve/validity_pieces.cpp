// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/embed/cell_place.h>

#include <algorithm>
#include <string>
#include <utility>

#include "validity_pieces.h"

namespace espalier::solve {

using Positions = std::span<const Point3>;

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

CheckedVolume::CheckedVolume(const far::SurfaceMesh& mesh, Positions rest)
    : surface_(std::make_shared<SurfacePieces>(mesh, rest)) {}

Index CheckedVolume::cellCount() const {
    return mesh_      ? mesh_->mesh().cellCount()
           : surface_ ? surface_->mesh().faceCount()
                      : cells_.count(3);
}

Index CheckedVolume::vertexCount() const {
    return mesh_      ? mesh_->mesh().pointCount()
           : surface_ ? surface_->mesh().pointCount()
                      : cells_.count(0);
}

Index CheckedVolume::partCount() const {
    return limit_ ? static_cast<Index>(limit_->parts().size()) : cellCount();
}

Index CheckedVolume::cellOf(Index part) const {
    return limit_ ? limit_->parts()[part].baseCell : part;
}

std::vector<Index> CheckedVolume::orientationGroups() const {
    if (surface_) return std::vector<Index>(cellCount(), 0);
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
    if (surface_) return {{}, surface_->withNormals(positions)};
    return {{}, {positions.begin(), positions.end()}};
}

}  // namespace espalier::solve
