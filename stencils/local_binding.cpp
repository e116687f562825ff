// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/far/topology_match.h>
#include <espalier/stencils/cell_solver.h>
#include <espalier/stencils/local_binding.h>
#include <espalier/stencils/place_points.h>
#include <espalier/stencils/space_curve.h>
#include <espalier/stencils/table_builder.h>

#include <atomic>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "point_descent.h"

namespace espalier::stencils {
namespace {

using Eigen::Vector3d;
using far::CellId;

/// The cells sought for each point: those of point i are cells[offsets[i]] to … [i + 1], ascending.
struct CellsOfPoints {
    std::vector<Offset> offsets;
    std::vector<Index> cells;

    std::span<const Index> of(Index point) const {
        const auto i = static_cast<std::size_t>(point);
        return std::span(cells).subspan(static_cast<std::size_t>(offsets[i]),
                                        static_cast<std::size_t>(offsets[i + 1] - offsets[i]));
    }
};

/// Turns the lists of cells round, and leaves the pairs of which isSought(cell, point) is true.
template <class IsSought>
CellsOfPoints cellsOfPoints(const FoundCells& found, std::size_t pointCount, IsSought isSought) {
    CellsOfPoints result;
    result.offsets.assign(pointCount + 1, 0);
    std::vector<std::pair<Index, Index>> pairs;
    for (std::size_t i = 0; i < found.cells.size(); ++i)
        for (Offset k = found.offsets[i]; k < found.offsets[i + 1]; ++k) {
            const Index point = found.points[static_cast<std::size_t>(k)];
            if (!isSought(found.cells[i], point)) continue;
            pairs.emplace_back(point, found.cells[i]);
            ++result.offsets[static_cast<std::size_t>(point) + 1];
        }
    std::partial_sum(result.offsets.begin(), result.offsets.end(), result.offsets.begin());
    std::vector<Offset> next(result.offsets.begin(), result.offsets.end() - 1);
    result.cells.resize(pairs.size());
    for (const auto& [point, cell] : pairs)
        result.cells[static_cast<std::size_t>(next[static_cast<std::size_t>(point)]++)] = cell;
    return result;
}

CellSolver::Scale scaleOf(std::span<const Point3> positions, double tolerance) {
    Eigen::AlignedBox3d box;
    for (const Point3& position : positions) box.extend(Vector3d(position.data()));
    const double size = box.diagonal().stableNorm();
    return {size, checkedTolerance(tolerance) * size};
}

/// Points that were bound in one part of a level.
template <class Real>
struct BoundGroup {
    std::vector<PointStatus> statuses;
    double largestResidual = 0;
    StencilTable<Real> table;  ///< a row a point, without entries where it has no place
};

/// Binds groups of points, each in the part of the level that it needs.
template <class Real>
class GroupBinder {
public:
    GroupBinder(const far::TopologyRefiner& base, std::span<const Point3> positions, int level,
                Rules rules, const EmbeddingOptions& options)
        : level_(level),
          seekNearest_(options.outside == OutsidePolicy::Nearest),
          scale_(scaleOf(positions, options.tolerance)),
          // Enough for the boxes of the last level; those above may be larger.
          descent_(base, positions, rules, scale_.tolerance + 1e-9 * scale_.size) {}

    /// Binds the points that are in a cell. Those that may be in a gap between cells, and those
    /// outside that are to be carried, come out as `unsettled`.
    BoundGroup<Real> bindInside(std::span<const Point3> points,
                                std::vector<Index>& unsettled) const {
        const auto found = descent_.descend(points, level_, Sought::Containing);
        if (!found) return bindNowhere(points, unsettled);
        const CellSolver solver = solverOf(*found);
        const auto cells = cellsOfPoints(*found, points.size(), [&](Index cell, Index point) {
            return solver.boxOf(CellId(cell)).contains(at(points, point));
        });
        return bindTo(*found, points, [&](Index i) {
            const Vector3d point = at(points, i);
            if (!point.allFinite()) return LocatedPoint{};
            if (auto inside = solver.locateIn(point, cells.of(i))) return *inside;
            // A gap lies in the boxes of the cells beside it: a point in no box is outside.
            if (seekNearest_ || !cells.of(i).empty()) unsettled.push_back(i);
            return LocatedPoint{PointStatus::Outside, {}, 0, 0};
        });
    }

