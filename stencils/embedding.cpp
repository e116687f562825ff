// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>
#include <espalier/stencils/embedding.h>
#include <espalier/stencils/place_points.h>

namespace espalier::stencils {

Embedding embedPoints(const far::CellComplex& complex, std::span<const Point3> positions,
                      std::span<const Point3> points, const EmbeddingOptions& options,
                      const std::function<void(Offset)>& progress) {
    const PointLocator locator(complex, positions, options.tolerance);
    return locatePoints<CellPlace>(
        points, complex.count(0), options.outside, progress,
        [&](const Point3& point, bool seekNearest) { return locator.locate(point, seekNearest); });
}

StencilTable<double> buildEmbeddingTable(const far::CellComplex& complex,
                                         const Embedding& embedding) {
    return buildPlaceTable<double>(embedding, complex.count(0), [&](const CellPlace& place) {
        return placeWeights(complex, place);
    });
}

template <class Real>
StencilTable<Real> buildDeformationTable(const far::TopologyRefiner& refiner, int level,
                                         Rules rules, const Embedding& embedding) {
    const CompactTable weights =
        compactColumns(buildEmbeddingTable(refiner.level(level).complex, embedding));
    const auto stencils = buildStencils<double>(refiner, level, rules, weights.columns);
    // The points in a base cell lead to the vertices around it.
    const BaseEntities origins = baseEntities(refiner, level).back();
    std::vector<Index> groups;
    groups.reserve(embedding.points.size());
    for (const LocatedPoint& point : embedding.points)
        groups.push_back(
            point.place ? origins.of(3)[static_cast<std::size_t>(point.place->cell.value)] : 0);
    return multiply<Real>(weights.table, stencils, RowOrder(groups, origins.count()));
}

template StencilTable<float> buildDeformationTable(const far::TopologyRefiner&, int, Rules,
                                                   const Embedding&);
template StencilTable<double> buildDeformationTable(const far::TopologyRefiner&, int, Rules,
                                                    const Embedding&);

}  // namespace espalier::stencils
