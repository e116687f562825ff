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
#include <string>
#include <utility>

#include "weighted_binding.h"

namespace espalier::bind {
namespace {

/// Binds points to each kind of target, without their weights. The points and the lattice at rest
/// are added later.
struct Binder {
    const embed::RestLattice& lattice;
    std::span<const Point3> points;
    const BindOptions& options;
    const embed::EmbeddingOptions& embedding;   ///< in place of options.embedding
    std::vector<embed::CarriedPoint>& carried;  ///< gets the points outside that have a place

    Binding operator()(const Level& target) const {
        Binding binding = made(embed::bindPoints(lattice, points, optionsAt(target.level)));
        if (!target.factors) return binding;
        auto factors =
            embed::bindFactored(lattice, points, {.level = target.level, .embedding = embedding})
                .table;
        // The two searches may disagree at the tolerance. A point that stays in place by D does so
        // by the factors.
        factors.points = embed::emptyRows(std::move(factors.points), binding.table.emptyRows());
        binding.factors = std::move(factors);
        return binding;
    }

    Binding operator()(const Limit& target) const {
        return made(limit::bindLimit(lattice, points,
                                     {.embedding = embedding,
                                      .tolerance = target.tolerance,
                                      .gradients = options.gradients,
                                      .progress = options.progress}));
    }

    Binding operator()(embed::Basis basis) const {
        // Without the marks the deformation would be another one than the lattice asks for.
        if (!lattice.base.options().marks.empty())
            throw Error(
                "the lattice has marks (sharpness of edges or vertices), which only subdivision "
                "applies; bind with subdivision, or remove the marks");
        const embed::TensorLattice tensor(lattice.base.level(0).complex, lattice.positions, basis);
        return made(embed::bindPoints(tensor, points, optionsAt(1)));
    }

private:
    embed::BindingOptions optionsAt(int level) const {
        return {level, embedding, options.gradients, options.progress};
    }

    Binding made(embed::BoundRows<> bound) const {
        carried = std::move(bound.carried);
        Binding binding{std::move(bound.table)};
        binding.statuses = std::move(bound.statuses);
        binding.largestResidual = bound.largestResidual;
        binding.gradients = std::move(bound.gradients);
        return binding;
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

/// Returns the weight of each point without the falloff.
/// \param numbers the points that are bound
std::vector<PointWeight> weightsOf(const PointWeights& chosen, std::span<const Index> numbers) {
    std::vector<PointWeight> weights(numbers.size());
    const auto& [values, slopes] = chosen;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (!values.empty()) weights[i].value = values[numbers[i]];
        if (!slopes.empty()) weights[i].slope = slopes[numbers[i]];
    }
    return weights;
}

/// Multiplies weights by the falloff.
/// \param carried the points outside that have a place
void addFalloff(double radius, std::span<const Point3> points, std::span<const Point3> rest,
                std::span<const embed::CarriedPoint> carried,
                std::span<const embed::PointStatus> statuses, std::vector<PointWeight>& weights) {
    std::vector<bool> isCarried(points.size());
    for (const auto& [point, away] : carried) {
        isCarried[point] = true;
        const PointWeight fall = falloffWeight(away, radius);
        auto& [value, slope] = weights[point];
        for (std::size_t c = 0; c < 3; ++c)
            slope[c] = fall.value * slope[c] + value * fall.slope[c];
        value *= fall.value;
    }
    // Points far away have no place. All levels are in the box of the lattice.
    Eigen::AlignedBox3d box;
    for (const Point3& vertex : rest) box.extend(Eigen::Vector3d(vertex.data()));
    for (std::size_t i = 0; i < points.size(); ++i)
        if (statuses[i] == embed::PointStatus::Outside && !isCarried[i] &&
            box.exteriorDistance(Eigen::Vector3d(points[i].data())) >= radius)
            weights[i] = {0, {}};
}

}  // namespace

Index Binding::count(embed::PointStatus status) const {
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

Binding bindPoints(const embed::RestLattice& lattice, std::span<const Point3> points,
                   const Target& target, const BindOptions& options) {
    // Gradients have three rows for each point.
    if (options.gradients && std::ssize(points) > kMaxIndex / 3)
        throw Error(
            concat("got ", points.size(), " points; the most with gradients is ", kMaxIndex / 3));
    checkWeights(options.weights, points.size());
    const auto& values = options.weights.values;
    std::vector<Index> numbers;  // The points with a weight above 0.
    for (std::size_t i = 0; i < points.size(); ++i)
        if (values.empty() || values[i] > 0) numbers.push_back(static_cast<Index>(i));
    const bool areAllBound = numbers.size() == points.size();
    embed::EmbeddingOptions embedding = embeddingOf(options);
    // The numbers of points in an error would be their numbers among those that are bound.
    const bool refusesOutside = embedding.outside == embed::OutsidePolicy::Error;
    if (!areAllBound && refusesOutside) embedding.outside = embed::OutsidePolicy::Keep;
    std::vector<Point3> chosen;
    if (!areAllBound) chosen = embed::chosenPoints(points, numbers);
    std::vector<embed::CarriedPoint> carried;
    const std::span<const Point3> sought = areAllBound ? points : std::span<const Point3>(chosen);
    Binding binding = std::visit(Binder{lattice, sought, options, embedding, carried}, target);
    if (!values.empty() || options.falloff > 0) {
        auto weights = weightsOf(options.weights, numbers);
        if (options.falloff > 0)
            addFalloff(options.falloff, sought, lattice.positions, carried, binding.statuses,
                       weights);
        applyWeights(std::move(weights), binding);
    }
    if (!areAllBound) {
        for (std::size_t i = 0; refusesOutside && i < numbers.size(); ++i)
            if (binding.statuses[i] != embed::PointStatus::Inside)
                embed::refusePoint(numbers[i], chosen[i], binding.statuses[i]);
        addKeptPoints(numbers, static_cast<Index>(points.size()), binding);
    }
    binding.topologyHash = far::topologyHash(lattice.base.level(0).complex);
    binding.points.assign(points.begin(), points.end());
    binding.rest.assign(lattice.positions.begin(), lattice.positions.end());
    return binding;
}

}  // namespace espalier::bind
