// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/surface_mesh.h>

#include <cstddef>
#include <optional>
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
/// At rest, the normal is perpendicular to the corners of the face. In a pose, there are two cases:
///
/// - The mesh is planar at rest, within a millionth of its size, and in the pose, within a
/// hundredth,
///   and the two planes differ by less than 30 degrees, as in a mesh of two dimensions. The normal
///   is then the normal of the plane of the pose, with the sign that the face has at rest.
/// - Otherwise the mesh is a surface in space, which may turn in any direction. The normal is the
///   one at rest, turned by the rotation that moves the face and its neighbours best (the nearest
///   one to the covariance of their corners). So a face counts as turned over only against its
///   neighbours; a face that shares no point with others never does.
class SurfacePieces {
public:
    /// \param rest positions of the points at rest
    SurfacePieces(const far::SurfaceMesh& mesh, std::span<const Point3> rest);

    const far::SurfaceMesh& mesh() const { return mesh_; }

    /// Returns positions of the points, and after them the normal of each face.
    std::vector<Point3> withNormals(std::span<const Point3> positions) const;

    /// Returns true if the normals in a pose come from neighbours: the second case.
    bool usesNeighbours(std::span<const Point3> positions) const;

    /// The faces that share no point with other faces.
    Index isolatedFaces() const { return isolatedFaces_; }

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
    /// Returns the normal of the plane that the faces lie in; nothing if they lie in none.
    /// \param tolerance largest distance from the plane, relative to the size
    std::optional<Point3> planeNormal(std::span<const Point3> positions, double tolerance) const;

    /// Returns the normal of the plane of a pose, near the normal at rest; nothing in the second
    /// case.
    std::optional<Point3> planeOf(std::span<const Point3> positions) const;

    far::SurfaceMesh mesh_;
    std::vector<Point3> rest_;
    std::vector<Point3> normals_;  ///< at rest, as long as the face is wide
    std::optional<Point3> plane_;  ///< the normal of a mesh that is planar at rest
    std::vector<Index> points_;    ///< the points of the faces
    Index isolatedFaces_ = 0;
};

}  // namespace espalier::solve
