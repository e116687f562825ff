// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/embed/cell_place.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Core>
#include <array>
#include <span>

namespace espalier::limit {

/// A layer of control points before or behind a cell: there, or a phantom.
struct AxisEnds {
    bool hasLow = true, hasHigh = true;
};

/// The limit in a regular cell: one tricubic polynomial, a uniform B-spline over the 4 × 4 × 4
/// vertices around the cell. At a regular boundary the layer that is missing is the phantom
/// 2P₀ − P₁ of the two within.
///
/// Control point i + 4j + 16k is the one at i − 1 cells along u, j − 1 along v and k − 1 along w
/// from corner 0 of the cell.
///
/// \cite MacCracken & Joy 1996, section 2.2; CSE-96-1, section 5; Joy, bicubic refinement
class TricubicPatch {
public:
    /// \param level that the frame's cell is of, with all that is around the cell
    /// \param frame of a regular cell: see isRegularCell()
    TricubicPatch(const far::Level& level, const embed::CellFrame& frame);

    /// The weights of the vertices in a derivative of the limit: no more than 64. Those of the
    /// position sum to 1, those of a derivative to 0. In a loop of three cells a vertex comes more
    /// than once.
    /// \param uvw in the axes of the frame, 0 to 1; beyond, the polynomial goes on
    /// \param orders of the derivative by u, v and w, 0 to 2 each; all 0 is the position
    std::vector<embed::VertexWeight> weights(const Eigen::Vector3d& uvw,
                                             const std::array<int, 3>& orders) const;

    using ControlPoints = std::array<Eigen::Vector3d, 64>;

    /// The control points in space, phantoms too.
    /// \param positions one a vertex of the level
    ControlPoints controlPoints(std::span<const Point3> positions) const;

private:
    std::array<Index, 64> vertices_ = {};  ///< kMaxIndex where there is a phantom
    std::array<AxisEnds, 3> ends_ = {};
};

/// The same polynomial in Bernstein form: point i + 4j + 16k belongs to Bᵢ(u) Bⱼ(v) Bₖ(w), of
/// degree 3. Over (u, v, w) in [0, 1]³ it lies in the hull of these points.
/// \cite Joy, bicubic refinement
TricubicPatch::ControlPoints bezierPoints(TricubicPatch::ControlPoints points);

}  // namespace espalier::limit
