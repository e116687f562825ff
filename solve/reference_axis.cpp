// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/vector3.h>
#include <espalier/solve/reference_axis.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string>

#include "axis_formula.h"

namespace espalier::solve {
namespace {

using Complex = std::complex<double>;
using stencils::StencilTable;

// The step of the complex step: f(x + ih) = f(x) + ih f'(x) + O(h²), without cancellation. Its
// square is 0 beside anything, and the products with it are not denormal.
constexpr double kStep = 1e-100;

void requireVector(const char* field, const Point3& vector) {
    if (!isFinite(vector) || !(length(vector) > 0))
        throw ArgumentError("", field, textOf(vector), "a finite vector other than 0");
}

void requirePositions(std::span<const Point3> positions) {
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!isFinite(positions[v]))
            throw Error(concat("the position of vertex ", v, " is not finite"));
}

template <class Number>
NodeValues<Number> valuesAt(std::span<const double> values, Index node) {
    NodeValues<Number> result;
    for (std::size_t k = 0; k < result.size(); ++k)
        result[k] = values[Offset{ReferenceAxis::kValues} * node + k];
    return result;
}

template <class Number>
AxisVector<Number> numbersOf(const Point3& point) {
    return {point[0], point[1], point[2]};
}

/// Returns what determines the position of a vertex that is linked to a segment of an axis.
template <class Number>
AxisPart<Number> partOf(const Point3& vertex, std::span<const Point3> nodes, Index segment,
                        double fraction, std::span<const double> values) {
    return {numbersOf<Number>(vertex),
            {numbersOf<Number>(nodes[segment]), numbersOf<Number>(nodes[segment + 1])},
            {valuesAt<Number>(values, segment), valuesAt<Number>(values, segment + 1)},
            fraction};
}

/// Calls use(index, derivative of the position) for each of some numbers of a part, which the
/// complex step moves one after the other.
template <class Numbers, class Use>
void differentiate(const AxisTurns& turns, AxisPart<Complex>& part, Numbers& numbers,
                   const Use& use) {
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        const Complex before = numbers[k];
        numbers[k] += Complex(0, kStep);
        const AxisVector<Complex> moved = axisPosition(turns, part);
        numbers[k] = before;
        use(k, Point3{moved[0].imag() / kStep, moved[1].imag() / kStep, moved[2].imag() / kStep});
    }
}

/// The derivatives of one vertex, for a table whose three rows of a vertex are made one by one.
struct Column {
    Index column;
    Point3 derivative;
};

/// Makes a table whose rows 3v to 3v + 2 are the derivatives columnsOf(v).
template <class ColumnsOf>
StencilTable<double> tableOf(Index vertexCount, Index columnCount, const ColumnsOf& columnsOf) {
    std::vector<std::vector<Column>> all(vertexCount);
    for (Index v = 0; v < vertexCount; ++v) all[v] = columnsOf(v);
    return stencils::buildTable(3 * vertexCount, columnCount,
                                [&](Index row, stencils::RowAccumulator& sums) {
                                    for (const Column& one : all[row / 3])
                                        sums.add(one.column, one.derivative[row % 3]);
                                });
}

}  // namespace

ReferenceAxis::ReferenceAxis(std::span<const Point3> positions, const AxisOptions& options)
    : nodes_(options.nodes),
      vertices_(positions.begin(), positions.end()),
      order_(options.order),
      follows_(options.follows),
      frame_(options.frame) {
    if (nodes_.size() < 2)
        throw ArgumentError("", "nodes", std::to_string(nodes_.size()), "two or more");
    requireNodes(nodes_);
    requireVector("direction", options.direction);
    constexpr double kParallel = 1e-9;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b <= a; ++b)
            if (!(std::abs(dot(frame_[a], frame_[b]) - (a == b ? 1 : 0)) < kParallel))
                throw ArgumentError("", concat("frame[", a, "]"), textOf(frame_[a]),
                                    "three unit vectors at right angles");
    requirePositions(vertices_);
    links_.reserve(vertices_.size());
    for (const Point3& vertex : vertices_) links_.push_back(linkOf(vertex, options));
}

void ReferenceAxis::requireNodes(std::span<const Point3> nodes) const {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (!isFinite(nodes[i]))
            throw ArgumentError("", concat("nodes[", i, "]"), textOf(nodes[i]), "finite numbers");
        if (i > 0 && !(length(difference(nodes[i], nodes[i - 1])) > 0))
            throw ArgumentError("", concat("nodes[", i, "]"), textOf(nodes[i]),
                                "a place other than the one of the node before");
    }
}

