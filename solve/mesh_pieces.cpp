// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "mesh_centres.h"
#include "mesh_pieces.h"

namespace espalier::solve {

using Positions = std::span<const Point3>;

namespace {

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

}  // namespace espalier::solve
