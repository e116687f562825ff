// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/bind/bind.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/row_bound.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/far/topology_match.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <string>
#include <utility>

#include "weighted_binding.h"

namespace espalier::bind {
namespace {

embed::TensorLattice tensorLattice(const embed::RestLattice& lattice, embed::Basis basis) {
    // Without the marks the deformation would be another one than the lattice asks for.
    if (!lattice.base.options().marks.empty())
        throw Error(
            "the lattice has marks (sharpness of edges or vertices), which only subdivision "
            "applies; bind with subdivision, or remove the marks");
    return {lattice.base.level(0).complex, lattice.positions, basis};
}

/// The points that are sought: those with a weight above 0.
struct SoughtPoints {
    /// \throws Error, ArgumentError as bindPoints() for the weights and the falloff
    SoughtPoints(std::span<const Point3> all, const BindOptions& options);
    SoughtPoints(const SoughtPoints&) = delete;
    SoughtPoints& operator=(const SoughtPoints&) = delete;

    Index numberOf(Index point) const { return areAll ? point : numbers[point]; }

    bool areAll = true;          ///< true if all points are sought
    std::vector<Index> numbers;  ///< if not, their numbers in the model, ascending
    std::vector<Point3> chosen;  ///< and the points
    std::span<const Point3> points;
    embed::EmbeddingOptions embedding;  ///< in place of BindOptions::embedding
    bool refusesOutside;
};

/// Calls f(target) with the options of the library that binds to each kind of target.
struct TargetOptions {
    const BindOptions& options;
    const embed::EmbeddingOptions& embedding;

    embed::BindingOptions of(int level) const {
        return {level, embedding, options.gradients, options.progress};
    }
    limit::LimitOptions of(const Limit& target) const {
        return {.embedding = embedding,
                .tolerance = target.tolerance,
                .gradients = options.gradients,
                .progress = options.progress};
    }
};

/// Binds points to each kind of target, without their weights.
struct Binder {
    const embed::RestLattice& lattice;
    std::span<const Point3> points;
    TargetOptions chosen;

    embed::BoundRows<> operator()(const Level& target) const {
        return embed::bindPoints(lattice, points, chosen.of(target.level));
    }
    embed::BoundRows<> operator()(const Limit& target) const {
        return limit::bindLimit(lattice, points, chosen.of(target));
    }
    embed::BoundRows<> operator()(embed::Basis basis) const {
        return embed::bindPoints(tensorLattice(lattice, basis), points, chosen.of(1));
    }
};

/// The same, group by group.
struct GroupBinder {
    const embed::RestLattice& lattice;
    std::span<const Point3> points;
    TargetOptions chosen;
    embed::RowSink sink;

