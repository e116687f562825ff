// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/embed/bind_groups.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/embed/regular_binding.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

namespace espalier::embed {
namespace {

/// Number of neighbouring points that are sought together: they share the patches around them. The
/// rows of a group take about a megabyte, so that they are in the cache when a pose is applied.
constexpr Offset kGroupSize = 1 << 11;

/// Finds the places of a group of points.
RegularPlaces placesOf(const RegularSearch& search, const LengthUnit& unit,
                       std::span<const Point3> points, const PointGroup& group) {
    return search.locate(unit.toUnits(chosenPoints(points, group.points)));
}

/// Finds all points of a model.
RegularPlaces placesOf(const RegularSearch& search, const LengthUnit& unit,
                       std::span<const Point3> points,
                       const std::function<void(Offset)>& progress) {
    std::vector<RegularPlaces> groups((std::ssize(points) + kGroupSize - 1) / kGroupSize);
    std::vector<Index> order(points.size());
    std::atomic<Offset> done = 0;
    forEachGroup(points, kGroupSize, {}, [&](const PointGroup& group) {
        std::ranges::copy(group.points, order.begin() + group.group * kGroupSize);
        groups[group.group] = placesOf(search, unit, points, group);
        if (progress) progress(done += groups[group.group].count());
    });
    RegularPlaces all;
    all.places.resize(points.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const auto before = static_cast<Index>(all.patches.size());
        auto next = order.begin() + static_cast<Offset>(g) * kGroupSize;
        for (RegularPlaces::Place place : groups[g].places) {
            if (place.length > 0) place.patch += before;
            all.places[*next++] = place;
        }
        all.patches.insert(all.patches.end(), groups[g].patches.begin(), groups[g].patches.end());
        all.largestResidual = std::max(all.largestResidual, groups[g].largestResidual);
        groups[g] = {};
    }
    return all;
}

/// Makes D from the rows of places, and from the rows of the points that have none.
stencils::StencilTable<double> rowsOf(const RegularPlaces& places, double spacing,
                                      Index columnCount,
                                      const stencils::StencilTable<double>& others) {
    const Offset rowCount = std::ssize(places.places);
    Array<Offset> offsets(rowCount + 1);
    offsets[0] = 0;
    std::vector<Index> otherOf;  // For each chunk of rows, the first of its other points.
    Index other = 0;
    for (Offset row = 0; row < rowCount; ++row) {
        if (row % stencils::kRowsPerChunk == 0) otherOf.push_back(other);
        const auto length = places.places[row].length;
        offsets[row + 1] = length > 0 ? length : std::ssize(others.columns(other++));
    }
    Array<Index> columns;
    Array<double> weights;
    stencils::allocateEntries(offsets, columns, weights);
    parallelFor(rowCount, stencils::kRowsPerChunk, [&](Offset first, Offset last) {
        Index next = otherOf[first / stencils::kRowsPerChunk];
        for (Offset row = first; row < last; ++row) {
            Index* const toColumns = columns.data() + offsets[row];
            double* const toWeights = weights.data() + offsets[row];
            if (places.places[row].length > 0) {
                places.writeRow(row, spacing, toColumns, toWeights);
                continue;
            }
            std::ranges::copy(others.columns(next), toColumns);
            std::ranges::copy(others.weights(next++), toWeights);
        }
    });
    return {stencils::Trusted{}, columnCount, std::move(offsets), std::move(columns),
            std::move(weights)};
}

/// Returns the gradients of the points that have a place.
Gradients gradientsOf(const RegularPlaces& places, double spacing, Index columnCount) {
    Gradients gradients{baseVertexRows(columnCount)};
    SplinePlaces& splines = gradients.splines;
    splines.spacing = spacing;
    for (const TricubicPatch& patch : places.patches) splines.patches.push_back(patch.vertices());
    for (std::size_t i = 0; i < places.places.size(); ++i)
        if (const auto& place = places.places[i]; place.length > 0)
            splines.places.push_back({static_cast<Index>(i), place.patch, place.uvw});
    return gradients;
}

}  // namespace

BoundRows<> bindRegularFirst(const RegularSearch& search, const LengthUnit& unit,
                             std::span<const Point3> points, const BindingOptions& options,
                             BindOthers bindOthers) {
    if (search.isEmpty()) return bindOthers(points, options);
    const auto& progress = options.progress;
    const OutsidePolicy outside = options.embedding.outside;
    const far::CellComplex& base = search.base();
    const RegularPlaces places = placesOf(search, unit, points, progress);
    const Offset placed = places.count();
    if (placed == 0) return bindOthers(points, options);
    BoundRows<> model, others;
    model.statuses.assign(points.size(), PointStatus::Inside);
    std::vector<Index> numbers;  // The points that have no place.
    if (placed < std::ssize(points)) {
        for (std::size_t i = 0; i < points.size(); ++i)
            if (places.places[i].length == 0) numbers.push_back(static_cast<Index>(i));
        // The numbers of points in an error would be their numbers among the others.
        BindingOptions ofOthers = options;
        if (outside == OutsidePolicy::Error) ofOthers.embedding.outside = OutsidePolicy::Keep;
        if (progress) ofOthers.progress = [&](Offset done) { progress(placed + done); };
        others = bindOthers(chosenPoints(points, numbers), ofOthers);
        for (std::size_t i = 0; i < numbers.size(); ++i)
            model.statuses[numbers[i]] = others.statuses[i];
        for (const CarriedPoint& each : others.carried)
            model.carried.push_back({numbers[each.point], each.away});
    }
    model.largestResidual =
        std::max(unit.fromUnits(places.largestResidual), others.largestResidual);
    model.table = rowsOf(places, search.spacing(), base.count(0), others.table);
    if (options.gradients) {
        std::vector<Gradients> parts;
        parts.push_back(gradientsOf(places, search.spacing(), base.count(0)));
        if (others.gradients) parts.push_back(renumbered(std::move(*others.gradients), numbers));
        model.gradients = merged(parts, base.count(0));
    }
    markWithoutRows(model);
    if (outside == OutsidePolicy::Error) checkAllInside(points, model.statuses);
    return model;
}

void bindRegularFirstInto(const RegularSearch& search, const LengthUnit& unit,
                          std::span<const Point3> points, const BindingOptions& options,
                          RowSink sink, BindOthersInto bindOthers) {
    BindingOptions ofOthers = options;
    ofOthers.embedding = withoutRefusal(options.embedding);
    if (search.isEmpty()) return bindOthers(points, ofOthers, sink);
    const Index columnCount = search.base().count(0);
    std::vector<std::vector<Index>> without((std::ssize(points) + kGroupSize - 1) / kGroupSize);
    std::atomic<Offset> done = 0;
    forEachGroup(points, kGroupSize, {}, [&](const PointGroup& group) {
        RegularPlaces places = placesOf(search, unit, points, group);
        std::vector<Index> placed;
        for (std::size_t i = 0; i < places.places.size(); ++i) {
            const bool isPlaced = places.places[i].length > 0;
            (isPlaced ? placed : without[group.group]).push_back(group.points[i]);
            if (isPlaced) places.places[placed.size() - 1] = places.places[i];
        }
        places.places.resize(placed.size());
        if (placed.empty()) return;
        BoundRows<> rows;
        rows.table = rowsOf(places, search.spacing(), columnCount, {});
        rows.statuses.assign(placed.size(), PointStatus::Inside);
        rows.largestResidual = unit.fromUnits(places.largestResidual);
        if (options.gradients) rows.gradients = gradientsOf(places, search.spacing(), columnCount);
        sink(placed, std::move(rows));
        if (options.progress) options.progress(done += std::ssize(placed));
    });
    std::vector<Index> numbers;
    for (std::vector<Index>& each : without) {
        numbers.insert(numbers.end(), each.begin(), each.end());
        each = {};
    }
    if (numbers.empty()) return;
    // In the order of the model.
    std::ranges::sort(numbers);
    if (options.progress) ofOthers.progress = [&](Offset more) { options.progress(done + more); };
    bindOthers(chosenPoints(points, numbers), ofOthers,
               [&](std::span<const Index> some, BoundRows<> rows) {
                   std::vector<Index> inModel;
                   for (const Index i : some) inModel.push_back(numbers[i]);
                   sink(inModel, std::move(rows));
               });
}

}  // namespace espalier::embed
