// SPDX-License-Identifier: Apache-2.0
#include "tricubic_patch.h"

#include <espalier/embed/basis_functions.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

namespace espalier::limit {
namespace {

/// Adds the weight of a phantom to the two layers that define it.
std::array<double, 4> folded(std::array<double, 4> weights, const AxisEnds& ends) {
    if (!ends.hasLow) {
        weights[1] += 2 * weights[0];
        weights[2] -= weights[0];
        weights[0] = 0;
    }
    if (!ends.hasHigh) {
        weights[2] += 2 * weights[3];
        weights[1] -= weights[3];
        weights[3] = 0;
    }
    return weights;
}

}  // namespace

TricubicPatch::TricubicPatch(const far::Level& level, const embed::CellFrame& frame) {
    vertices_.fill(kMaxIndex);
    // Returns the number of the control point at `corner` of the cell that is `at` cells away along
    // each axis.
    const auto place = [](const std::array<int, 3>& at, std::size_t corner) {
        std::size_t result = 0;
        for (std::size_t axis = 3; axis-- > 0;)
            result =
                4 * result + static_cast<std::size_t>(at[axis] + 1) + embed::bitOf(corner, axis);
        return result;
    };
    const auto add = [&](const embed::CellFrame& cell, const std::array<int, 3>& at) {
        for (std::size_t corner = 0; corner < 8; ++corner)
            vertices_[place(at, corner)] = cell.corners[corner];
    };
    // Visit the three cells along w, from each of these the cells along v, and from each of these
    // the cells along u.
    const auto visit = [&](const auto& self, const embed::CellFrame& cell, std::array<int, 3> at,
                           std::size_t axis) -> void {
        for (const int step : {0, -1, 1}) {
            at[axis] = step;
            const auto there = step == 0 ? std::optional(cell)
                                         : embed::neighbourOf(level.complex, cell, axis, step > 0);
            if (!there) {
                (step < 0 ? ends_[axis].hasLow : ends_[axis].hasHigh) = false;
            } else if (axis == 0) {
                add(*there, at);
            } else {
                self(self, *there, at, axis - 1);
            }
        }
    };
    visit(visit, frame, {0, 0, 0}, 2);
    std::iota(order_.begin(), order_.end(), std::uint8_t{0});
    std::sort(order_.begin(), order_.end(), [&](std::uint8_t a, std::uint8_t b) {
        return std::pair(vertices_[a], a) < std::pair(vertices_[b], b);
    });
}

std::vector<embed::VertexWeight> TricubicPatch::weights(const Eigen::Vector3d& uvw,
                                                        const std::array<int, 3>& orders) const {
    std::array<std::array<double, 4>, 3> along;
    for (std::size_t axis = 0; axis < 3; ++axis)
        along[axis] = folded(
            embed::cubicBSpline(uvw[static_cast<Eigen::Index>(axis)], orders[axis]), ends_[axis]);
    std::array<double, 64> weights;
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t i = 0; i < 4; ++i)
                weights[i + 4 * j + 16 * k] = along[0][i] * along[1][j] * along[2][k];
    std::vector<embed::VertexWeight> result;
    result.reserve(64);
    for (const std::uint8_t i : order_)
        if (weights[i] != 0) result.push_back({vertices_[i], weights[i]});
    return result;
}

TricubicPatch::ControlPoints TricubicPatch::controlPoints(std::span<const Point3> positions) const {
    ControlPoints points;
    for (std::size_t i = 0; i < 64; ++i)
        if (vertices_[i] == kMaxIndex)
            points[i].setZero();
        else
            points[i] = Eigen::Vector3d(positions[vertices_[i]].data());
    // Where two axes lack a layer, the later axis makes phantoms from phantoms.
    std::size_t stride = 1;
    for (std::size_t axis = 0; axis < 3; ++axis, stride *= 4)
        for (std::size_t i = 0; i < 64; ++i) {
            if (i / stride % 4 != 0) continue;
            const auto layer = [&](std::size_t at) -> Eigen::Vector3d& {
                return points[i + at * stride];
            };
            if (!ends_[axis].hasLow) layer(0) = 2 * layer(1) - layer(2);
            if (!ends_[axis].hasHigh) layer(3) = 2 * layer(2) - layer(1);
        }
    return points;
}

TricubicPatch::ControlPoints bezierPoints(TricubicPatch::ControlPoints points) {
    for (std::size_t stride = 1; stride < 64; stride *= 4)
        for (std::size_t i = 0; i < 64; ++i) {
            if (i / stride % 4 != 0) continue;
            // Ends of the cubic, then Bézier points for its end tangents.
            Eigen::Vector3d &a = points[i], &b = points[i + stride], &c = points[i + 2 * stride],
                            &d = points[i + 3 * stride];
            const Eigen::Vector3d low = (a + 4 * b + c) / 6, high = (b + 4 * c + d) / 6;
            const Eigen::Vector3d afterLow = (2 * b + c) / 3, beforeHigh = (b + 2 * c) / 3;
            a = low, b = afterLow, c = beforeHigh, d = high;
        }
    return points;
}

}  // namespace espalier::limit
