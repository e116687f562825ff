// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/topology_match.h>
#include <espalier/stencils/binding.h>

#include <string>

namespace espalier::stencils {

template <class Real>
Binding<Real> makeBinding(const far::TopologyRefiner& refiner, int level, Rules rules,
                          const Embedding& embedding, std::span<const Point3> points) {
    if (points.size() != embedding.points.size())
        throw Error("got " + std::to_string(points.size()) + " points; embedded were " +
                    std::to_string(embedding.points.size()));
    Binding<Real> binding;
    binding.table = buildDeformationTable<Real>(refiner, level, rules, embedding);
    binding.topologyHash = far::topologyHash(refiner.level(0).complex);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (embedding.points[i].place) continue;
        binding.kept.push_back(static_cast<Index>(i));
        binding.keptAt.push_back(points[i]);
    }
    return binding;
}

template Binding<float> makeBinding(const far::TopologyRefiner&, int, Rules, const Embedding&,
                                    std::span<const Point3>);
template Binding<double> makeBinding(const far::TopologyRefiner&, int, Rules, const Embedding&,
                                     std::span<const Point3>);

}  // namespace espalier::stencils
