// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/incidence.h>

#include <span>

namespace espalier::far {

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
    Index faceCount() const { return static_cast<Index>(faces_.offsets.size() - 1); }

    /// Returns all points of a face.
    std::span<const Index> points(Index face) const {
        return {faces_.values.data() + faces_.offsets[face],
                faces_.values.data() + faces_.offsets[face + 1]};
    }

    /// Returns the corners of a face: 3 or 4 points.
    std::span<const Index> corners(Index face) const {
        const auto all = points(face);
        return all.first(all.size() == 3 || all.size() == 6 ? 3 : 4);
    }

    /// Returns true if a face has points between its corners, so that its edges may be curved.
    bool isSecondOrder(Index face) const { return points(face).size() > 4; }

private:
    Index pointCount_ = 0;
    Rows<Index> faces_;
};

}  // namespace espalier::far
