// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/embed/cell_place.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace espalier::limit {

/// For one axis of a cell: whether the layers of control points below and above it exist. A missing
/// layer is a phantom.
struct AxisEnds {
    bool hasLow = true, hasHigh = true;
};

/// The limit of a regular cell: one tricubic polynomial, a uniform B-spline over the 4 × 4 × 4
/// vertices around the cell. At a regular boundary a layer of vertices is missing; the phantom 2P₀
/// − P₁ of the two layers next to it replaces it.
///
/// Control point i + 4j + 16k is i − 1 cells along u, j − 1 along v and k − 1 along w away from
/// corner 0 of the cell.
///
/// \cite MacCracken & Joy 1996, section 2.2; CSE-96-1, section 5; Joy, bicubic refinement
class TricubicPatch {
public:
    /// \param level level of the cell, with all neighbours of the cell
    /// \param frame frame of a regular cell: see isRegularCell()
    TricubicPatch(const far::Level& level, const embed::CellFrame& frame);

    /// Returns the weights of the vertices in a derivative of the limit: at most 64, in ascending
    /// order of the vertices. Weights of the position sum to 1, weights of a derivative to 0. Where
    /// three cells form a closed loop, a vertex occurs more than once.
    /// \param uvw in the axes of the frame, 0 to 1; outside this range the polynomial is extended
    /// \param orders orders of the derivative by u, v and w, 0 to 2 each; all 0 is the position
    std::vector<embed::VertexWeight> weights(const Eigen::Vector3d& uvw,
                                             const std::array<int, 3>& orders) const;

    using ControlPoints = std::array<Eigen::Vector3d, 64>;

    /// Returns the control points in space, including phantoms.
    /// \param positions one for each vertex of the level
    ControlPoints controlPoints(std::span<const Point3> positions) const;

private:
    std::array<Index, 64> vertices_ = {};      ///< kMaxIndex for a phantom
    std::array<std::uint8_t, 64> order_ = {};  ///< control points in order of their vertices
    std::array<AxisEnds, 3> ends_ = {};
};

/// Converts B-spline control points to Bernstein form: point i + 4j + 16k belongs to Bᵢ(u) Bⱼ(v)
/// Bₖ(w), of degree 3. For (u, v, w) in [0, 1]³ the polynomial is in the convex hull of these
/// points.
/// \cite Joy, bicubic refinement
TricubicPatch::ControlPoints bezierPoints(TricubicPatch::ControlPoints points);

}  // namespace espalier::limit
