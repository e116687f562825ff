// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/surface_mesh.h>

#include <cstddef>
#include <span>
#include <vector>

#include "piece.h"
#include "second_order_piece.h"

namespace espalier::solve {

/// Splits the faces of a surface mesh into pieces whose determinants are positive exactly where the
/// face is not turned over. The third derivative of each piece is the normal of the face, which is
/// constant over the face; so the determinant is the area along this normal.
///
/// - A triangle is one piece.
/// - The area of a quadrilateral along a normal is smallest at a corner: four triangles.
/// - A face of second order is one piece (secondOrderFace()).
///
/// At rest, the normal is perpendicular to the corners of the face. In a pose, it is
///
/// - the same, if the mesh lies in a plane at rest and in the same plane in the pose (within a
///   millionth of its size, which files of single precision keep);
/// - otherwise the normal at rest, turned by the rotation that moves the face and its neighbours
///   best (the nearest one to the covariance of their corners). A surface in space may turn in any
///   direction; only a face that turns against its neighbours is turned over.
class SurfacePieces {
public:
    /// \param rest positions of the points at rest
    SurfacePieces(const far::SurfaceMesh& mesh, std::span<const Point3> rest);

    const far::SurfaceMesh& mesh() const { return mesh_; }

    /// Returns positions of the points, and after them the normal of each face.
    std::vector<Point3> withNormals(std::span<const Point3> positions) const;

    /// Calls visit(piece…) for each piece of a face, with the piece once for each of `positions`,
    /// which withNormals() returned.
    template <class Visit, class... Positions>
    void forEach(Index face, Visit visit, const Positions&... positions) const {
        const auto points = mesh_.points(face);
        if (mesh_.isSecondOrder(face)) {
            visit(secondOrderFace(points, positions, positions[mesh_.pointCount() + face])...);
            return;
        }
        for (std::size_t corner = 0; corner < (points.size() == 3 ? 1 : 4); ++corner)
            visit(triangle(face, corner, positions)...);
    }

private:
    Piece<0> triangle(Index face, std::size_t corner, std::span<const Point3> positions) const;
    bool liesInPlane(std::span<const Point3> positions) const;

    far::SurfaceMesh mesh_;
    std::vector<Point3> rest_;
    std::vector<Point3> normals_;  ///< at rest, as long as the face is wide
    bool isPlanar_ = false;
    Point3 origin_{}, plane_{};  ///< a point of the plane and its unit normal
    double tolerance_ = 0;       ///< distance from the plane
};

}  // namespace espalier::solve
