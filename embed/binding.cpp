// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/binding.h>
#include <espalier/far/topology_match.h>

#include <string>

namespace espalier::embed {
namespace {

/// \param buildTable makes D, once it is known that the points are those of the embedding
template <class Place, class BuildTable>
Binding bindTo(const far::CellComplex& base, const PlacedPoints<Place>& embedding,
               std::span<const Point3> points, BuildTable buildTable) {
    if (points.size() != embedding.points.size())
        throw Error("got " + std::to_string(points.size()) + " points; embedded were " +
                    std::to_string(embedding.points.size()));
    Binding binding;
    binding.table = buildTable();
    binding.topologyHash = far::topologyHash(base);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (embedding.points[i].place) continue;
        binding.kept.push_back(static_cast<Index>(i));
        binding.keptAt.push_back(points[i]);
    }
    return binding;
}

}  // namespace

Binding makeBinding(const far::TopologyRefiner& refiner, int level, stencils::Rules rules,
                    const Embedding& embedding, std::span<const Point3> points) {
    return bindTo(refiner.level(0).complex, embedding, points,
                  [&] { return buildDeformationTable(refiner, level, rules, embedding); });
}

Binding makeBinding(const TensorLattice& lattice, const TensorEmbedding& embedding,
                    std::span<const Point3> points) {
    return bindTo(lattice.complex(), embedding, points,
                  [&] { return buildDeformationTable(lattice, embedding); });
}

}  // namespace espalier::embed