    void operator()(const Level& target) const {
        embed::bindInGroups(lattice, points, chosen.of(target.level), sink);
    }
    void operator()(const Limit& target) const {
        limit::bindLimitInGroups(lattice, points, chosen.of(target), sink);
    }
    void operator()(embed::Basis basis) const {
        embed::bindInGroups(tensorLattice(lattice, basis), points, chosen.of(1), sink);
    }
};

/// \throws Error
void checkWeights(const PointWeights& weights, std::size_t pointCount) {
    const auto checkCount = [&](std::size_t count, const char* what) {
        if (count != 0 && count != pointCount)
            throw Error(concat("got ", count, " ", what, " for ", pointCount, " points"));
    };
    checkCount(weights.values.size(), "weights");
    checkCount(weights.slopes.size(), "slopes of weights");
    for (std::size_t i = 0; i < weights.values.size(); ++i)
        if (!(weights.values[i] >= 0 && weights.values[i] <= 1))
            throw Error(
                concat("the weight of point ", i, " is ", weights.values[i], "; expected 0 to 1"));
    for (std::size_t i = 0; i < weights.slopes.size(); ++i)
        for (const double slope : weights.slopes[i])
            if (!std::isfinite(slope))
                throw Error(concat("the slope of the weight of point ", i, " is not finite"));
}

/// Returns the embedding options, with the effect of the falloff.
/// \throws ArgumentError; Error for a falloff and OutsidePolicy::Error
embed::EmbeddingOptions embeddingOf(const BindOptions& options) {
    embed::EmbeddingOptions embedding = options.embedding;
    if (!std::isfinite(options.falloff) || options.falloff < 0)
        throw ArgumentError("", "falloff", textOf(options.falloff),
                            "a finite distance of 0 or more");
    if (options.falloff == 0) return embedding;
    if (embedding.outside == embed::OutsidePolicy::Error)
        throw Error(
            "a falloff moves points outside the lattice, which the policy for points outside "
            "refuses: leave out one of the two");
    embedding.outside = embed::OutsidePolicy::Nearest;
    return embedding;
}

SoughtPoints::SoughtPoints(std::span<const Point3> all, const BindOptions& options)
    : points(all), embedding(embeddingOf(options)) {
    checkWeights(options.weights, all.size());
    const auto& values = options.weights.values;
    areAll = std::ranges::all_of(values, [](double value) { return value > 0; });
    if (!areAll) {
        for (std::size_t i = 0; i < all.size(); ++i)
            if (values[i] > 0) numbers.push_back(static_cast<Index>(i));
        chosen = embed::chosenPoints(all, numbers);
        points = chosen;
    }
    // The numbers of points in an error would be their numbers among those that are sought.
    refusesOutside = embedding.outside == embed::OutsidePolicy::Error;
    if (!areAll) embedding = embed::withoutRefusal(embedding);
}

/// The weights of points: the chosen ones, times the falloff.
class Weights {
public:
    /// \param rest the lattice at rest; all levels are in its box
    Weights(const BindOptions& options, std::span<const Point3> rest)
        : chosen_(options.weights), radius_(options.falloff) {
        if (radius_ > 0)
            for (const Point3& vertex : rest) box_.extend(Eigen::Vector3d(vertex.data()));
    }

    bool areNeeded() const { return !chosen_.values.empty() || radius_ > 0; }

    /// Returns the weights of some points.
    /// \param numbers the numbers of the points in the model
    /// \param rows the rows of the points
    std::vector<PointWeight> of(std::span<const Index> numbers, std::span<const Point3> points,
                                const WeightedRows& rows,
                                std::span<const embed::CarriedPoint> carried) const {
        std::vector<PointWeight> weights(numbers.size());
        const auto& [values, slopes] = chosen_;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            if (!values.empty()) weights[i].value = values[numbers[i]];
            if (!slopes.empty()) weights[i].slope = slopes[numbers[i]];
        }
        if (radius_ > 0) addFalloff(points, rows.statuses, carried, weights);
        return weights;
    }

private:
    void addFalloff(std::span<const Point3> points, std::span<const embed::PointStatus> statuses,
                    std::span<const embed::CarriedPoint> carried,
                    std::vector<PointWeight>& weights) const {
        std::vector<bool> isCarried(points.size());
        for (const auto& [point, away] : carried) {
            isCarried[point] = true;
            const PointWeight fall = falloffWeight(away, radius_);
            auto& [value, slope] = weights[point];
            for (std::size_t c = 0; c < 3; ++c)
                slope[c] = fall.value * slope[c] + value * fall.slope[c];
            value *= fall.value;
        }
        // Points far away have no place.
        for (std::size_t i = 0; i < points.size(); ++i)
            if (statuses[i] == embed::PointStatus::Outside && !isCarried[i] &&
                box_.exteriorDistance(Eigen::Vector3d(points[i].data())) >= radius_)
                weights[i] = {0, {}};
    }

    const PointWeights& chosen_;
    double radius_;
    Eigen::AlignedBox3d box_;
};

/// Moves the parts that both have, and leaves `carried`.
WeightedRows rowsOf(embed::BoundRows<>& bound) {
    return {std::move(bound.table),
            std::move(bound.gradients),
            {},
            std::move(bound.statuses),
            bound.largestResidual};
}

std::vector<Index> numbersFrom0(std::size_t count) {
    std::vector<Index> numbers(count);
    std::iota(numbers.begin(), numbers.end(), Index{0});
    return numbers;
}

}  // namespace

