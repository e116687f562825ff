// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/level_size.h>

#include <algorithm>
#include <limits>

namespace espalier::far {
namespace {

double pairCount(const CellComplex& complex, int from, int to) {
    if (from > complex.dimension()) return 0;
    return static_cast<double>(complex.relation(from, to).values().size());
}

/// Children are intervals [a, b]. Those with a of one dimension less than b are edges, and so on.
/// Faces are quadrilaterals; a cell [v, c], with n edges of c at v, has 2n faces, 4n edges and
/// 2n + 2 vertices, and the n of all vertices of c add up to twice the edges of c.
LevelSize next(const LevelSize& size) {
    const auto [vertices, edges, faces, cells] = size.counts;
    LevelSize result;
    result.counts = {vertices + edges + faces + cells, 2 * edges + size.faceEdges + size.cellFaces,
                     size.faceEdges + size.cellEdges, size.cellVertices};
    result.faceEdges = 4 * result.counts[2];
    result.cellFaces = 4 * size.cellEdges;
    result.cellEdges = 8 * size.cellEdges;
    result.cellVertices = 4 * size.cellEdges + 2 * size.cellVertices;
    return result;
}

}  // namespace

double LevelSize::bytes() const {
    constexpr double kSignedEntry = sizeof(Index) + sizeof(Signed::sign);
    return kSignedEntry * (2 * counts[1] + faceEdges + cellFaces);
}

LevelSize levelSize(const CellComplex& complex, int levels) {
    LevelSize size;
    for (int d = 0; d <= complex.dimension(); ++d) size.counts[d] = complex.count(d);
    size.faceEdges = pairCount(complex, 2, 1);
    size.cellFaces = pairCount(complex, 3, 2);
    size.cellEdges = pairCount(complex, 3, 1);
    size.cellVertices = pairCount(complex, 3, 0);
    // Sizes that are not 0 double at least: long before this level they are infinite, and remain
    // so.
    constexpr int kAllInfinite = 2 * std::numeric_limits<double>::max_exponent;
    for (int level = 0; level < std::min(levels, kAllInfinite); ++level) size = next(size);
    return size;
}

}  // namespace espalier::far