    /// Binds points that are in no cell by the nearest one.
    BoundGroup<Real> bindBeside(std::span<const Point3> points) const {
        const auto found = descent_.descend(points, level_, Sought::Nearest);
        const CellSolver solver = solverOf(*found);
        const auto cells = cellsOfPoints(*found, points.size(), [](Index, Index) { return true; });
        return bindTo(*found, points, [&](Index i) {
            const Vector3d point = at(points, i);
            std::pair nearest(std::numeric_limits<double>::infinity(), far::kMaxIndex);
            for (const Index cell : cells.of(i))
                nearest = std::min(nearest, {solver.distance(point, CellId(cell)), cell});
            return solver.locateBeside(point, CellId(nearest.second), seekNearest_);
        });
    }

private:
    static Vector3d at(std::span<const Point3> points, Index i) {
        return Vector3d(points[static_cast<std::size_t>(i)].data());
    }

    CellSolver solverOf(const FoundCells& found) const {
        return {found.refiner.level(level_).complex, found.positions, scale_};
    }

    /// All points are outside.
    BoundGroup<Real> bindNowhere(std::span<const Point3> points,
                                 std::vector<Index>& unsettled) const {
        BoundGroup<Real> group{
            std::vector<PointStatus>(points.size(), PointStatus::Outside), 0, {}};
        for (Index i = 0; i < static_cast<Index>(points.size()); ++i)
            if (!at(points, i).allFinite())
                group.statuses[static_cast<std::size_t>(i)] = PointStatus::NotConverged;
            else if (seekNearest_)
                unsettled.push_back(i);
        return group;
    }

    /// \param locate returns the LocatedPoint of point i
    template <class Locate>
    BoundGroup<Real> bindTo(const FoundCells& found, std::span<const Point3> points,
                            Locate locate) const {
        Embedding embedding;
        embedding.vertexCount = found.refiner.level(level_).complex.count(0);
        BoundGroup<Real> group;
        for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
            embedding.points.push_back(locate(i));
            group.statuses.push_back(embedding.points.back().status);
        }
        group.largestResidual = embedding.largestResidual();
        group.table = buildDeformationTable<Real>(found.refiner, found.tables, embedding);
        return group;
    }

    int level_;
    bool seekNearest_;
    CellSolver::Scale scale_;
    PointDescent descent_;
};

/// The points in an order in which neighbours follow each other.
std::vector<Index> alongCurve(std::span<const Point3> points) {
    Eigen::AlignedBox3d box;
    for (const Point3& point : points)
        if (const Vector3d position(point.data()); position.allFinite()) box.extend(position);
    const MortonCurve curve(box);
    far::Array<CurvePlace> places(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        places[i] = {curve.key(Vector3d(points[i].data())), static_cast<Index>(i)};
    sortAlongCurve(places);
    std::vector<Index> order;
    order.reserve(points.size());
    for (const CurvePlace& place : places) order.push_back(place.item);
    return order;
}

/// The rows of a group, and where they go.
template <class Real>
struct PlacedRows {
    std::vector<Index> rows;
    StencilTable<Real> table;
};

/// Puts the rows of several tables into one.
template <class Real>
StencilTable<Real> gather(std::vector<PlacedRows<Real>>& parts, Index rowCount, Index columnCount) {
    Array<Offset> offsets(static_cast<std::size_t>(rowCount) + 1, 0);
    for (const PlacedRows<Real>& part : parts)
        for (Index i = 0; i < part.table.rowCount(); ++i)
            // A point that is settled beside the cells has no entries among those inside.
            offsets[static_cast<std::size_t>(part.rows[static_cast<std::size_t>(i)]) + 1] +=
                static_cast<Offset>(part.table.columns(i).size());
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    Array<Index> columns(static_cast<std::size_t>(offsets.back()));
    Array<Real> weights(columns.size());
    far::parallelFor(std::ssize(parts), 1, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            PlacedRows<Real>& part = parts[static_cast<std::size_t>(p)];
            for (Index i = 0; i < part.table.rowCount(); ++i) {
                const Offset to =
                    offsets[static_cast<std::size_t>(part.rows[static_cast<std::size_t>(i)])];
                std::copy(part.table.columns(i).begin(), part.table.columns(i).end(),
                          columns.begin() + to);
                std::copy(part.table.weights(i).begin(), part.table.weights(i).end(),
                          weights.begin() + to);
            }
            part = {};
        }
    });
    return {Trusted{}, columnCount, std::move(offsets), std::move(columns), std::move(weights)};
}

