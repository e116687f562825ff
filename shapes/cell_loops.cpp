// SPDX-License-Identifier: Apache-2.0
#include "cell_loops.h"

namespace espalier::shapes {
namespace {

Loop renamed(std::span<const Index> loop, std::span<const Index> newVertex) {
    Loop result;
    result.reserve(loop.size());
    for (const Index vertex : loop) result.push_back(newVertex[vertex]);
    return result;
}

}  // namespace

void addAll(const far::CellComplex& complex, std::span<const Index> newVertex,
            far::ComplexBuilder& builder) {
    const int dimension = complex.dimension();
    for (Index top = 0; top < complex.count(dimension); ++top) {
        if (dimension == 3) {
            std::vector<Loop> loops = far::outwardLoops(complex, CellId(top));
            for (Loop& loop : loops) loop = renamed(loop, newVertex);
            builder.addCell(loops);
        } else {
            const Loop loop = renamed(complex.relation(dimension, 0)[top], newVertex);
            if (dimension == 2)
                builder.addFace(loop);
            else
                builder.addEdge(loop[0], loop[1]);
        }
    }
}

}  // namespace espalier::shapes
