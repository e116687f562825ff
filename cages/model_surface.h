// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/cages/cage.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace espalier::cages {

using Triangle = std::array<Index, 3>;

/// The faces of a model as triangles, and the pieces of its surface that bound a solid.
///
/// Points at one place are one point, polygons become triangles around their least point, and
/// triangles with the same three corners are one triangle. The result has the same bits for the
/// same model with its faces and points in another order, with duplicates that are wound the same
/// way, with faces that start at another corner, or with all faces turned around.
///
/// Triangles are in one *piece* if a path over edges of exactly two triangles joins them. If a
/// piece is orientable, and its boundary edges, joined to the centroid of each connected group of
/// them, have little area (kMostOpen of the area of the piece), these *caps* close the piece: every
/// point has an integer winding number. All other pieces are *open*.
class ModelSurface {
public:
    static constexpr double kMostOpen = 1.0 / 6;

    /// \throws Error for corners out of range, ends that do not ascend, no faces, and points that
    ///         are not finite or beyond ±1e90
    explicit ModelSurface(const SurfaceModel& model);

    /// The distinct points, ascending; then the centroids of caps.
    const std::vector<Point3>& points() const { return points_; }
    std::size_t modelPointCount() const { return modelPointCount_; }

    /// The distinct triangles of the model, ascending, with ascending corners. The last two corners
    /// are equal where a face is a line, all three where it is a point, and for a point that is in
    /// no face.
    const std::vector<Triangle>& triangles() const { return triangles_; }

    struct ClosedPiece {
        std::vector<Triangle> triangles;  ///< anticlockwise seen from outside; caps come last
        std::size_t capBegin = 0;         ///< the first cap
        double volume = 0;                ///< 0 or more
        /// 1 if most of the area of the piece is wound as most of the model; −1 if it is wound the
        /// other way, as the faces of a cavity are; 0 if half of it is.
        int winding = 0;
    };
    const std::vector<ClosedPiece>& closedPieces() const { return closedPieces_; }

    /// The triangles of open pieces; and the lines and points that are in no other triangle.
    const std::vector<Triangle>& openTriangles() const { return openTriangles_; }

    /// The sums over all triangles of the model.
    struct Sizes {
        double area = 0, perimeter = 0;
    };
    Sizes sizes() const;

private:
    void join(const SurfaceModel& model);
    void split();
    bool addClosed(std::span<const Triangle> piece, std::span<const int> windings);

    std::vector<Point3> points_;
    std::size_t modelPointCount_ = 0;
    std::vector<Triangle> triangles_;
    /// Per triangle: 1 if the model winds it as its ascending corners, −1 if the other way, 0 if
    /// both ways.
    std::vector<int> windings_;
    std::vector<ClosedPiece> closedPieces_;
    std::vector<Triangle> openTriangles_;
};

}  // namespace espalier::cages
