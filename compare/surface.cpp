// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <algorithm>

#include "surface.h"

namespace espalier::compare {

Surface surfaceOf(const far::CellComplex& complex) {
    if (complex.dimension() < 2) throw Error("a curve has no surface that OpenSubdiv could refine");
    Surface surface;
    std::vector<char> hasVertex(complex.count(0), 0);
    std::vector<char> hasEdge(complex.count(1), 0);
    for (Index face = 0; face < complex.count(2); ++face) {
        if (complex.dimension() == 3 && complex.relation(2, 3)[face].size() != 1) continue;
        surface.faces.push_back(face);
        for (const Index vertex : complex.relation(2, 0)[face]) hasVertex[vertex] = 1;
        for (const Index edge : complex.relation(2, 1)[face]) hasEdge[edge] = 1;
    }
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        if (hasVertex[vertex]) surface.vertices.push_back(vertex);
    for (Index edge = 0; edge < complex.count(1); ++edge)
        if (hasEdge[edge]) surface.edges.push_back(edge);
    return surface;
}

bool isWoundInward(const far::CellComplex& complex, Index face) {
    if (complex.dimension() == 2) return false;
    const Index cell = complex.relation(2, 3)[face].front();
    const auto faces = complex.boundary(3)[cell];
    const auto at = std::find(faces.begin(), faces.end(), face) - faces.begin();
    return complex.boundary(3).signs(cell)[at] < 0;
}

std::vector<Index> surfaceLoop(const far::CellComplex& complex, Index face) {
    const auto row = complex.relation(2, 0)[face];
    std::vector<Index> loop(row.begin(), row.end());
    if (isWoundInward(complex, face)) std::reverse(loop.begin(), loop.end());
    return loop;
}

}  // namespace espalier::compare
