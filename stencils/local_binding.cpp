// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/local_binding.h>

#include <utility>

#include "bind_groups.h"
#include "level_rows.h"

namespace espalier::stencils {
namespace {

/// Whether a level has no more cells than so many, as far as the vertices of the base cells tell:
/// a vertex of a cell becomes a cell, most of them hexahedra, which become eight.
bool isWithin(const far::CellComplex& base, int level, Offset most) {
    auto cells = static_cast<double>(base.relation(3, 0).values().size());
    for (int k = 1; k < level; ++k) cells *= 8;
    return cells <= static_cast<double>(most);
}

template <class Table>
std::unique_ptr<const GroupBinder<Table>> makeBinder(const far::TopologyRefiner& base,
                                                     std::span<const Point3> positions, int level,
                                                     Rules rules, Offset pointCount,
                                                     const EmbeddingOptions& options) {
    // Where there are points for every cell, nothing is saved by leaving some out, and groups
    // would refine the cells between them twice. But rows of S for all of its vertices are too many
    // where they are long.
    const far::CellComplex& complex = base.level(0).complex;
    if (isWithin(complex, level, pointCount) && compositionAbove(complex) == Composition::FromBase)
        return std::make_unique<WholeBinder<Table>>(base, positions, level, rules, options);
    return std::make_unique<PartBinder<Table>>(base, positions, level, rules, options);
}

/// Binds points in either form.
template <class Real, class Table>
BoundModel<Real, Table> bind(const far::TopologyRefiner& base, std::span<const Point3> positions,
                             int level, Rules rules, std::span<const Point3> points,
                             const EmbeddingOptions& options,
                             const std::function<void(Offset)>& progress) {
    checkBase(base, positions, level);
    checkPointCount(points);
    const LengthUnit unit(positions);
    const std::vector<Point3> inUnits = unit.toUnits(positions);
    const auto binder = makeBinder<Table>(base, inUnits, level, rules, std::ssize(points), options);
    // Larger groups share more of the cells around theirs; but their levels are held at once, some
    // 100 kB a level for a point that shares none, as most do on the fine levels.
    const Offset groupSize = level < 7 ? 1 << 14 : 1 << 11;
    return bindGroups<Real, Table>(*binder, base, unit, points, groupSize, options.outside,
                                   progress);
}

}  // namespace

template <class Real>
BoundModel<Real> bindPoints(const far::TopologyRefiner& base, std::span<const Point3> positions,
                            int level, Rules rules, std::span<const Point3> points,
                            const EmbeddingOptions& options,
                            const std::function<void(Offset)>& progress) {
    return bind<Real, StencilTable<Real>>(base, positions, level, rules, points, options, progress);
}

template <class Real>
BoundModel<Real, FactoredTable<Real>> bindFactored(const far::TopologyRefiner& base,
                                                   std::span<const Point3> positions, int level,
                                                   Rules rules, std::span<const Point3> points,
                                                   const EmbeddingOptions& options,
                                                   const std::function<void(Offset)>& progress) {
    return bind<Real, FactoredTable<Real>>(base, positions, level, rules, points, options,
                                           progress);
}

template BoundModel<float> bindPoints(const far::TopologyRefiner&, std::span<const Point3>, int,
                                      Rules, std::span<const Point3>, const EmbeddingOptions&,
                                      const std::function<void(Offset)>&);
template BoundModel<double> bindPoints(const far::TopologyRefiner&, std::span<const Point3>, int,
                                       Rules, std::span<const Point3>, const EmbeddingOptions&,
                                       const std::function<void(Offset)>&);
template BoundModel<float, FactoredTable<float>> bindFactored(const far::TopologyRefiner&,
                                                              std::span<const Point3>, int, Rules,
                                                              std::span<const Point3>,
                                                              const EmbeddingOptions&,
                                                              const std::function<void(Offset)>&);
template BoundModel<double, FactoredTable<double>> bindFactored(const far::TopologyRefiner&,
                                                                std::span<const Point3>, int, Rules,
                                                                std::span<const Point3>,
                                                                const EmbeddingOptions&,
                                                                const std::function<void(Offset)>&);

}  // namespace espalier::stencils
