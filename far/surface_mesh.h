// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/incidence.h>

#include <span>

namespace espalier::far {

/// Returns the corners of a triangle or a quadrilateral of first or second order: the first 3 or 4
/// points.
/// \param points 3 or 6 of a triangle; 4, 8 or 9 of a quadrilateral
inline std::span<const Index> cornersOfFace(std::span<const Index> points) {
    return points.first(points.size() == 3 || points.size() == 6 ? 3 : 4);
}

/// The triangles and quadrilaterals of a mesh of a surface, or of a plane. It has no positions.
class ESPALIER_API SurfaceMesh {
public:
    SurfaceMesh() = default;
    explicit SurfaceMesh(Index pointCount) : pointCount_(pointCount) {}

    /// Adds a face.
    /// \param points the corners in the order around the face: 3 or 4. A face of second order has
    ///        the middles of the edges after them, which begin with the edge from corner 0 to 1: 6
    ///        or 8 points; or 9, with the middle of the quadrilateral
    /// \throws TopologyError if the number of points is another one, or if a point does not exist
    void addFace(std::span<const Index> points);

    Index pointCount() const { return pointCount_; }
    Index faceCount() const { return static_cast<Index>(faces_.count()); }

    /// Returns all points of a face.
    std::span<const Index> points(Index face) const { return faces_[face]; }

    /// Returns the corners of a face: 3 or 4 points.
    std::span<const Index> corners(Index face) const { return cornersOfFace(points(face)); }

    /// Returns true if a face has points between its corners, so that its edges may be curved.
    bool isSecondOrder(Index face) const { return points(face).size() > 4; }

private:
    Index pointCount_ = 0;
    Rows<Index> faces_;
};

}  // namespace espalier::far
