// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/surface_mesh.h>
#include <espalier/far/volume_mesh.h>
#include <espalier/limit/limit_parts.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mesh_pieces.h"
#include "piece.h"
#include "surface_pieces.h"

namespace espalier::solve {

/// Splits a cell of a refined lattice into pieces, in the same way as embedding: a type-3 cell is
/// one trilinear map, a type-n cell 4n tetrahedra around its cell point. In a lattice with the
/// usual orientation that is not folded, all determinants are positive.
///
/// \cite MacCracken & Joy 1996, section 6
class CellPieces {
public:
    /// \param complex a lattice of quadrilaterals; must outlive this
    CellPieces(const far::CellComplex& complex, Index cell);

    /// Calls visit(piece…) for each piece, with the piece once for each of `positions`.
    /// \param positions one for each vertex of the complex
    /// \cost O(vertices of the cell) for each piece
    template <class Visit, class... Positions>
    void forEach(Visit visit, const Positions&... positions) const {
        if (corners_) {
            visit(hexahedron(positions)...);
            return;
        }
        for (Index i = 0; i < tetrahedronCount(); ++i) visit(tetrahedron(i, positions)...);
    }

    /// Returns the only piece of a type-3 cell.
    Piece<1> hexahedron(std::span<const Point3> positions) const;

private:
    Index tetrahedronCount() const;
    Piece<0> tetrahedron(Index number, std::span<const Point3> positions) const;
    double uncertainty(std::span<const Point3> positions) const;

    const far::CellComplex& complex_;
    CellId cell_;
    std::optional<std::array<Index, 8>> corners_;  ///< nothing unless the cell is a hexahedron
};
/// The volume that is checked: the cells of a level, the limit of the base cells, or the cells of a
/// volume mesh; or a surface. A cell consists of parts, and a part of one or more pieces.
class CheckedVolume {
public:
    /// The volume of a level. Each cell is its own single part.
    /// \throws Error unless the level is a lattice of quadrilaterals
    explicit CheckedVolume(const far::CellComplex& level);
    explicit CheckedVolume(const limit::LimitParts& limit);
    /// The volume of a mesh. Each cell is its own single part.
    /// \param rest positions of its points, finite
    CheckedVolume(const far::VolumeMesh& mesh, std::span<const Point3> rest);
    /// The faces of a surface, which count as cells here. Each face is its own single part.
    /// \param rest positions of its points, finite
    CheckedVolume(const far::SurfaceMesh& mesh, std::span<const Point3> rest);

    Index cellCount() const;
    Index vertexCount() const;
    Index partCount() const;

    /// Number of parts that one thread takes at a time. A patch takes a hundred times as long as a
    /// cell.
    Offset grain() const { return limit_ ? 8 : 1024; }

    Index cellOf(Index part) const;

    /// Returns the group of each cell, as numbers from 0. Most cells of a group are taken to be
    /// oriented as they should be. The groups of a lattice are its connected
    /// components, joined by faces; those of a mesh are the kinds of cells, since programs disagree
    /// on the order of the points of a wedge. The faces of a surface have normals of their own.
    std::vector<Index> orientationGroups() const;

    /// Of a surface: whether the normals in a pose come from neighbours, and the number of faces
    /// that have none (SurfacePieces).
    bool usesNeighbours(std::span<const Point3> positions) const {
        return surface_ && surface_->usesNeighbours(positions);
    }
    Index isolatedFaces() const { return surface_ ? surface_->isolatedFaces() : 0; }

    /// \param positions positions of the vertices. For a level or a mesh, the result has them as
    ///        `limits` and no `levels`; the centres of a mesh or the normals of a surface follow
    limit::LimitPositions place(std::span<const Point3> positions) const;

    /// Calls visit(piece…) for each piece of a part. The piece is passed once for each of
    /// `positions`: all are of one degree.
    template <class Visit, class... Positions>
    void forEachPiece(Index part, Visit visit, const Positions&... positions) const {
        const std::size_t number = part;
        if (mesh_) {
            mesh_->forEach(part, visit, std::span<const Point3>(positions.limits)...);
            return;
        }
        if (surface_) {
            surface_->forEach(part, visit, std::span<const Point3>(positions.limits)...);
            return;
        }
        if (limit_ && number < limit_->patchCount()) {
            visit(pieceOf(limit_->bezierPatch(number, positions))...);
            return;
        }
        const Index cell = limit_ ? limit_->parts()[number].cell : part;
        CellPieces(limit_ ? limit_->lastLevel() : cells_, cell)
            .forEach(visit, std::span<const Point3>(positions.limits)...);
    }

private:
    far::CellComplex cells_;  ///< the cells of a level, or the base cells
    std::optional<limit::LimitParts> limit_;
    std::shared_ptr<const MeshPieces> mesh_;
    std::shared_ptr<const SurfacePieces> surface_;
};

}  // namespace espalier::solve
