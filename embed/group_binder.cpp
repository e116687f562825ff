// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/group_binder.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace espalier::embed {
namespace {

using Eigen::Vector3d;
using Extent = far::TopologyRefiner::Extent;

/// Locates points, and makes their rows.
/// \param locate returns the LocatedPoint of point i
/// \param tableOf makes the rows of an embedding
template <class Table, class Locate, class TableOf>
BoundPart<Table> bindWith(std::size_t pointCount, Index vertexCount, Locate locate,
                          TableOf tableOf) {
    Embedding embedding;
    embedding.vertexCount = vertexCount;
    BoundPart<Table> part;
    part.points.resize(pointCount);
    std::iota(part.points.begin(), part.points.end(), Index{0});
    for (const Index i : part.points) {
        embedding.points.push_back(locate(i));
        part.statuses.push_back(embedding.points.back().status);
    }
    part.largestResidual = embedding.largestResidual();
    part.table = tableOf(embedding);
    return part;
}

}  // namespace

template <class Table>
PartBinder<Table>::PartBinder(const far::TopologyRefiner& base, std::span<const Point3> positions,
                              int level, stencils::Rules rules, const EmbeddingOptions& options)
    : level_(level),
      seekNearest_(options.outside == OutsidePolicy::Nearest),
      scale_(CellSolver::scaleOf(positions, options.tolerance)),
      descent_(base, positions, rules, scale_) {}

template <class Table>
std::vector<BoundPart<Table>> PartBinder<Table>::bind(std::span<const Point3> points) const {
    std::vector<BoundPart<Table>> parts;
    std::vector<Index> unsettled;
    parts.push_back(bindInside(points, unsettled));
    if (unsettled.empty()) return parts;
    std::vector<Point3> left;
    for (const Index i : unsettled) left.push_back(points[i]);
    parts.push_back(bindBeside(left));
    parts.back().points = std::move(unsettled);
    return parts;
}

/// Binds the points that are in a cell. Those that may be in a gap between cells, and those outside
/// that are to be carried, come out as `unsettled`.
template <class Table>
BoundPart<Table> PartBinder<Table>::bindInside(std::span<const Point3> points,
                                               std::vector<Index>& unsettled) const {
    const auto found = descent_.descend(points, level_, Sought::Containing, Extent::Cells);
    if (!found)
        return bindWith<Table>(
            points.size(), 0,
            [&](Index i) {
                if (const auto beyond =
                        CellSolver::beyondReach(Vector3d(points[i].data()), seekNearest_))
                    return *beyond;
                if (seekNearest_) unsettled.push_back(i);
                return LocatedPoint{PointStatus::Outside, {}, 0, 0};
            },
            [](const Embedding&) { return Table(); });
    const far::CellComplex& complex = found->refiner.level(level_).complex;
    const CellSolver solver(complex, found->positions, scale_);
    const auto cells = found->candidates.cellsOfPoints(points.size(), [&](Index cell, Index point) {
        return solver.boxOf(CellId(cell)).contains(Vector3d(points[point].data()));
    });
    return bindWith<Table>(
        points.size(), complex.count(0),
        [&](Index i) {
            const Vector3d point(points[i].data());
            if (const auto beyond = CellSolver::beyondReach(point, seekNearest_)) return *beyond;
            if (auto inside = solver.locateIn(point, cells.of(i))) return *inside;
            // A gap lies in the boxes of the cells beside it: a point in no box is outside.
            if (seekNearest_ || !cells.of(i).empty()) unsettled.push_back(i);
            return LocatedPoint{PointStatus::Outside, {}, 0, 0};
        },
        [&](const Embedding& embedding) {
            Table table;
            buildRows(found->refiner, found->tables, embedding, table);
            return table;
        });
}

/// Binds points that are in no cell by the nearest one.
template <class Table>
BoundPart<Table> PartBinder<Table>::bindBeside(std::span<const Point3> points) const {
    // Whether a place beside a cell is on the boundary, its neighbours know.
    const auto found = descent_.descend(points, level_, Sought::Nearest, Extent::Ring);
    const far::CellComplex& complex = found->refiner.level(level_).complex;
    const CellSolver solver(complex, found->positions, scale_);
    const auto cells =
        found->candidates.cellsOfPoints(points.size(), [](Index, Index) { return true; });
    return bindWith<Table>(
        points.size(), complex.count(0),
        [&](Index i) {
            const Vector3d point(points[i].data());
            std::pair nearest(std::numeric_limits<double>::infinity(), kMaxIndex);
            for (const Index cell : cells.of(i))
                nearest = std::min(nearest, {solver.distance(point, CellId(cell)), cell});
            return solver.locateBeside(point, CellId(nearest.second), seekNearest_);
        },
        [&](const Embedding& embedding) {
            Table table;
            buildRows(found->refiner, found->tables, embedding, table);
            return table;
        });
}

template <class Table>
WholeBinder<Table>::WholeBinder(const far::TopologyRefiner& base, std::span<const Point3> positions,
                                int level, stencils::Rules rules, const EmbeddingOptions& options)
    : seekNearest_(options.outside == OutsidePolicy::Nearest) {
    far::TopologyRefiner whole = base;
    whole.refineUniform(level);
    complex_ = whole.level(level).complex;
    locator_ = std::make_unique<PointLocator>(
        complex_, stencils::refinePositions(whole, level, rules, positions),
        CellSolver::scaleOf(positions, options.tolerance));
    stencils_ = stencils::buildStencils(whole, level, rules);
    const stencils::BaseEntities origins = stencils::baseEntities(whole, level).back();
    baseCells_.assign(origins.of(3).begin(), origins.of(3).end());
    baseCellCount_ = origins.count();
}

template <class Table>
std::vector<BoundPart<Table>> WholeBinder<Table>::bind(std::span<const Point3> points) const {
    std::vector<BoundPart<Table>> parts;
    parts.push_back(bindWith<Table>(
        points.size(), complex_.count(0),
        [&](Index i) { return locator_->locate(points[i], seekNearest_); },
        [&](const Embedding& embedding) {
            Table table;
            buildRows(buildEmbeddingTable(complex_, embedding), stencils_,
                      orderByBaseCell(embedding, baseCells_, baseCellCount_), table);
            return table;
        }));
    return parts;
}

template class PartBinder<stencils::StencilTable<double>>;
template class PartBinder<stencils::FactoredTable<double>>;
template class WholeBinder<stencils::StencilTable<double>>;
template class WholeBinder<stencils::FactoredTable<double>>;

}  // namespace espalier::embed
