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
template <class Table>
void markWithoutRows(BoundRows<Table>& rows) {
    for (const Index i : pointRows(rows.table).emptyRows())
        if (rows.statuses[i] == PointStatus::Inside) rows.statuses[i] = PointStatus::NotConverged;
}

/// The numbers of some points among all, and where they come from.
struct PointGroup {
    Offset group = 0;               ///< the number of the group, from 0
    std::span<const Index> points;  ///< the numbers of its points
};

/// Calls f(PointGroup) in parallel for groups of points that are near each other.
/// \param progress as BindingOptions::progress; may be empty
template <class F>
void forEachGroup(std::span<const Point3> points, Offset groupSize,
                  const std::function<void(Offset)>& progress, F f) {
    checkPointCount(points);
    const std::vector<Index> order = alongCurve(points);
    std::atomic<Offset> done = 0;
    parallelFor(std::ssize(points), groupSize, [&](Offset first, Offset last) {
        f(PointGroup{first / groupSize, std::span(order).subspan(first, last - first)});
        if (progress) progress(done += last - first);
    });
}

/// Returns the rows of all parts, without the check of OutsidePolicy::Error.
/// \param parts in units; their points are 0 to rowCount − 1, each in at least one part. Their
///        tables are emptied
/// \param hasGradients makes BoundRows::gradients
template <class Table>
BoundRows<Table> gatherParts(std::vector<BoundPart<Table>> parts, Index rowCount, Index columnCount,
                             const LengthUnit& unit, bool hasGradients) {
    BoundRows<Table> rows;
    rows.statuses.resize(rowCount);
    for (const BoundPart<Table>& part : parts) {
        for (std::size_t i = 0; i < part.points.size(); ++i)
            rows.statuses[part.points[i]] = part.statuses[i];
        rows.largestResidual = std::max(rows.largestResidual, unit.fromUnits(part.largestResidual));
        for (const CarriedPoint& each : part.carried)
            rows.carried.push_back({part.points[each.point], unit.fromUnits(each.away)});
    }
    if constexpr (std::is_same_v<Table, stencils::StencilTable<double>>)
        if (hasGradients) rows.gradients = gatherGradients(parts, columnCount);
    gatherRows(parts, rowCount, columnCount, rows.table);
    markWithoutRows(rows);
    return rows;
}

/// Binds points in parallel, group by group, to one table.
/// \param bindGroup works in units of `unit`. It is destroyed before the rows are gathered, since
///        gathering needs the most memory
/// \param options the level has no meaning here
/// \throws Error under OutsidePolicy::Error if a point is not inside
template <class Table>
BoundRows<Table> bindGroups(BindGroup<Table> bindGroup, const far::TopologyRefiner& base,
                            const LengthUnit& unit, std::span<const Point3> points,
                            Offset groupSize, const BindingOptions& options) {
    std::vector<std::vector<BoundPart<Table>>> groups((std::ssize(points) + groupSize - 1) /
                                                      groupSize);
    std::atomic<Offset> entryCount = 0;
    forEachGroup(points, groupSize, options.progress, [&](const PointGroup& group) {
        auto& parts = groups[group.group];
        parts = bindGroup(unit.toUnits(chosenPoints(points, group.points)));
        for (BoundPart<Table>& part : parts) {
            for (Index& point : part.points) point = group.points[point];
            entryCount += pointRows(part.table).entryCount();
            entryCount += part.gradients.vertices.entryCount() + part.gradients.rows.entryCount();
        }
        // gatherRows() needs as much memory again as the rows of the groups.
        requireMemory(static_cast<std::uint64_t>(entryCount) * (sizeof(Index) + sizeof(double)),
                      "a table of the " + std::to_string(entryCount) + " weights so far");
    });
    bindGroup = {};
    std::vector<BoundPart<Table>> parts;
    for (auto& group : groups)
        for (BoundPart<Table>& part : group) parts.push_back(std::move(part));
    auto rows = gatherParts(std::move(parts), static_cast<Index>(points.size()),
                            base.level(0).complex.count(0), unit, options.gradients);
    if (options.embedding.outside == OutsidePolicy::Error) checkAllInside(points, rows.statuses);
    return rows;
}

/// Binds points in parallel, group by group, and gives the rows of each group to `sink`.
/// \param bindGroup works in units of `unit`
/// \param options the level and the policy for points outside have no meaning here
inline void bindGroupsInto(const BindGroup<stencils::StencilTable<double>>& bindGroup,
                           const far::TopologyRefiner& base, const LengthUnit& unit,
                           std::span<const Point3> points, Offset groupSize,
                           const BindingOptions& options, RowSink sink) {
    forEachGroup(points, groupSize, options.progress, [&](const PointGroup& group) {
        sink(group.points, gatherParts(bindGroup(unit.toUnits(chosenPoints(points, group.points))),
                                       static_cast<Index>(group.points.size()),
                                       base.level(0).complex.count(0), unit, options.gradients));
    });
}

}  // namespace espalier::embed
