// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/cpu_evaluator.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "differences.h"

namespace espalier::compare {
double larger(double a, double b) {
    return b > a || std::isnan(b) ? b : a;
}

namespace {

template <class Point>
double largestOf(std::span<const Point> a, std::span<const Point> b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            largest = larger(largest, std::abs(a[i][axis] - b[i][axis]));
    return largest;
}

}  // namespace

double largestDifference(const stencils::StencilTable<double>& a,
                         const stencils::StencilTable<double>& b) {
    double largest = 0;
    for (Index row = 0; row < a.rowCount(); ++row) {
        const auto aColumns = a.columns(row), bColumns = b.columns(row);
        const auto aWeights = a.weights(row), bWeights = b.weights(row);
        for (std::size_t i = 0, j = 0; i < aColumns.size() || j < bColumns.size();) {
            const bool useA =
                j == bColumns.size() || (i < aColumns.size() && aColumns[i] <= bColumns[j]);
            const bool useB =
                i == aColumns.size() || (j < bColumns.size() && bColumns[j] <= aColumns[i]);
            const double difference = (useA ? aWeights[i++] : 0) - (useB ? bWeights[j++] : 0);
            largest = larger(largest, std::abs(difference));
        }
    }
    return largest;
}

double largestDifference(std::span<const Point3> a, std::span<const Point3> b) {
    return largestOf(a, b);
}

double largestDifference(std::span<const PointF> a, std::span<const PointF> b) {
    return largestOf(a, b);
}

std::vector<PointF> evaluateOurs(const stencils::StencilTable<double>& table,
                                 std::span<const PointF> positions) {
    return evaluate<osd::CpuEvaluator, float>(stencils::convertTable<float>(table), positions);
}

std::vector<PointF> evaluateTheirs(const OpenSubdivTable<float>& table,
                                   std::span<const PointF> positions) {
    std::vector<PointF> result(table.GetNumStencils());
    const OpenSubdiv::Osd::BufferDescriptor layout(0, 3, 3);
    OpenSubdiv::Osd::CpuEvaluator::EvalStencils(
        positions.data()->data(), layout, result.data()->data(), layout, table.GetSizes().data(),
        table.GetOffsets().data(), table.GetControlIndices().data(), table.GetWeights().data(), 0,
        table.GetNumStencils());
    return result;
}

std::vector<Point3> randomPositions(Index count) {
    std::mt19937 random(1);
    std::vector<Point3> positions(count);
    for (Point3& position : positions)
        for (double& coordinate : position)
            coordinate = 2 * (static_cast<double>(random()) / 4294967295.0) - 1;
    return positions;
}

std::vector<PointF> toSingle(std::span<const Point3> positions) {
    std::vector<PointF> single;
    single.reserve(positions.size());
    for (const Point3& p : positions)
        single.push_back(
            {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    return single;
}

}  // namespace espalier::compare
