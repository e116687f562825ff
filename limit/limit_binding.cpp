// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/bind_groups.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/embed/regular_binding.h>
#include <espalier/embed/row_bound.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <string>

#include "limit_search.h"

namespace espalier::limit {

namespace {

/// Size of cell at irregular features when gradients are requested. There the gradient of a place
/// is taken at the nearest vertex of its cell.
constexpr double kGradientTolerance = 1e-12;

/// Options with a tolerance that is tight enough for gradients, if these are requested.
LimitOptions forGradients(LimitOptions options) {
    if (options.gradients) options.tolerance = std::min(options.tolerance, kGradientTolerance);
    return options;
}

/// Returns the rows of places over the vertices of their level.
stencils::StencilTable<double> rowsOf(const PlaceRows& places, std::size_t placeCount,
                                      Index vertexCount) {
    const auto isAscending = [](std::span<const embed::VertexWeight> weights) {
        for (std::size_t i = 1; i < weights.size(); ++i)
            if (weights[i - 1].vertex >= weights[i].vertex) return false;
        return true;
    };
    return stencils::buildTableByChunks(static_cast<Index>(placeCount), vertexCount,
                                        [&](Offset first, Offset last, stencils::RowList& rows) {
                                            stencils::RowAccumulator accumulator(vertexCount);
                                            for (Offset i = first; i < last; ++i) {
                                                const auto weights = places.weights(i, kPosition);
                                                // The weights of a patch are a row already, which
                                                // takes a third of the time.
                                                if (isAscending(weights)) {
                                                    rows.appendRow(weights);
                                                    continue;
                                                }
                                                for (const auto& [vertex, weight] : weights)
                                                    accumulator.add(vertex, weight);
                                                accumulator.flush(rows);
                                            }
                                        });
}

/// Limits the number of sides. Each point near an irregular entity needs twenty to thirty levels,
/// each with as many cells as the entity has sides: with more sides the levels would take all the
/// memory.
/// \throws Error naming a cell, a face or a vertex with more sides
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
    /// \param lattice positions in units; its base and positions must outlive this
    LimitBinder(const embed::RestLattice& lattice, const embed::LengthUnit& unit,
                const LimitOptions& options)
        : perLength_(unit.toUnits(1.0)),
          gradients_(options.gradients),
          carriesOutside_(options.embedding.outside == embed::OutsidePolicy::Nearest),
          search_(lattice, forGradients(options)) {}

    using Part = embed::BoundPart<stencils::StencilTable<double>>;

    const embed::PointDescent& descent() const { return search_.descent(); }

