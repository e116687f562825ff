// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/far/topology_match.h>
#include <espalier/stencils/local_binding.h>
#include <espalier/stencils/place_points.h>

#include <atomic>
#include <numeric>
#include <string>
#include <utility>

#include "group_binder.h"

namespace espalier::stencils {
namespace {

void checkBase(const far::TopologyRefiner& base, std::span<const Point3> positions, int level) {
    if (base.dimension() != 3)
        throw Error("points can be bound to a lattice only, not to a complex of dimension " +
                    std::to_string(base.dimension()));
    if (base.maxLevel() != 0)
        throw Error("points are bound to a base that has not been refined; this one has " +
                    std::to_string(base.maxLevel()) + " levels more");
    if (level < 1)
        throw Error("points are bound to level 1 or above, not to level " + std::to_string(level));
    const far::Level& lattice = base.level(0);
    checkPositions(lattice.complex, positions);
    // Without boundary control there may be no next level: refining says what is missing.
    bool isLeft = false;
    for (Index vertex = 0; vertex < lattice.complex.count(0); ++vertex)
        isLeft = isLeft || !lattice.strata.isOpen({0, vertex});
    if (!isLeft) far::TopologyRefiner(base).refineUniform(1);
}

/// Whether a level has no more cells than so many, as far as the vertices of the base cells tell:
/// a vertex of a cell becomes a cell, most of them hexahedra, which become eight.
bool isWithin(const far::CellComplex& base, int level, Offset most) {
    auto cells = static_cast<double>(base.relation(3, 0).values().size());
    for (int k = 1; k < level; ++k) cells *= 8;
    return cells <= static_cast<double>(most);
}

template <class Real>
std::unique_ptr<const GroupBinder<Real>> makeBinder(const far::TopologyRefiner& base,
                                                    std::span<const Point3> positions, int level,
                                                    Rules rules, Offset pointCount,
                                                    const EmbeddingOptions& options) {
    // Where there are points for every cell, nothing is saved by leaving some out, and groups
    // would refine the cells between them twice.
    if (isWithin(base.level(0).complex, level, pointCount))
        return std::make_unique<WholeBinder<Real>>(base, positions, level, rules, options);
    return std::make_unique<PartBinder<Real>>(base, positions, level, rules, options);
}

/// Puts the rows of all parts into one table.
/// \param parts with the numbers of their points in the whole model; emptied
template <class Real>
StencilTable<Real> gather(std::vector<BoundPart<Real>>& parts, Index rowCount, Index columnCount) {
    Array<Offset> offsets(static_cast<std::size_t>(rowCount) + 1, 0);
    for (const BoundPart<Real>& part : parts)
        for (Index i = 0; i < part.table.rowCount(); ++i)
            // A point that is settled beside the cells has no entries among those inside.
            offsets[static_cast<std::size_t>(part.points[static_cast<std::size_t>(i)]) + 1] +=
                static_cast<Offset>(part.table.columns(i).size());
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    Array<Index> columns(static_cast<std::size_t>(offsets.back()));
    Array<Real> weights(columns.size());
    far::parallelFor(std::ssize(parts), 1, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            BoundPart<Real>& part = parts[static_cast<std::size_t>(p)];
            for (Index i = 0; i < part.table.rowCount(); ++i) {
                const Offset to =
                    offsets[static_cast<std::size_t>(part.points[static_cast<std::size_t>(i)])];
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

}  // namespace

template <class Real>
BoundModel<Real> bindPoints(const far::TopologyRefiner& base, std::span<const Point3> positions,
                            int level, Rules rules, std::span<const Point3> points,
                            const EmbeddingOptions& options,
                            const std::function<void(Offset)>& progress) {
    checkBase(base, positions, level);
    checkPointCount(points);
    const Offset pointCount = std::ssize(points);
    const auto binder = makeBinder<Real>(base, positions, level, rules, pointCount, options);
    const std::vector<Index> order = alongCurve(points);
    // Larger groups share more of the cells around theirs; but their levels are held at once, some
    // 100 kB a level for a point that shares none, as most do on the fine levels.
    const Offset groupSize = level < 7 ? 1 << 14 : 1 << 11;
    std::vector<std::vector<BoundPart<Real>>> groups(
        static_cast<std::size_t>((pointCount + groupSize - 1) / groupSize));
    std::atomic<Offset> done = 0;
    far::parallelFor(pointCount, groupSize, [&](Offset first, Offset last) {
        std::vector<Point3> own;
        for (Offset i = first; i < last; ++i)
            own.push_back(points[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])]);
        auto& parts = groups[static_cast<std::size_t>(first / groupSize)];
        parts = binder->bind(own);
        for (BoundPart<Real>& part : parts)
            for (Index& point : part.points) point = order[static_cast<std::size_t>(first + point)];
        if (progress) progress(done += last - first);
    });

    BoundModel<Real> model;
    model.statuses.resize(points.size());
    std::vector<BoundPart<Real>> parts;
    for (auto& group : groups)
        for (BoundPart<Real>& part : group) {
            for (std::size_t i = 0; i < part.points.size(); ++i)
                model.statuses[static_cast<std::size_t>(part.points[i])] = part.statuses[i];
            model.largestResidual = std::max(model.largestResidual, part.largestResidual);
            parts.push_back(std::move(part));
        }
    if (options.outside == OutsidePolicy::Error) checkAllInside(points, model.statuses);
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