Index WeightedRows::count(embed::PointStatus status) const {
    return static_cast<Index>(std::ranges::count(statuses, status));
}

void Binding::checkParts() const {
    const Index rows = table.rowCount(), columns = table.columnCount();
    const auto refuse = [&](const std::string& what) {
        throw Error(
            concat("a binding of ", rows, " points and ", columns, " lattice vertices has ", what));
    };
    const auto checkShape = [&](const char* what, Index ownRows, Index ownColumns) {
        if (ownRows != rows || ownColumns != columns)
            refuse(concat(what, " of ", ownRows, " points and ", ownColumns, " vertices"));
    };
    if (gradients) {
        if (gradients->columnCount() != columns)
            refuse(concat("gradients of ", gradients->columnCount(), " vertices"));
        gradients->check(rows);
    }
    if (!weights.empty() && std::ssize(weights) != rows) refuse(concat(weights.size(), " weights"));
    if (!weights.empty() && !gradients) refuse("weights of gradients, and no gradients");
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const auto& [value, slope] = weights[i];
        if (!(value >= 0 && value <= 1) ||
            !std::ranges::all_of(slope, [](double each) { return std::isfinite(each); }))
            refuse(concat("the weight ", value, " with the slope ", slope[0], " ", slope[1], " ",
                          slope[2], " at point ", i, "; expected 0 to 1, and finite numbers"));
    }
    if (factors) checkShape("factors", factors->points.rowCount(), factors->vertices.columnCount());
    if (std::ssize(points) != rows) refuse(concat(points.size(), " points at rest"));
    if (std::ssize(rest) != columns) refuse(concat(rest.size(), " vertices at rest"));
    if (std::ssize(statuses) != rows) refuse(concat(statuses.size(), " statuses"));
}

embed::GradientTables gradientTables(const Binding& binding) {
    if (!binding.gradients)
        throw Error("the binding has no gradients: bind the points with BindOptions::gradients");
    auto tables = embed::gradientTables(*binding.gradients, binding.rest, binding.table.rowCount());
    if (binding.weights.empty()) return tables;
    for (std::size_t axis = 0; axis < 3; ++axis)
        tables[axis] = stencils::buildTable(
            tables[axis].rowCount(), tables[axis].columnCount(),
            [&](Index row, stencils::RowAccumulator& accumulator) {
                const auto& [weight, slope] = binding.weights[row];
                if (!(weight > 0)) return;
                const auto add = [&](const stencils::StencilTable<double>& rows, double factor) {
                    for (std::size_t k = 0; k < rows.columns(row).size(); ++k)
                        accumulator.add(rows.columns(row)[k], factor * rows.weights(row)[k]);
                };
                add(tables[axis], weight);
                // D has the weight already.
                if (slope[axis] != 0) add(binding.table, slope[axis] / weight);
            });
    return tables;
}

void BindingStatistics::add(const BindingStatistics& others) {
    for (std::size_t i = 0; i < statuses.size(); ++i) statuses[i] += others.statuses[i];
    rowCount += others.rowCount;
    columnCount = others.columnCount;
    entryCount += others.entryCount;
    emptyRowCount += others.emptyRowCount;
    emptyOutsideCount += others.emptyOutsideCount;
    hasGradients = hasGradients || others.hasGradients;
    identityCount += others.identityCount;
    largestResidual = std::max(largestResidual, others.largestResidual);
}

BindingStatistics statisticsOf(const WeightedRows& rows) {
    BindingStatistics result;
    for (const embed::PointStatus status : rows.statuses)
        ++result.statuses[static_cast<std::size_t>(status)];
    result.rowCount = rows.table.rowCount();
    result.columnCount = rows.table.columnCount();
    result.entryCount = rows.table.entryCount();
    for (const Index point : rows.table.emptyRows()) {
        ++result.emptyRowCount;
        if (rows.statuses[point] == embed::PointStatus::Outside) ++result.emptyOutsideCount;
    }
    result.hasGradients = rows.gradients.has_value();
    if (rows.gradients) result.identityCount = rows.gradients->identityCount(result.rowCount);
    result.largestResidual = rows.largestResidual;
    return result;
}

