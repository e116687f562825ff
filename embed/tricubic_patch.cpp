// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/tricubic_patch.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

namespace espalier::embed {

TricubicPatch::TricubicPatch(const far::Level& level, const CellFrame& frame) {
    std::array<Index, 64> vertices;
    vertices.fill(kMaxIndex);
    // Returns the number of the control point at `corner` of the cell that is `at` cells away along
    // each axis.
    const auto place = [](const std::array<int, 3>& at, std::size_t corner) {
        std::size_t result = 0;
        for (std::size_t axis = 3; axis-- > 0;)
            result = 4 * result + (at[axis] + 1) + bitOf(corner, axis);
        return result;
    };
    const auto add = [&](const CellFrame& cell, const std::array<int, 3>& at) {
        for (std::size_t corner = 0; corner < 8; ++corner)
            vertices[place(at, corner)] = cell.corners[corner];
    };
    // Visit the three cells along w, from each of these the cells along v, and from each of these
    // the cells along u.
    const auto visit = [&](const auto& self, const CellFrame& cell, std::array<int, 3> at,
                           std::size_t axis) -> void {
        for (const int step : {0, -1, 1}) {
            at[axis] = step;
            const auto there =
                step == 0 ? std::optional(cell) : neighbourOf(level.complex, cell, axis, step > 0);
            if (!there) {
                (step < 0 ? spans_[axis].hasLow : spans_[axis].hasHigh) = false;
            } else if (axis == 0) {
                add(*there, at);
            } else {
                self(self, *there, at, axis - 1);
            }
        }
    };
    visit(visit, frame, {0, 0, 0}, 2);
    sortVertices(vertices);
}

TricubicPatch::TricubicPatch(const Vertices& vertices) {
    std::size_t stride = 1;
    for (SplineSpan& span : spans_) {
        span.hasLow = vertices[kCorner - stride] != kMaxIndex;
        span.hasHigh = vertices[kCorner + 2 * stride] != kMaxIndex;
        stride *= 4;
    }
    sortVertices(vertices);
}

TricubicPatch::Vertices TricubicPatch::vertices() const {
    Vertices result;
    for (std::size_t k = 0; k < 64; ++k) result[places_[k]] = vertices_[k];
    return result;
}

void TricubicPatch::checkVertices(const Vertices& vertices, Index vertexCount) {
    const TricubicPatch patch(vertices);
    for (std::size_t i = 0; i < 64; ++i) {
        bool exists = true;
        std::size_t at = i;
        for (const SplineSpan& span : patch.spans_) {
            exists = exists && (at % 4 != 0 || span.hasLow) && (at % 4 != 3 || span.hasHigh);
            at /= 4;
        }
        const Index vertex = vertices[i];
        if (exists ? vertex < 0 || vertex >= vertexCount : vertex != kMaxIndex)
            throw Error(concat(
                "a patch has vertex ", vertex, " at its control point ", i, "; ",
                exists ? concat("expected 0 to ", vertexCount - 1) : concat("expected none")));
    }
}

void TricubicPatch::sortVertices(const Vertices& vertices) {
    std::iota(places_.begin(), places_.end(), std::uint8_t{0});
    std::sort(places_.begin(), places_.end(), [&](std::uint8_t a, std::uint8_t b) {
        return std::pair(vertices[a], a) < std::pair(vertices[b], b);
    });
    for (std::size_t k = 0; k < 64; ++k) vertices_[k] = vertices[places_[k]];
}

std::vector<VertexWeight> TricubicPatch::weights(const Eigen::Vector3d& uvw,
                                                 const std::array<int, 3>& orders) const {
    const AxisWeights along = axisWeights(uvw, kLimitSpacing, orders);
    std::array<Index, 64> vertices;
    std::array<double, 64> weights;
    writeRow(along, vertices.data(), weights.data());
    std::vector<VertexWeight> result(rowLength(along));
    for (std::size_t k = 0; k < result.size(); ++k) result[k] = {vertices[k], weights[k]};
    return result;
}

bool TricubicPatch::hasRepeatedVertex() const {
    const auto end = std::find(vertices_.begin(), vertices_.end(), kMaxIndex);
    return std::adjacent_find(vertices_.begin(), end) != end;
}

TricubicPatch::AxisWeights TricubicPatch::axisWeights(const Eigen::Vector3d& uvw, double spacing,
                                                      const std::array<int, 3>& orders) const {
    AxisWeights along;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        SplineSpan span = spans_[axis];
        span.spacing = spacing;
        along[axis] = cubicBSpline(uvw[static_cast<Eigen::Index>(axis)], orders[axis], span);
    }
    return along;
}