    std::vector<Part> bind(std::span<const Point3> points) const {
        std::vector<Part> parts;
        std::vector<Index> all(points.size());
        std::iota(all.begin(), all.end(), Index{0});
        std::vector<Index> unsettled, deep;
        addParts(search_.findInside(points, unsettled, deep), all, parts);
        for (std::span<const Index> left = deep; !left.empty();) {
            const auto some = left.first(std::min(left.size(), LimitSearch::kMaxDeepPoints));
            left = left.subspan(some.size());
            std::vector<Index> numbers(some.begin(), some.end()), unsettledOfThese, none;
            addParts(search_.findInside(embed::chosenPoints(points, some), unsettledOfThese, none),
                     numbers, parts);
            for (const Index i : unsettledOfThese) unsettled.push_back(some[i]);
        }
        if (unsettled.empty()) return parts;
        std::vector<Index> outside;
        addParts(search_.findBeside(embed::chosenPoints(points, unsettled), outside), unsettled,
                 parts);
        if (!carriesOutside_ || outside.empty()) return parts;
        for (Index& i : outside) i = unsettled[i];
        addParts(search_.carry(embed::chosenPoints(points, outside)), outside, parts);
        return parts;
    }

private:
    /// Adds a part for the points of each level, and one for the points without a place.
    /// \param numbers numbers of the found points in the group
    void addParts(const FoundPoints& found, const std::vector<Index>& numbers,
                  std::vector<Part>& parts) const {
        const stencils::Levels& levels = found.descent.levels;
        std::vector<Part> ofLevels(levels.finest() + 1);
        std::vector<std::vector<LimitPlace>> places(ofLevels.size());
        std::vector<std::vector<double>> residuals(ofLevels.size());
        Part without;
        for (std::size_t i = 0; i < found.points.size(); ++i) {
            const LocatedInLimit& located = found.points[i];
            Part& part = located.place ? ofLevels[located.place->level] : without;
            part.points.push_back(numbers[i]);
            if (located.status == embed::PointStatus::Outside && located.place)
                part.carried.push_back({static_cast<Index>(part.statuses.size()), located.away});
            part.statuses.push_back(located.status);
            if (!located.place) continue;
            places[located.place->level].push_back(*located.place);
            residuals[located.place->level].push_back(located.residual);
        }
        std::vector<PlaceRows> weights;
        std::vector<stencils::StencilTable<double>> rows;
        for (int level = 0; level <= levels.finest(); ++level) {
            weights.emplace_back(levels, level, places[level]);
            rows.push_back(rowsOf(weights.back(), places[level].size(),
                                  levels.refiner().level(level).complex.count(0)));
        }
        auto tables = stencils::composeRows(levels.tables(), std::move(rows),
                                            stencils::compositionOf(levels.tables()));
        std::vector<embed::Gradients> gradients;
        if (gradients_) gradients = gradientsOf(levels, places, weights);
        for (std::size_t level = 0; level < ofLevels.size(); ++level) {
            if (places[level].empty()) continue;
            Part& part = ofLevels[level];
            const std::vector<Index> unbounded = embed::unboundedRows(tables[level]);
            part.table = embed::emptyRows(std::move(tables[level]), unbounded);
            if (gradients_)
                part.gradients = embed::withoutPoints(std::move(gradients[level]), unbounded);
            for (std::size_t i = 0; i < places[level].size(); ++i)
                if (!part.table.columns(static_cast<Index>(i)).empty())
                    part.largestResidual = std::max(part.largestResidual, residuals[level][i]);
            part.baseVertices = found.descent.baseVertices;
            parts.push_back(std::move(part));
        }
        if (!without.points.empty()) parts.push_back(std::move(without));
    }

    /// Returns the gradients of the places of each level.
    std::vector<embed::Gradients> gradientsOf(const stencils::Levels& levels,
                                              std::span<const std::vector<LimitPlace>> places,
                                              std::span<const PlaceRows> weights) const {
        std::vector<embed::SplinePlaces> splines;
        std::vector<stencils::StencilTable<double>> vertices, directions;
        std::vector<std::vector<Index>> others;  // The places that get rows of their own.
        for (int level = 0; level <= levels.finest(); ++level) {
            const Index vertexCount = levels.refiner().level(level).complex.count(0);
            std::vector<Index> used;
            splines.push_back(splinesOf(levels, weights[level], places[level].size(), used));
            vertices.push_back(
                stencils::buildTable(static_cast<Index>(used.size()), vertexCount,
                                     [&](Index row, stencils::RowAccumulator& accumulator) {
                                         accumulator.add(used[row], 1);
                                     }));
            others.emplace_back();
            std::vector<LimitPlace> otherPlaces;
            auto next = splines.back().places.begin();
            for (Index i = 0; i < std::ssize(places[level]); ++i) {
                if (next != splines.back().places.end() && next->point == i) {
                    ++next;
                    continue;
                }
                others.back().push_back(i);
                otherPlaces.push_back(places[level][i]);
            }
            directions.push_back(PlaceRows(levels, level, otherPlaces).tangents());
        }
        vertices = stencils::composeRows(levels.tables(), std::move(vertices),
                                         stencils::compositionOf(levels.tables()));
        directions = stencils::composeDerivatives(levels.tables(), std::move(directions),
                                                  stencils::RowMeaning::Spans);
        std::vector<embed::Gradients> result;
        for (std::size_t level = 0; level < splines.size(); ++level) {
            std::vector<embed::Gradients> parts;
            parts.push_back({std::move(vertices[level])});
            parts.back().splines = std::move(splines[level]);
            if (!others[level].empty())
                parts.push_back(
                    embed::renumbered(embed::gradientsOfRows(embed::gradientRows(
                                          directions[level], levels.positions(0), perLength_)),
                                      others[level]));
            result.push_back(embed::merged(parts, levels.refiner().level(0).complex.count(0)));
        }
        return result;
    }

