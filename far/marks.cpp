// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/marks.h>
#include <espalier/far/topology_error.h>

#include <algorithm>
#include <string>

namespace espalier::far {

float storedSharpness(double sharpness) {
    // Rounding comes first: a sharpness that rounds to 10 is infinite.
    const bool isInfinite = sharpness >= kLeastInfinite ||
                            static_cast<float>(sharpness) >= static_cast<float>(kLeastInfinite);
    return isInfinite ? kInfinitelySharp : static_cast<float>(sharpness);
}

float subdivideSharpness(float sharpness) {
    return std::max(sharpness - 1, kSmooth);
}

float subdivideEdgeSharpness(Creasing creasing, float sharpness, std::span<const float> around) {
    if (creasing == Creasing::Uniform || !isSemiSharp(sharpness))
        return subdivideSharpness(sharpness);
    // Computes the whole sum first, and then subtracts the edge's own sharpness: OpenSubdiv's order
    // of operations, and so its rounding.
    float sum = 0;
    int count = 0;
    for (const float other : around)
        if (isSemiSharp(other)) {
            sum += other;
            ++count;
        }
    if (count < 2) return subdivideSharpness(sharpness);
    const float others = (sum - sharpness) / static_cast<float>(count - 1);
    return subdivideSharpness(0.75F * sharpness + 0.25F * others);
}

namespace {

float readSharpness(double sharpness, Entity entity, const std::string& name) {
    if (sharpness >= kSmooth) return storedSharpness(sharpness);
    throw TopologyError(
        TopologyCause::BadMark, entity,
        concat(name, " is marked with sharpness ", sharpness, "; expected 0 (smooth) or more"));
}

void checkVertex(const CellComplex& complex, Index vertex) {
    if (vertex < 0 || vertex >= complex.count(0))
        throw TopologyError(
            TopologyCause::VertexOutOfRange, {0, vertex},
            concat("a mark names vertex ", vertex, "; there are ", complex.count(0)));
}

}  // namespace

MarkedSharpness readMarks(const CellComplex& complex, const Marks& marks) {
    MarkedSharpness marked;
    for (const Marks::Edge& mark : marks.edges) {
        for (const Index vertex : mark.vertices) checkVertex(complex, vertex);
        const Index a = mark.vertices[0], b = mark.vertices[1];
        const std::string name = concat("edge (", a, ", ", b, ")");
        const auto edges = complex.relation(0, 1)[a];
        const auto edge = std::find_if(edges.begin(), edges.end(), [&](Index candidate) {
            return a != b && contains(complex.relation(1, 0)[candidate], b);
        });
        if (edge == edges.end())
            throw TopologyError(TopologyCause::BadMark, {0, a},
                                "a mark names " + name + ", which does not exist");
        marked.edges[*edge] = readSharpness(mark.sharpness, {1, *edge}, name);
    }
    for (const Marks::Vertex& mark : marks.vertices) {
        checkVertex(complex, mark.vertex);
        marked.vertices[mark.vertex] =
            readSharpness(mark.sharpness, {0, mark.vertex}, concat("vertex ", mark.vertex));
    }
    return marked;
}

std::vector<Index> readHoles(const CellComplex& complex, const Marks& marks) {
    std::vector<Index> holes = marks.holes;
    sortUnique(holes);
    for (const Index face : holes)
        if (complex.dimension() != 2 || face < 0 || face >= complex.count(2))
            throw TopologyError(
                TopologyCause::BadMark, {2, face},
                concat("face ", face, " is marked as a hole, but ",
                       complex.dimension() == 2 ? concat("there are ", complex.count(2))
                                                : std::string("only a mesh can have holes")));
    return holes;
}

}  // namespace espalier::far