Index TricubicPatch::rowLength(const AxisWeights& along) {
    Index length = 1;
    for (const auto& weights : along)
        length *= static_cast<Index>(4 - std::count(weights.begin(), weights.end(), 0.0));
    return length;
}

void TricubicPatch::writeRow(const AxisWeights& along, Index* vertices, double* weights) const {
    std::array<double, 64> products;
    std::array<std::uint8_t, 64> isUsed;  // 1 or 0
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t j = 0; j < 4; ++j) {
            const double line = along[1][j] * along[2][k];
            const bool isLineUsed = along[1][j] != 0 && along[2][k] != 0;
            for (std::size_t i = 0; i < 4; ++i) {
                products[i + 4 * j + 16 * k] = along[0][i] * line;
                isUsed[i + 4 * j + 16 * k] = isLineUsed && along[0][i] != 0;
            }
        }
    // Without branches, which the processor could not predict: leaves out weights of 0 by writing
    // the next one over them.
    std::array<Index, 64> ownVertices;
    std::array<double, 64> ownWeights;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 64; ++k) {
        const std::size_t place = places_[k];
        ownVertices[count] = vertices_[k];
        ownWeights[count] = products[place];
        count += isUsed[place];
    }
    std::copy_n(ownVertices.begin(), count, vertices);
    std::copy_n(ownWeights.begin(), count, weights);
}

TricubicPatch::ControlPoints TricubicPatch::controlPoints(std::span<const Point3> positions) const {
    ControlPoints points;
    for (std::size_t k = 0; k < 64; ++k)
        if (vertices_[k] == kMaxIndex)
            points[places_[k]].setZero();
        else
            points[places_[k]] = Eigen::Vector3d(positions[vertices_[k]].data());
    // Where two axes lack a layer, the later axis makes phantoms from phantoms.
    std::size_t stride = 1;
    for (std::size_t axis = 0; axis < 3; ++axis, stride *= 4)
        for (std::size_t i = 0; i < 64; ++i) {
            if (i / stride % 4 != 0) continue;
            const auto layer = [&](std::size_t at) -> Eigen::Vector3d& {
                return points[i + at * stride];
            };
            if (!spans_[axis].hasLow) layer(0) = 2 * layer(1) - layer(2);
            if (!spans_[axis].hasHigh) layer(3) = 2 * layer(2) - layer(1);
        }
    return points;
}

TricubicPatch::ControlPoints bezierPoints(TricubicPatch::ControlPoints points, double spacing) {
    // A level-n vertex is b − h²/6 · b″, where b″ is linear along the cell.
    const double pull = spacing * spacing / 6;
    for (std::size_t stride = 1; stride < 64; stride *= 4)
        for (std::size_t i = 0; i < 64; ++i) {
            if (i / stride % 4 != 0) continue;
            // Ends of the cubic, then Bézier points for its end tangents.
            Eigen::Vector3d &a = points[i], &b = points[i + stride], &c = points[i + 2 * stride],
                            &d = points[i + 3 * stride];
            const Eigen::Vector3d bendLow = pull * (a - 2 * b + c),
                                  bendHigh = pull * (b - 2 * c + d);
            const Eigen::Vector3d low = (a + 4 * b + c) / 6 - bendLow,
                                  high = (b + 4 * c + d) / 6 - bendHigh;
            const Eigen::Vector3d afterLow = (2 * b + c) / 3 - (2 * bendLow + bendHigh) / 3,
                                  beforeHigh = (b + 2 * c) / 3 - (bendLow + 2 * bendHigh) / 3;
            a = low, b = afterLow, c = beforeHigh, d = high;
        }
    return points;
}

}  // namespace espalier::embed