    /// Returns the places in regular cells of a level that get no rows of their own: none, unless
    /// the places share the vertices of their cells.
    /// \param used the vertices of the patches, ascending: what the patches refer to
    static embed::SplinePlaces splinesOf(const stencils::Levels& levels, const PlaceRows& weights,
                                         std::size_t placeCount, std::vector<Index>& used) {
        // Three cases get rows. If a point would need more than two vertices, its rows take less
        // memory. Long rows of vertices take too much (stencils::Composition). On deep levels,
        // differences of vertices round by more than 2⁶ units in the last place of a displacement.
        constexpr std::size_t kMaxVertices = 2;
        constexpr int kMaxLevel = 6;
        if (weights.level() > kMaxLevel ||
            stencils::compositionOf(levels.tables()) == stencils::Composition::FromRows)
            return {};
        embed::SplinePlaces splines = weights.splinePlaces();
        for (const auto& patch : splines.patches)
            for (const Index vertex : patch)
                if (vertex != kMaxIndex) used.push_back(vertex);
        sortUnique(used);
        if (used.size() > kMaxVertices * placeCount) {
            used.clear();
            return {};
        }
        for (auto& patch : splines.patches)
            for (Index& vertex : patch)
                if (vertex != kMaxIndex) vertex = indexIn(used, vertex);
        return splines;
    }

    double perLength_;  ///< number of units in a length of 1
    bool gradients_;
    bool carriesOutside_;
    LimitSearch search_;
};

/// Number of neighbouring points that are bound together, as in a deep level: most points at
/// irregular features share no cells with other points.
constexpr Offset kGroupSize = 1 << 12;

/// Makes the searches for points in the limit, in units, and calls f with them.
/// \throws Error, ArgumentError as bindLimit() for the lattice and the options; as f
template <class F>
auto withSearches(const embed::RestLattice& lattice, const LimitOptions& options, F f) {
    checkLimitTolerance(options.tolerance, "limitTolerance");
    checkLimitRules(lattice.base.rules());
    embed::checkRest(lattice, 1);
    checkSides(lattice.base.level(0).complex);
    const embed::LengthUnit unit(lattice.positions);
    const std::vector<Point3> inUnits = unit.toUnits(lattice.positions);
    const embed::RestLattice rest{lattice.base, inUnits};
    auto binder = std::make_shared<const LimitBinder>(rest, unit, options);
    const embed::RegularSearch regular(rest, binder->descent(), embed::kLimitSpacing);
    return f(unit, std::move(binder), regular,
             embed::BindingOptions{.embedding = options.embedding,
                                   .gradients = options.gradients,
                                   .progress = options.progress});
}

}  // namespace

embed::BoundRows<> bindLimit(const embed::RestLattice& lattice, std::span<const Point3> points,
                             const LimitOptions& options) {
    return withSearches(
        lattice, options,
        [&](const embed::LengthUnit& unit, std::shared_ptr<const LimitBinder> binder,
            const embed::RegularSearch& regular, const embed::BindingOptions& chosen) {
            return embed::bindRegularFirst(
                regular, unit, points, chosen,
                [&](std::span<const Point3> others, const embed::BindingOptions& ofOthers) {
                    return embed::bindGroups<stencils::StencilTable<double>>(
                        [own = std::move(binder)](std::span<const Point3> group) {
                            return own->bind(group);
                        },
                        lattice.base, unit, others, kGroupSize, ofOthers);
                });
        });
}

void bindLimitInGroups(const embed::RestLattice& lattice, std::span<const Point3> points,
                       const LimitOptions& options, embed::RowSink sink) {
    withSearches(lattice, options,
                 [&](const embed::LengthUnit& unit, std::shared_ptr<const LimitBinder> binder,
                     const embed::RegularSearch& regular, const embed::BindingOptions& chosen) {
                     embed::bindRegularFirstInto(
                         regular, unit, points, chosen, sink,
                         [&](std::span<const Point3> others, const embed::BindingOptions& ofOthers,
                             embed::RowSink sinkOthers) {
                             embed::bindGroupsInto(
                                 [&](std::span<const Point3> group) { return binder->bind(group); },
                                 lattice.base, unit, others, kGroupSize, ofOthers, sinkOthers);
                         });
                 });
}

}  // namespace espalier::limit
