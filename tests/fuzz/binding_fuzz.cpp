// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/far/complex_builder.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "fuzz_target.h"

namespace espalier::fuzz {
namespace {

/// Builds a complex of one cell of some kind, or of two cells that meet.
far::CellComplex takeComplex(Input& input) {
    using far::StandardCell;
    const int kind = input.choice(6);
    if (kind < 4) {
        const auto cell = static_cast<StandardCell>(kind);
        std::vector<Index> vertices;
        for (Index v = 0; v < far::vertexCount(cell); ++v) vertices.push_back(v);
        far::ComplexBuilder builder(3, far::vertexCount(cell));
        builder.addCell(cell, vertices);
        return builder.build();
    }
    far::ComplexBuilder builder(3, kind == 4 ? 12 : 9);
    builder.addCell(StandardCell::Hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
    if (kind == 4)
        builder.addCell(StandardCell::Hexahedron, {4, 5, 6, 7, 8, 9, 10, 11});
    else
        builder.addCell(StandardCell::Pyramid, {4, 5, 6, 7, 8});
    return builder.build();
}

/// Reads points. They are on a small grid, so that they coincide and fold, or anywhere, or NaN.
class Coordinates {
public:
    explicit Coordinates(Input& input) : input_(input), kind_(input.choice(4)) {
        constexpr double kScales[] = {1, 1e300, 1e-300, 5e-324};
        scale_ = kScales[input.choice(4)];
    }

    Point3 take() {
        Point3 point;
        for (double& coordinate : point) coordinate = takeOne();
        return point;
    }

private:
    double takeOne() {
        if (kind_ == 0) return input_.take<double>();
        if (kind_ == 1) return scale_ * input_.take<float>();
        return scale_ * input_.take<std::int8_t>() / 4;
    }

    Input& input_;
    int kind_;
    double scale_ = 1;
};

double lengthOf(const Point3& point) {
    return std::hypot(point[0], point[1], point[2]);
}

/// Returns the distance between a point and its row times the rest positions.
double errorAt(const stencils::StencilTable<double>& table, Index row,
               const std::vector<Point3>& rest, const Point3& point) {
    Point3 difference = point;
    for (std::size_t k = 0; k < table.weights(row).size(); ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
            difference[axis] -= table.weights(row)[k] * rest[table.columns(row)[k]][axis];
    return lengthOf(difference);
}

std::string formatted(double number) {
    std::ostringstream text;
    text << number;
    return text.str();
}

/// Requires that points at any place, in cells of any shape, are bound at their place, or get a
/// status that says that they are not.
///
/// \param bind bind(refiner, rest, points, options) returns a BoundRows<>
template <class Bind>
void runBinding(Input input, std::size_t maxPoints, Bind bind) {
    const far::CellComplex complex = takeComplex(input);
    const auto rules = static_cast<far::Rules>(input.choice(2));
    const far::TopologyRefiner refiner(complex, {.rules = rules});
    embed::EmbeddingOptions options;
    options.outside = static_cast<embed::OutsidePolicy>(input.choice(3));
    if (input.flag()) options.tolerance = input.take<float>();
    // With a larger tolerance, every cell of the finest level could contain every point.
    if (!(options.tolerance < 0.1)) options.tolerance = 1e-6;
    Coordinates ofVertices(input);
    std::vector<Point3> rest;
    for (Index v = 0; v < refiner.level(0).complex.count(0); ++v) rest.push_back(ofVertices.take());
    Coordinates ofPoints(input);
    std::vector<Point3> points;
    while (input.left() > 0 && points.size() < maxPoints) points.push_back(ofPoints.take());

    const auto bound = resultOf([&] { return bind(refiner, rest, points, options); });
    if (!bound) return;
    double size = 0;
    for (const Point3& vertex : rest) size = std::max(size, lengthOf(vertex));
    require(std::isfinite(bound->largestResidual), "the residual is finite");
    const auto& table = bound->table;
    for (Index row = 0; row < table.rowCount(); ++row) {
        const auto status = bound->statuses[row];
        const Point3& point = points[row];
        double sum = 0;
        for (const double weight : table.weights(row)) {
            require(std::isfinite(weight), "weights are finite");
            sum += weight;
        }
        if (table.weights(row).empty()) {
            require(status != embed::PointStatus::Inside, "a point inside is bound");
            continue;
        }
        if (status != embed::PointStatus::Inside) continue;
        require(std::abs(sum - 1) < 1e-9, "rows sum to 1", std::to_string(sum));
        // The bound covers the residual of the solve, and the rounding of the products of tables,
        // whose weights are between 0 and 1 except for points within the tolerance outside.
        const double bound_ = bound->largestResidual + 1e-11 * (size + lengthOf(point));
        const double error = errorAt(table, row, rest, point);
        require(!std::isfinite(bound_) || error <= bound_ + 1e-320, "a bound point is where it was",
                formatted(error) + " of " + formatted(size));
    }
}

/// Binds points to level 1.
const Target kEmbedding("embedding", [](std::string_view bytes) {
    constexpr std::size_t kMaxPoints = 4;
    runBinding(
        Input(bytes), kMaxPoints,
        [](const auto& refiner, const auto& rest, const auto& points, const auto& options) {
            return embed::bindPoints({refiner, rest}, points, {.level = 1, .embedding = options});
        });
});

/// Binds one point to the limit, with a coarse tolerance: in a lattice without volume, all cells
/// are searched for it.
const Target kLimit("limit", [](std::string_view bytes) {
    constexpr std::size_t kMaxPoints = 1;
    runBinding(Input(bytes), kMaxPoints,
               [](const auto& refiner, const auto& rest, const auto& points, const auto& options) {
                   auto bound = limit::bindLimit(
                       {refiner, rest}, points,
                       {.embedding = options, .tolerance = 1e-3, .gradients = true});
                   for (const auto& table :
                        embed::gradientTables(*bound.gradients, rest, Index(points.size())))
                       for (const double weight : table.weights())
                           require(std::isfinite(weight), "gradients are finite");
                   return bound;
               });
});

}  // namespace
}  // namespace espalier::fuzz