ReferenceAxis::Link ReferenceAxis::linkOf(const Point3& vertex, const AxisOptions& options) const {
    // The distance that the link keeps smallest, and then its length: of points that are equally
    // near to the line or the plane, the one that is nearest to the vertex.
    Link best = {0, 0};
    double bestAway = std::numeric_limits<double>::infinity(), bestLength = bestAway;
    const Point3 unit = normalised(options.direction);
    const auto projected = [&](const Point3& v) {
        const Point3 part = scaled(unit, dot(v, unit));
        return options.link == AxisLink::Nearest ? v
               : options.link == AxisLink::Along ? difference(v, part)
                                                 : part;
    };
    double size = 0;
    for (const Point3& node : nodes_) size = std::max(size, length(difference(node, vertex)));
    const double rounding = 1e-12 * size;
    for (Index i = 0; i + 1 < nodeCount(); ++i) {
        const Point3 side = difference(nodes_[i + 1], nodes_[i]);
        const Point3 arm = difference(vertex, nodes_[i]);
        const Point3 shown = projected(side);
        // A segment that is parallel to the line, or in the plane, is equally near everywhere.
        constexpr double kParallel = 1e-12;
        const bool isParallel = length(shown) <= kParallel * length(side);
        const double u = isParallel ? dot(arm, side) / dot(side, side)
                                    : dot(projected(arm), shown) / dot(shown, shown);
        const double fraction = std::clamp(u, 0.0, 1.0);
        const Point3 link = difference(arm, scaled(side, fraction));
        const double away = length(projected(link)), size1 = length(link);
        // At a node, the next segment.
        if (away < bestAway - rounding ||
            (away < bestAway + rounding && size1 < bestLength + rounding)) {
            best = {i, fraction};
            bestAway = away;
            bestLength = size1;
        }
    }
    return best;
}

ReferenceAxis ReferenceAxis::movedTo(std::span<const Point3> positions,
                                     std::span<const Point3> nodes) const {
    if (positions.size() != vertices_.size() || nodes.size() != nodes_.size())
        throw Error(concat("there are ", positions.size(), " positions and ", nodes.size(),
                           " nodes; expected ", vertices_.size(), " and ", nodes_.size()));
    requireNodes(nodes);
    requirePositions(positions);
    ReferenceAxis result = *this;
    result.vertices_.assign(positions.begin(), positions.end());
    result.nodes_.assign(nodes.begin(), nodes.end());
    return result;
}

std::vector<double> ReferenceAxis::atRest() const {
    std::vector<double> values;
    values.reserve(count());
    for (const Point3& node : nodes_)
        values.insert(values.end(),
                      {node[0], node[1], node[2], 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0});
    return values;
}

std::vector<Point3> ReferenceAxis::feet() const {
    std::vector<Point3> result;
    result.reserve(links_.size());
    for (const Link& link : links_)
        result.push_back(between(nodes_[link.segment], nodes_[link.segment + 1], link.fraction));
    return result;
}

void ReferenceAxis::check(std::span<const double> values) const {
    if (std::ssize(values) != count())
        throw Error(concat("there are ", values.size(), " values; expected ", count(),
                           ", eleven for each node"));
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i]))
            throw Error(concat("values[", i, "] is ", values[i], "; expected a finite number"));
    for (Index i = 1; i < nodeCount(); ++i) {
        const auto a = valuesAt<double>(values, i - 1), b = valuesAt<double>(values, i);
        // As for nodes at rest: a distance that underflows has no direction either.
        if (!(length(Point3{b[0] - a[0], b[1] - a[1], b[2] - a[2]}) > 0))
            throw Error(concat("the values move nodes ", i - 1, " and ", i,
                               " to the same place, where the axis has no direction"));
    }
}

std::vector<Point3> ReferenceAxis::positions(std::span<const double> values) const {
    check(values);
    std::vector<Point3> result;
    result.reserve(vertices_.size());
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        const auto& [segment, fraction] = links_[v];
        result.push_back(
            axisPosition<double>({order_, follows_, frame_},
                                 partOf<double>(vertices_[v], nodes_, segment, fraction, values)));
    }
    return result;
}

StencilTable<double> ReferenceAxis::matrix(std::span<const double> values) const {
    check(values);
    return tableOf(vertexCount(), count(), [&](Index v) {
        const Link link = links_[v];
        auto part = partOf<Complex>(vertices_[v], nodes_, link.segment, link.fraction, values);
        std::vector<Column> columns;
        for (Index end = 0; end < 2; ++end)
            differentiate(
                {order_, follows_, frame_}, part, part.values[end],
                [&](std::size_t k, const Point3& derivative) {
                    const Index node = link.segment + end;
                    columns.push_back({kValues * node + static_cast<Index>(k), derivative});
                });
        return columns;
    });
}

StencilTable<double> ReferenceAxis::restMatrix(std::span<const double> values) const {
    check(values);
    return tableOf(vertexCount(), 3 * (vertexCount() + nodeCount()), [&](Index v) {
        const Link link = links_[v];
        auto part = partOf<Complex>(vertices_[v], nodes_, link.segment, link.fraction, values);
        std::vector<Column> columns;
        const auto add = [&](Index point, AxisVector<Complex>& numbers) {
            differentiate({order_, follows_, frame_}, part, numbers,
                          [&](std::size_t k, const Point3& derivative) {
                              columns.push_back({3 * point + static_cast<Index>(k), derivative});
                          });
        };
        add(v, part.vertex);
        for (Index end = 0; end < 2; ++end) add(vertexCount() + link.segment + end, part.rest[end]);
        return columns;
    });
}

}  // namespace espalier::solve
