// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/bind_groups.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <string>

#include "limit_search.h"

namespace espalier::limit {

// For bindGroups(), which finds them by the namespace of LimitTable.
const stencils::StencilTable<double>& pointRows(const LimitTable& table) {
    return table.points;
}

void gatherRows(std::vector<embed::BoundPart<LimitTable>>& parts, Index rowCount, Index columnCount,
                LimitTable& result) {
    std::vector<embed::BoundPart<stencils::StencilTable<double>>> rows(parts.size());
    for (std::size_t p = 0; p < parts.size(); ++p) rows[p].points = std::move(parts[p].points);
    const auto gather = [&](auto tableOf) {
        for (std::size_t p = 0; p < parts.size(); ++p)
            rows[p].table = std::move(tableOf(parts[p].table));
        gatherRows(rows, rowCount, columnCount, tableOf(result));
    };
    using Rows = stencils::StencilTable<double>;
    gather([](LimitTable& table) -> Rows& { return table.points; });
    for (std::size_t axis = 0; axis < 3; ++axis)
        gather([axis](LimitTable& table) -> Rows& { return table.gradients[axis]; });
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Around irregular features gradients are those of the nearest vertex of a cell of this size.
constexpr double kGradientTolerance = 1e-12;

/// Options whose places serve gradients too, if these are asked for.
LimitOptions forGradients(LimitOptions options) {
    if (options.gradients) options.tolerance = std::min(options.tolerance, kGradientTolerance);
    return options;
}

/// The rows of places over the vertices of their level.
stencils::StencilTable<double> rowsOf(const PlaceRows& places, std::size_t placeCount,
                                      Index vertexCount) {
    return stencils::buildTable(static_cast<Index>(placeCount), vertexCount,
                                [&](Index row, stencils::RowAccumulator& accumulator) {
                                    const auto weights = places.weights(row, kPosition);
                                    for (const auto& [vertex, weight] : weights)
                                        accumulator.add(vertex, weight);
                                });
}

/// (T X)⁻¹ for the directions T of one place, three rows from `first` on, and the rest pose X. Not
/// a number where T X spans no volume.
Matrix3d inverseAtRest(const stencils::StencilTable<double>& tangents, Index first,
                       std::span<const Point3> positions) {
    // Rounding of T X is some 1e-16 of the sums of its terms' sizes: of what is this flat, F would
    // have six digits at best.
    constexpr double kFlat = 1e-10;
    Matrix3d atRest = Matrix3d::Zero();
    Vector3d sizes = Vector3d::Zero();
    for (Index row = 0; row < 3; ++row) {
        const auto columns = tangents.columns(first + row);
        const auto weights = tangents.weights(first + row);
        if (columns.empty()) continue;
        // Rows sum to 0: seen from a vertex near by, coordinates are small.
        const Vector3d origin(positions[columns.front()].data());
        for (std::size_t k = 0; k < columns.size(); ++k) {
            const Vector3d term = weights[k] * (Vector3d(positions[columns[k]].data()) - origin);
            atRest.row(row) += term.transpose();
            sizes[row] += term.norm();
        }
    }
    // Directions of any length: derivatives of deep levels are very small.
    const Matrix3d unit = sizes.cwiseInverse().asDiagonal() * atRest;
    if (!(std::abs(unit.determinant()) > kFlat))
        return Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
    return unit.inverse() * sizes.cwiseInverse().asDiagonal();
}

/// A row of F's column `axis` for each place. F maps the rest pose as the directions T do:
/// Fᵀ = (T X)⁻¹ T x.
/// \param tangents three rows a place, over the base
/// \param positions of the base at rest
/// \param scale what gradients by these positions are multiplied by
std::array<stencils::StencilTable<double>, 3> gradientsOf(
    const stencils::StencilTable<double>& tangents, std::span<const Point3> positions,
    double scale) {
    const Index placeCount = tangents.rowCount() / 3;
    std::vector<Matrix3d> inverses(placeCount);
    for (Index i = 0; i < placeCount; ++i)
        inverses[i] = scale * inverseAtRest(tangents, 3 * i, positions);
    std::array<stencils::StencilTable<double>, 3> gradients;
    for (std::size_t axis = 0; axis < 3; ++axis)
        gradients[axis] = stencils::buildTable(
            placeCount, tangents.columnCount(),
            [&](Index place, stencils::RowAccumulator& accumulator) {
                const Matrix3d& inverse = inverses[place];
                if (!inverse.allFinite()) return;
                for (Index row = 0; row < 3; ++row) {
                    const double factor = inverse(static_cast<Eigen::Index>(axis), row);
                    const auto columns = tangents.columns(3 * place + row);
                    const auto weights = tangents.weights(3 * place + row);
                    for (std::size_t k = 0; k < columns.size(); ++k)
                        accumulator.add(columns[k], factor * weights[k]);
                }
                accumulator.makeSumZero();
            });
    return gradients;
}

/// \throws Error naming a cell, a face or a vertex of so many sides that the levels around it would
///         take all memory: each point near it needs some twenty levels, with as many cells as that
void checkSides(const far::CellComplex& complex) {
    constexpr std::ptrdiff_t kMaxSides = 1000;
    const auto check = [&](int dimension, int other, const char* entity, const char* sides) {
        const far::Incidence& relation = complex.relation(dimension, other);
        for (Index i = 0; i < relation.rowCount(); ++i)
            if (std::ssize(relation[i]) > kMaxSides)
                throw Error(std::string(entity) + " " + std::to_string(i) + " has " +
                            std::to_string(relation[i].size()) + " " + sides +
                            "; to bind points to the limit, at most " + std::to_string(kMaxSides) +
                            " are allowed: split it, or bind the points to a level");
    };
    check(3, 2, "cell", "faces");
    check(2, 1, "face", "edges");
    check(0, 1, "vertex", "edges");
}

/// Binds groups of points to the limit volume.
class LimitBinder {
public:
    /// \param lattice in units; its base and positions must outlive this
    LimitBinder(const embed::RestLattice& lattice, const embed::LengthUnit& unit,
                const LimitOptions& options)
        : positions_(lattice.positions),
          perLength_(unit.toUnits(1.0)),
          gradients_(options.gradients),
          search_(lattice, forGradients(options)) {}

    using Part = embed::BoundPart<LimitTable>;

    std::vector<Part> bind(std::span<const Point3> points) const {
        std::vector<Part> parts;
        std::vector<Index> left(points.size());
        std::iota(left.begin(), left.end(), Index{0});
        std::vector<Index> unsettled;
        addParts(search_.findInside(points, unsettled), left, parts);
        if (!unsettled.empty())
            addParts(search_.findNearest(embed::chosenPoints(points, unsettled)), unsettled, parts);
        return parts;
    }

private:
    /// A part for the points of each level, and one for those without a place.
    /// \param numbers of the points
    void addParts(const FoundPoints& found, const std::vector<Index>& numbers,
                  std::vector<Part>& parts) const {
        const stencils::Levels& levels = found.descent.levels;
        std::vector<Part> ofLevels(static_cast<std::size_t>(levels.finest()) + 1);
        std::vector<std::vector<LimitPlace>> places(ofLevels.size());
        Part without;
        for (std::size_t i = 0; i < found.points.size(); ++i) {
            const LocatedInLimit& located = found.points[i];
            Part& part = located.place ? ofLevels[located.place->level] : without;
            part.points.push_back(numbers[i]);
            part.statuses.push_back(located.status);
            if (!located.place) continue;
            part.largestResidual = std::max(part.largestResidual, located.residual);
            places[located.place->level].push_back(*located.place);
        }
        std::vector<stencils::StencilTable<double>> rows, directions;
        for (std::size_t level = 0; level < ofLevels.size(); ++level) {
            const PlaceRows weights(levels, static_cast<int>(level), places[level]);
            rows.push_back(
                rowsOf(weights, places[level].size(),
                       levels.refiner().level(static_cast<int>(level)).complex.count(0)));
            if (gradients_) directions.push_back(weights.tangents());
        }
        auto tables = stencils::composeRows(levels.tables(), std::move(rows),
                                            stencils::compositionOf(levels.tables()));
        if (gradients_)
            directions = stencils::composeDerivatives(levels.tables(), std::move(directions),
                                                      stencils::RowMeaning::Spans);
        for (std::size_t level = 0; level < ofLevels.size(); ++level) {
            if (places[level].empty()) continue;
            LimitTable& table = ofLevels[level].table;
            table.points = std::move(tables[level]);
            if (gradients_) {
                table.gradients = gradientsOf(directions[level], positions_, perLength_);
            }
            parts.push_back(std::move(ofLevels[level]));
        }
        if (!without.points.empty()) parts.push_back(std::move(without));
    }

    std::span<const Point3> positions_;
    double perLength_;  ///< units in a length of 1
    bool gradients_;
    LimitSearch search_;
};

}  // namespace

embed::BindingResultOf<LimitTable> bindLimit(const embed::RestLattice& lattice,
                                             std::span<const Point3> points,
                                             const LimitOptions& options) {
    checkLimitTolerance(options.tolerance);
    checkLimitRules(lattice.rules);
    embed::checkRest(lattice, 1);
    checkSides(lattice.base.level(0).complex);
    const embed::LengthUnit unit(lattice.positions);
    const std::vector<Point3> inUnits = unit.toUnits(lattice.positions);
    auto binder = std::make_shared<const LimitBinder>(
        embed::RestLattice{lattice.base, inUnits, lattice.rules}, unit, options);
    // As in a deep level: most points at irregular features share no cells with others.
    constexpr Offset kGroupSize = 1 << 12;
    auto model = embed::bindGroups<LimitTable>(
        [binder = std::move(binder)](std::span<const Point3> group) { return binder->bind(group); },
        lattice.base, unit, points, kGroupSize, options.embedding.outside, options.progress);
    if (!options.gradients) model.binding.table.gradients = {};
    return model;
}

}  // namespace espalier::limit
