// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/mlca.h>

namespace espalier::stencils {

std::vector<Entity> mlcaSubCell(const far::CellComplex& complex, Entity whole, std::size_t corner) {
    const Index vertex = complex.relation(whole.dimension, 0)[whole.index][corner];
    std::vector<Entity> parts;
    parts.reserve(8);
    parts.push_back({0, vertex});
    if (whole.dimension == 2) {
        // By position, since the loop may pass the vertex more than once.
        const auto edges = complex.relation(2, 1)[whole.index];
        parts.push_back({1, edges[corner]});
        parts.push_back({1, edges[corner == 0 ? edges.size() - 1 : corner - 1]});
    }
    for (int dimension = 1; whole.dimension == 3 && dimension < 3; ++dimension)
        for (const Index part : complex.relation(0, dimension)[vertex])
            if (far::contains(complex.relation(dimension, 3)[part], whole.index))
                parts.push_back({dimension, part});
    if (whole.dimension > 0) parts.push_back(whole);
    return parts;
}

}  // namespace espalier::stencils