void checkBase(const far::TopologyRefiner& base, std::span<const Point3> positions, int level) {
    if (base.dimension() != 3)
        throw Error("points can be bound to a lattice only, not to a complex of dimension " +
                    std::to_string(base.dimension()));
    if (base.maxLevel() != 0)
        throw Error("points are bound to a base that has not been refined; this one has " +
                    std::to_string(base.maxLevel()) + " levels more");
    if (level < 1)
        throw Error("points are bound to level 1 or above, not to level " + std::to_string(level));
    checkPositions(base.level(0).complex, positions);
}

}  // namespace

template <class Real>
BoundModel<Real> bindPoints(const far::TopologyRefiner& base, std::span<const Point3> positions,
                            int level, Rules rules, std::span<const Point3> points,
                            const EmbeddingOptions& options,
                            const std::function<void(Offset)>& progress) {
    checkBase(base, positions, level);
    checkPointCount(points);
    const GroupBinder<Real> binder(base, positions, level, rules, options);
    const std::vector<Index> order = alongCurve(points);
    BoundModel<Real> model;
    model.statuses.resize(points.size());
    // TODO number
    constexpr Offset kGroup = 1 << 14;
    const Offset pointCount = std::ssize(points), groupCount = (pointCount + kGroup - 1) / kGroup;
    // Of each group the points inside, then those beside the cells.
    std::vector<PlacedRows<Real>> parts(2 * static_cast<std::size_t>(groupCount));
    std::vector<double> residuals(parts.size(), 0);
    std::atomic<Offset> done = 0;
    far::parallelFor(pointCount, kGroup, [&](Offset first, Offset last) {
        const auto keep = [&](std::size_t part, std::vector<Index> rows, BoundGroup<Real> group) {
            for (std::size_t i = 0; i < rows.size(); ++i)
                model.statuses[static_cast<std::size_t>(rows[i])] = group.statuses[i];
            residuals[part] = group.largestResidual;
            parts[part] = {std::move(rows), std::move(group.table)};
        };
        const auto pointsOf = [&](const std::vector<Index>& rows) {
            std::vector<Point3> result;
            result.reserve(rows.size());
            for (const Index row : rows) result.push_back(points[static_cast<std::size_t>(row)]);
            return result;
        };
        const auto part = static_cast<std::size_t>(2 * (first / kGroup));
        std::vector<Index> rows(order.begin() + first, order.begin() + last), unsettled;
        BoundGroup<Real> inside = binder.bindInside(pointsOf(rows), unsettled);
        for (Index& i : unsettled) i = rows[static_cast<std::size_t>(i)];
        keep(part, std::move(rows), std::move(inside));
        if (!unsettled.empty()) {
            BoundGroup<Real> beside = binder.bindBeside(pointsOf(unsettled));
            keep(part + 1, std::move(unsettled), std::move(beside));
        }
        if (progress) progress(done += last - first);
    });

    const auto firstRefused =
        std::find_if(model.statuses.begin(), model.statuses.end(),
                     [](PointStatus status) { return status != PointStatus::Inside; });
    if (options.outside == OutsidePolicy::Error && firstRefused != model.statuses.end()) {
        const auto index = firstRefused - model.statuses.begin();
        refusePoint(index, points[static_cast<std::size_t>(index)], *firstRefused);
    }
    for (const double residual : residuals)
        model.largestResidual = std::max(model.largestResidual, residual);
    model.binding.table =
        gather(parts, static_cast<Index>(pointCount), base.level(0).complex.count(0));
    model.binding.topologyHash = far::topologyHash(base.level(0).complex);
    for (Index i = 0; i < model.binding.table.rowCount(); ++i) {
        if (!model.binding.table.columns(i).empty()) continue;
        model.binding.kept.push_back(i);
        model.binding.keptAt.push_back(points[static_cast<std::size_t>(i)]);
    }
    return model;
}

template BoundModel<float> bindPoints(const far::TopologyRefiner&, std::span<const Point3>, int,
                                      Rules, std::span<const Point3>, const EmbeddingOptions&,
                                      const std::function<void(Offset)>&);
template BoundModel<double> bindPoints(const far::TopologyRefiner&, std::span<const Point3>, int,
                                       Rules, std::span<const Point3>, const EmbeddingOptions&,
                                       const std::function<void(Offset)>&);

}  // namespace espalier::stencils
