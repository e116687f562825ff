// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/base/vector3.h>
#include <espalier/far/volume_mesh.h>

#include <algorithm>
#include <span>
#include <tuple>
#include <vector>

#include "piece.h"
#include "second_order_piece.h"

namespace espalier::solve {

/// Splits the cells of a volume mesh into pieces whose determinants are positive exactly where the
/// map of the cell does not fold. In a right-handed mesh that is not folded, all are positive.
///
/// - A tetrahedron is one piece, and a hexahedron is one trilinear map.
/// - A pyramid is the trilinear map whose top shrinks to the apex, at height w = 1. Its determinant
///   is (1 − w)² times a bilinear function of the base, which is smallest at a corner of the base:
///   four tetrahedra.
/// - A wedge is linear over the triangle and linear along the other axis. Its determinant is linear
///   over the triangle, and so smallest on one of the three edges along the axis: three pieces,
///   whose determinants are quadratic along the axis. (They are no maps of their own: only the
///   derivatives are given.)
/// - A polyhedron is split into tetrahedra as OpenFOAM does (FACE_CENTRE_TRIS): they join
///   the centre of the cell, the centre of a face, and an edge of the face. The centres are
///   OpenFOAM's at rest, written as weighted means of the points of the cell. The weights stay in
///   all poses.
/// - A cell of second order is one piece (secondOrderCell()).
class MeshPieces {
public:
    /// \param rest positions of the points at rest, which determine the weights of the centres
    MeshPieces(const far::VolumeMesh& mesh, std::span<const Point3> rest);

    const far::VolumeMesh& mesh() const { return mesh_; }

    /// Returns positions of the points, and after them of the centres.
    std::vector<Point3> withCentres(std::span<const Point3> positions) const;

    /// Calls visit(piece…) for each piece of a cell, with the piece once for each of `positions`,
    /// which withCentres() returned.
    template <class Visit, class... Positions>
    void forEach(Index cell, Visit visit, const Positions&... positions) const {
        const auto kind = mesh_.kind(cell);
        if (mesh_.isSecondOrder(cell)) {
            visit(secondOrderCell(mesh_.points(cell), positions)...);
        } else if (kind == far::StandardCell::Hexahedron) {
            visit(hexahedron(cell, positions)...);
        } else if (kind == far::StandardCell::Wedge) {
            for (std::size_t edge = 0; edge < 3; ++edge) visit(wedge(cell, edge, positions)...);
        } else if (kind == far::StandardCell::Pyramid) {
            for (std::size_t corner = 0; corner < 4; ++corner)
                visit(pyramid(cell, corner, positions)...);
        } else if (kind == far::StandardCell::Tetrahedron) {
            visit(tetrahedron(cell, positions)...);
        } else {
            for (const Index face : mesh_.faces(cell)) {
                std::tuple fans(Fan(*this, cell, face, positions)...);
                for (std::size_t edge = 0; edge < mesh_.face(face).size(); ++edge)
                    std::apply([&](auto&... fan) { visit(fan.next()...); }, fans);
            }
        }
    }

private:
    using Positions = std::span<const Point3>;
    Piece<0> tetrahedron(Index cell, Positions positions) const;
    Piece<0> pyramid(Index cell, std::size_t corner, Positions positions) const;
    Piece<1> wedge(Index cell, std::size_t edge, Positions positions) const;
    Piece<1> hexahedron(Index cell, Positions positions) const;

    /// The tetrahedra of a face of a polyhedron, which join the centres of the cell and the face to
    /// the edges of the face. Neighbouring tetrahedra share edges, so each edge is measured once.
    /// Inline, because a million cells have tens of millions of tetrahedra.
    class Fan {
    public:
        Fan(const MeshPieces& pieces, Index cell, Index face, Positions positions)
            : positions_(positions),
              loop_(pieces.mesh_.face(face)),
              isOwner_(pieces.mesh_.owner(face) == cell),
              // The centres are sums over the points of a face and the faces of a cell.
              rounding_((static_cast<double>(loop_.size() + pieces.mesh_.faces(cell).size()) + 8) *
                        kEpsilon),
              apex_(positions[pieces.centreOfCell_[cell]]),
              toFace_(spokeTo(pieces.centreOfFace_[face])),
              toFirst_(spokeTo(loop_[0])),
              toPoint_(toFirst_),
              largest_(std::max(largestCoordinate(apex_), toFace_.largest)) {}

        /// Returns the tetrahedron of the next edge of the face; there must be one.
        Piece<0> next() {
            const Spoke before = toPoint_;
            toPoint_ = nextPoint_ == loop_.size() ? toFirst_ : spokeTo(loop_[nextPoint_]);
            ++nextPoint_;
            const Spoke& from = isOwner_ ? before : toPoint_;
            const Spoke& to = isOwner_ ? toPoint_ : before;
            Piece<0> piece;
            piece.derivatives[0][0] = toFace_.edge;
            piece.derivatives[1][0] = from.edge;
            piece.derivatives[2][0] = to.edge;
            piece.size.lengths = {toFace_.length, from.length, to.length};
            piece.size.uncertainty = 2 * kEpsilon * std::max({largest_, from.largest, to.largest}) +
                                     rounding_ * std::ranges::max(piece.size.lengths);
            return piece;
        }

    private:
        /// An edge of a tetrahedron that starts in the cell's centre.
        struct Spoke {
            Point3 edge;
            double length;
            double largest;  ///< coordinate of the edge's end
        };
        Spoke spokeTo(Index point) const {
            const Point3& end = positions_[point];
            const Point3 edge = difference(end, apex_);
            return {edge, sizeOf(edge), largestCoordinate(end)};
        }

        Positions positions_;
        std::span<const Index> loop_;
        bool isOwner_;
        double rounding_;  ///< the rounding of the centres, relative to the longest edge
        Point3 apex_;
        Spoke toFace_, toFirst_, toPoint_;
        double largest_;  ///< coordinate of the two centres
        std::size_t nextPoint_ = 1;
    };

    /// A centre is the sum of weights times positions.
    struct Weight {
        Index position;
        double weight;
    };

    far::VolumeMesh mesh_;
    far::Rows<Weight> centres_;        ///< the centres of faces of polyhedra, then of polyhedra
    std::vector<Index> centreOfFace_;  ///< number in withCentres(), for faces of polyhedra
    std::vector<Index> centreOfCell_;  ///< the same for polyhedra; both are empty without them
};

}  // namespace espalier::solve
