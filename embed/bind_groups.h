// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/gradients.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/place_points.h>
#include <espalier/stencils/factored_table.h>

#include <atomic>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

// Binds points in groups, to D or to its factors.
namespace espalier::embed {

/// The result of binding some points of a group.
template <class Table>
struct BoundPart {
    std::vector<Index> points;  ///< their indices in the group
    std::vector<PointStatus> statuses;
    double largestResidual = 0;
    Table table;               ///< one row per point; empty if the point has no place
    Gradients gradients = {};  ///< of the same points; empty if they were not requested
    std::vector<CarriedPoint> carried = {};
    std::vector<Index> baseVertices = {};  ///< numbers in the base of the vertices that the table
                                           ///< starts from; empty if the numbers are equal

    Index baseVertex(Index column) const {
        return baseVertices.empty() ? column : baseVertices[column];
    }
};

/// Binds a group of neighbouring points. Any number of threads may call it at once.
///
/// The returned parts together contain all the points. If several parts contain a point, the last
/// one counts, and the earlier ones have no entries for the point.
template <class Table>
using BindGroup = std::function<std::vector<BoundPart<Table>>(std::span<const Point3>)>;

/// Returns the rows that tell which points have a place.
inline const stencils::StencilTable<double>& pointRows(
    const stencils::StencilTable<double>& table) {
    return table;
}
inline const stencils::StencilTable<double>& pointRows(
    const stencils::FactoredTable<double>& table) {
    return table.points;
}

/// Puts the rows of all parts into one table, and empties the tables of the parts. If several parts
/// use a vertex of the factored form, the result contains the vertex once per part.
/// \param parts with indices of points in the whole model
void gatherRows(std::vector<BoundPart<stencils::StencilTable<double>>>& parts, Index rowCount,
                Index columnCount, stencils::StencilTable<double>& result);
void gatherRows(std::vector<BoundPart<stencils::FactoredTable<double>>>& parts, Index rowCount,
                Index columnCount, stencils::FactoredTable<double>& result);

/// Does the same for the gradients of D.
Gradients gatherGradients(std::vector<BoundPart<stencils::StencilTable<double>>>& parts,
                          Index columnCount);

/// Completes the statuses: a point inside without a row is NotConverged, because its place has
/// unbounded weights (kMaxRowSum).
/// \throws Error under OutsidePolicy::Error if a point is not inside
template <class Table>
void completeStatuses(std::span<const Point3> points, OutsidePolicy outside,
                      BoundRows<Table>& model) {
    for (const Index i : pointRows(model.table).emptyRows())
        if (model.statuses[i] == PointStatus::Inside) model.statuses[i] = PointStatus::NotConverged;
    if (outside == OutsidePolicy::Error) checkAllInside(points, model.statuses);
}

/// Binds points in parallel, group by group; the points of a group are near each other.
/// \param bindGroup works in units of `unit`. It is destroyed before the rows are gathered, since
///        gathering needs the most memory
/// \param options the level has no meaning here
template <class Table>
BoundRows<Table> bindGroups(BindGroup<Table> bindGroup, const far::TopologyRefiner& base,
                            const LengthUnit& unit, std::span<const Point3> points,
                            Offset groupSize, const BindingOptions& options) {
    checkPointCount(points);
    const Offset pointCount = std::ssize(points);
    const std::vector<Index> order = alongCurve(points);
    std::vector<std::vector<BoundPart<Table>>> groups((pointCount + groupSize - 1) / groupSize);
    std::atomic<Offset> done = 0, entryCount = 0;
    parallelFor(pointCount, groupSize, [&](Offset first, Offset last) {
        const auto numbers = std::span(order).subspan(first, last - first);
        auto& parts = groups[first / groupSize];
        parts = bindGroup(unit.toUnits(chosenPoints(points, numbers)));
        for (BoundPart<Table>& part : parts) {
            for (CarriedPoint& each : part.carried) each.point = numbers[part.points[each.point]];
            for (Index& point : part.points) point = numbers[point];
            entryCount += pointRows(part.table).entryCount();
            entryCount += part.gradients.vertices.entryCount() + part.gradients.rows.entryCount();
        }
        // gatherRows() needs as much memory again as the rows of the groups.
        requireMemory(static_cast<std::uint64_t>(entryCount) * (sizeof(Index) + sizeof(double)),
                      "a table of the " + std::to_string(entryCount) + " weights so far");
        if (options.progress) options.progress(done += last - first);
    });

    bindGroup = {};
    BoundRows<Table> model;
    model.statuses.resize(points.size());
    std::vector<BoundPart<Table>> parts;
    for (auto& group : groups)
        for (BoundPart<Table>& part : group) {
            for (std::size_t i = 0; i < part.points.size(); ++i)
                model.statuses[part.points[i]] = part.statuses[i];
            model.largestResidual =
                std::max(model.largestResidual, unit.fromUnits(part.largestResidual));
            for (const CarriedPoint& each : part.carried)
                model.carried.push_back({each.point, unit.fromUnits(each.away)});
            parts.push_back(std::move(part));
        }
    const auto rowCount = static_cast<Index>(pointCount);
    const Index columnCount = base.level(0).complex.count(0);
    if constexpr (std::is_same_v<Table, stencils::StencilTable<double>>)
        if (options.gradients) model.gradients = gatherGradients(parts, columnCount);
    gatherRows(parts, rowCount, columnCount, model.table);
    completeStatuses(points, options.embedding.outside, model);
    return model;
}

}  // namespace espalier::embed
