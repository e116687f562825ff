// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/new_vertices.h>

namespace espalier::shapes {

Lattice withNewVertices(const Lattice& lattice, std::span<const NewVertex> newVertices) {
    Lattice result = lattice;
    for (const NewVertex& vertex : newVertices) result.positions.push_back(vertex.position);
    for (VertexAttribute& attribute : result.attributes) {
        const std::size_t components = attribute.components;
        for (const NewVertex& vertex : newVertices)
            for (std::size_t component = 0; component < components; ++component) {
                double total = 0;
                for (const Index from : vertex.attributesFrom)
                    total += attribute.values[from * components + component];
                const auto count = static_cast<double>(vertex.attributesFrom.size());
                attribute.values.push_back(count > 0 ? total / count : 0);
            }
    }
    for (auto& [name, components, type, values] : result.integers)
        for (const NewVertex& vertex : newVertices)
            for (int component = 0; component < components; ++component) {
                if (vertex.attributesFrom.size() != 1) {
                    values.push_back(noInteger(type));
                    continue;
                }
                const Offset from = vertex.attributesFrom[0];
                values.push_back(values[from * components + component]);
            }
    return result;
}

}  // namespace espalier::shapes
