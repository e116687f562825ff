// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/compare/open_subdiv_tables.h>
#include <espalier/osd/evaluation.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

// The figures of a comparison.
namespace espalier::compare {

/// A point in single precision.
using PointF = std::array<float, 3>;

/// The larger of two; not a number if one is none.
double larger(double a, double b);

/// The largest difference of a weight between two tables of the same rows and columns.
double largestDifference(const stencils::StencilTable<double>& a,
                         const stencils::StencilTable<double>& b);

/// The largest difference of a coordinate between as many points; not a number if there is one.
double largestDifference(std::span<const Point3> a, std::span<const Point3> b);
double largestDifference(std::span<const PointF> a, std::span<const PointF> b);

/// A table times positions, by our evaluator and by OpenSubdiv's.
std::vector<PointF> evaluateOurs(const stencils::StencilTable<double>& table,
                                 std::span<const PointF> positions);
std::vector<PointF> evaluateTheirs(const OpenSubdivTable<float>& table,
                                   std::span<const PointF> positions);

/// Side of the cube that randomPositions() fill.
inline constexpr double kRandomSide = 2;

/// Positions from −1 to 1; the same on every platform.
std::vector<Point3> randomPositions(Index count);

/// The same positions in single precision.
std::vector<PointF> toSingle(std::span<const Point3> positions);

/// A table times positions.
template <class Evaluator, class Real>
std::vector<std::array<Real, 3>> evaluate(const stencils::StencilTable<Real>& table,
                                          std::span<const std::array<Real, 3>> positions) {
    std::vector<std::array<Real, 3>> result(table.rowCount());
    const auto layout = osd::BufferDescriptor::packed(3);
    Evaluator::evaluate(table, std::span(positions.data()->data(), 3 * positions.size()), layout,
                        std::span(result.data()->data(), 3 * result.size()), layout,
                        {0, table.rowCount()});
    return result;
}

}  // namespace espalier::compare
