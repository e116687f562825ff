// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/embed/basis_functions.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/embed/cell_place.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace espalier::embed {

/// The distance between the vertices of a level, in cells of the base: SplineSpan::spacing.
inline double spacingOf(int level) {
    return std::ldexp(1, -level);
}

/// The spacing that stands for the limit.
inline constexpr double kLimitSpacing = 0;

/// The map of a regular cell: a uniform tricubic B-spline over the 4 × 4 × 4 vertices around the
/// cell. Its limit is one polynomial; level n is the trilinear interpolation of the level-n
/// vertices in the cell. At a regular boundary a layer of vertices is missing. The spline has the
/// points 2P₀ − P₁ in its place (phantoms): P₀ is a vertex of the next layer, and P₁ the vertex
/// behind it.
///
/// Control point i + 4j + 16k is i − 1 cells along u, j − 1 along v and k − 1 along w away from
/// corner 0 of the cell.
///
/// \cite MacCracken & Joy 1996, section 2.2; CSE-96-1, section 5; Joy, bicubic refinement
class ESPALIER_API TricubicPatch {
public:
    /// \param level level of the cell, with all neighbours of the cell
    /// \param frame frame of a regular cell: see isRegularCell()
    TricubicPatch(const far::Level& level, const CellFrame& frame);

    /// The vertex of each control point; kMaxIndex for phantoms.
    using Vertices = std::array<Index, 64>;
    static constexpr std::size_t kCorner = 1 + 4 + 16;  ///< the control point of corner 0

    /// Makes a patch from its vertices().
    explicit TricubicPatch(const Vertices& vertices);

    Vertices vertices() const;

    /// Checks the vertices of a patch.
    /// \throws Error unless each exists, except those of whole layers at the ends of an axis
    static void checkVertices(const Vertices& vertices, Index vertexCount);

    /// Returns the weights of the vertices in a derivative of the limit: at most 64, in ascending
    /// order of the vertices. Weights of the position sum to 1, weights of a derivative to 0. Where
    /// three cells form a closed loop, a vertex occurs more than once.
    /// \param uvw in the axes of the frame, 0 to 1; outside this range the polynomials are extended
    /// \param orders orders of the derivative by u, v and w, 0 to 2 each; all 0 is the position
    std::vector<VertexWeight> weights(const Eigen::Vector3d& uvw,
                                      const std::array<int, 3>& orders) const;

    using ControlPoints = std::array<Eigen::Vector3d, 64>;

    /// Returns the control points in space, including phantoms.
    /// \param positions one for each vertex of the level
    ControlPoints controlPoints(std::span<const Point3> positions) const;

    /// True if three cells form a closed loop, so that a vertex is more than one control point.
    bool hasRepeatedVertex() const;

    /// The weights of one place, axis by axis. On a level, orders are 0 or 1.
    using AxisWeights = std::array<std::array<double, 4>, 3>;
    AxisWeights axisWeights(const Eigen::Vector3d& uvw, double spacing,
                            const std::array<int, 3>& orders = {}) const;

    /// Returns how many control points have a weight other than 0, and so the length of the row.
    static Index rowLength(const AxisWeights& along);

    /// Writes the row of a place: rowLength() vertices, ascending, and their weights.
    void writeRow(const AxisWeights& along, Index* vertices, double* weights) const;

private:
    void sortVertices(const Vertices& vertices);

    std::array<Index, 64> vertices_ = {};       ///< ascending; kMaxIndex for phantoms
    std::array<std::uint8_t, 64> places_ = {};  ///< the control points that they are
    std::array<SplineSpan, 3> spans_ = {};
};

/// Converts B-spline control points to Bernstein form: point i + 4j + 16k belongs to Bᵢ(u) Bⱼ(v)
/// Bₖ(w), of degree 3. The polynomial goes through the level-n vertices, or is the limit. For
/// (u, v, w) in [0, 1]³ it is in the convex hull of these points, and so is the level.
/// \cite Joy, bicubic refinement
ESPALIER_API TricubicPatch::ControlPoints bezierPoints(TricubicPatch::ControlPoints points,
                                                       double spacing = kLimitSpacing);

}  // namespace espalier::embed
