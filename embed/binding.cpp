// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/binding.h>
#include <espalier/far/topology_match.h>

#include <string>

namespace espalier::embed {
namespace {

/// \param buildTable makes D, once it is known that the points are those of the embedding
template <class Real, class Place, class BuildTable>
Binding<Real> bindTo(const far::CellComplex& base, const PlacedPoints<Place>& embedding,
                     std::span<const Point3> points, BuildTable buildTable) {
    if (points.size() != embedding.points.size())
        throw Error("got " + std::to_string(points.size()) + " points; embedded were " +
                    std::to_string(embedding.points.size()));
    Binding<Real> binding;
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

template <class Real>
Binding<Real> makeBinding(const far::TopologyRefiner& refiner, int level, stencils::Rules rules,
                          const Embedding& embedding, std::span<const Point3> points) {
    return bindTo<Real>(refiner.level(0).complex, embedding, points, [&] {
        return buildDeformationTable<Real>(refiner, level, rules, embedding);
    });
}

template <class Real>
Binding<Real> makeBinding(const TensorLattice& lattice, const TensorEmbedding& embedding,
                          std::span<const Point3> points) {
    return bindTo<Real>(lattice.complex(), embedding, points,
                        [&] { return buildDeformationTable<Real>(lattice, embedding); });
}

template Binding<float> makeBinding(const far::TopologyRefiner&, int, stencils::Rules,
                                    const Embedding&, std::span<const Point3>);
template Binding<double> makeBinding(const far::TopologyRefiner&, int, stencils::Rules,
                                     const Embedding&, std::span<const Point3>);
template Binding<float> makeBinding(const TensorLattice&, const TensorEmbedding&,
                                    std::span<const Point3>);
template Binding<double> makeBinding(const TensorLattice&, const TensorEmbedding&,
                                     std::span<const Point3>);

}  // namespace espalier::embed