Binding bindPoints(const embed::RestLattice& lattice, std::span<const Point3> points,
                   const Target& target, const BindOptions& options) {
    // Gradients have three rows for each point.
    if (options.gradients && std::ssize(points) > kMaxIndex / 3)
        throw Error(
            concat("got ", points.size(), " points; the most with gradients is ", kMaxIndex / 3));
    const SoughtPoints sought(points, options);
    embed::BoundRows<> bound =
        std::visit(Binder{lattice, sought.points, {options, sought.embedding}}, target);
    Binding binding{rowsOf(bound)};
    if (const auto* level = std::get_if<Level>(&target); level != nullptr && level->factors) {
        auto factors = embed::bindFactored(lattice, sought.points,
                                           {.level = level->level, .embedding = sought.embedding})
                           .table;
        // The two searches may disagree at the tolerance. A point that stays in place by D does so
        // by the factors.
        factors.points = embed::emptyRows(std::move(factors.points), binding.table.emptyRows());
        binding.factors = std::move(factors);
    }
    const Weights weights(options, lattice.positions);
    if (weights.areNeeded()) {
        auto ofPoints = weights.of(sought.areAll ? numbersFrom0(points.size()) : sought.numbers,
                                   sought.points, binding, bound.carried);
        if (binding.factors) binding.factors->points = weighted(binding.factors->points, ofPoints);
        applyWeights(std::move(ofPoints), binding);
    }
    if (!sought.areAll) {
        for (std::size_t i = 0; sought.refusesOutside && i < sought.numbers.size(); ++i)
            if (binding.statuses[i] != embed::PointStatus::Inside)
                embed::refusePoint(sought.numbers[i], sought.chosen[i], binding.statuses[i]);
        addKeptPoints(sought.numbers, static_cast<Index>(points.size()), binding);
    }
    binding.topologyHash = far::topologyHash(lattice.base.level(0).complex);
    binding.points.assign(points.begin(), points.end());
    binding.rest.assign(lattice.positions.begin(), lattice.positions.end());
    return binding;
}

BindingStatistics bindInGroups(const embed::RestLattice& lattice, std::span<const Point3> points,
                               const Target& target, const BindOptions& options, GroupSink sink) {
    const SoughtPoints sought(points, options);
    const Weights weights(options, lattice.positions);
    BindingStatistics statistics;
    std::mutex mutex;
    constexpr Index kNone = kMaxIndex;
    Index firstRefused = kNone;
    embed::PointStatus refusedStatus = {};
    const auto addWeights = [&](std::span<const Index> numbers, embed::BoundRows<> bound) {
        std::vector<Index> inModel;
        for (const Index number : numbers) inModel.push_back(sought.numberOf(number));
        WeightedRows rows = rowsOf(bound);
        if (weights.areNeeded())
            applyWeights(
                weights.of(inModel, embed::chosenPoints(points, inModel), rows, bound.carried),
                rows);
        {
            const std::lock_guard lock(mutex);
            statistics.add(statisticsOf(rows));
            for (std::size_t i = 0; sought.refusesOutside && i < inModel.size(); ++i)
                if (rows.statuses[i] != embed::PointStatus::Inside && inModel[i] < firstRefused) {
                    firstRefused = inModel[i];
                    refusedStatus = rows.statuses[i];
                }
        }
        sink(inModel, std::move(rows));
    };
    std::visit(GroupBinder{lattice, sought.points, {options, sought.embedding}, addWeights},
               target);
    if (firstRefused != kNone)
        embed::refusePoint(firstRefused, points[firstRefused], refusedStatus);
    // The points that were not sought.
    BindingStatistics others;
    others.rowCount = others.emptyRowCount =
        static_cast<Index>(std::ssize(points) - std::ssize(sought.points));
    others.statuses[static_cast<std::size_t>(embed::PointStatus::NotBound)] = others.rowCount;
    others.columnCount = lattice.base.level(0).complex.count(0);
    if (options.gradients) {
        others.hasGradients = true;
        others.identityCount = others.rowCount;
    }
    statistics.add(others);
    return statistics;
}

}  // namespace espalier::bind
