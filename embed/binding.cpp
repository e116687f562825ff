// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/binding.h>
#include <espalier/far/topology_match.h>

#include <string>

namespace espalier::embed {

Binding makeBinding(const TensorLattice& lattice, const TensorEmbedding& embedding,
                    std::span<const Point3> points) {
    if (points.size() != embedding.points.size())
        throw Error("got " + std::to_string(points.size()) + " points, but " +
                    std::to_string(embedding.points.size()) + " were embedded");
    Binding binding;
    binding.table = buildDeformationTable(lattice, embedding);
    binding.topologyHash = far::topologyHash(lattice.complex());
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (embedding.points[i].place) continue;
        binding.kept.push_back(static_cast<Index>(i));
        binding.keptAt.push_back(points[i]);
    }
    return binding;
}

}  // namespace espalier::embed
