// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/far/refinement.h>
#include <espalier/far/strata.h>
#include <espalier/far/topology_error.h>

#include <algorithm>
#include <string>

#include <espalier/far/surface_fans.h>

namespace espalier::far {
namespace {

/// Returns the same number for every entity of a complex.
Strata::Numbers filled(const CellComplex& complex, int value) {
    Strata::Numbers values;
    for (int d = 0; d <= complex.dimension(); ++d)
        values[d].assign(complex.count(d), static_cast<std::uint8_t>(value));
    return values;
}

/// Sets the number of an entity and of all entities that it contains.
void setClosure(const CellComplex& complex, Entity entity, int value, Strata::Numbers& values) {
    for (int d = 0; d <= entity.dimension; ++d)
        for (const Index part : complex.relation(entity.dimension, d)[entity.index])
            values[d][part] = static_cast<std::uint8_t>(value);
}

/// Returns the strata without sharpness: the dimension of the complex, except for the boundary
/// faces of a lattice and their edges and vertices.
Strata::Numbers classifySmooth(const CellComplex& complex) {
    Strata::Numbers smooth = filled(complex, complex.dimension());
    if (complex.dimension() < 3) return smooth;
    for (Index face = 0; face < complex.count(2); ++face) {
        checkCancelledEvery(face, 14);
        if (complex.relation(2, 3)[face].size() != 2) setClosure(complex, {2, face}, 2, smooth);
    }
    return smooth;
}

/// Returns the entities on the open boundary of the region, given the sharpness that marks request.
Strata::Numbers classifyOpen(const CellComplex& complex, const SharpnessValues& sharpness) {
    Strata::Numbers isOpen = filled(complex, 0);
    const int side = complex.dimension() - 1;
    const auto isSharp = [&](Index index) {
        if (side == 2) return false;
        return (side == 1 ? sharpness.edges : sharpness.vertices)[index] == kInfinitelySharp;
    };
    for (Index index = 0; index < complex.count(side); ++index) {
        checkCancelledEvery(index, 14);
        const auto upperCount = complex.relation(side, side + 1)[index].size();
        const bool isBoundary = complex.dimension() == 2 ? upperCount == 1 : upperCount != 2;
        if (isBoundary && !isSharp(index)) setClosure(complex, {side, index}, 1, isOpen);
    }
    // If all vertices of an entity are open, none of its children remains in the region: the
    // children that would remain bound nothing.
    for (int d = 1; d <= complex.dimension(); ++d)
        for (Index index = 0; index < complex.count(d); ++index) {
            checkCancelledEvery(index, 14);
            const auto vertices = complex.relation(d, 0)[index];
            if (std::all_of(vertices.begin(), vertices.end(),
                            [&](Index vertex) { return isOpen[0][vertex] != 0; }))
                isOpen[d][index] = 1;
        }
    return isOpen;
}

SharpnessValues markedSharpness(const CellComplex& complex, const MarkedSharpness& marked) {
    SharpnessValues sharpness{std::vector<float>(complex.count(0), kSmooth),
                              std::vector<float>(complex.count(1), kSmooth)};
    for (const auto& [edge, value] : marked.edges) sharpness.edges[edge] = value;
    for (const auto& [vertex, value] : marked.vertices) sharpness.vertices[vertex] = value;
    return sharpness;
}

/// Returns true if a boundary edge of a lattice is sharp without a mark.
bool isSharpByRule(const CellComplex& complex, SharpEdges rule, Index edge) {
    if (rule == SharpEdges::SingleCell) return complex.relation(1, 3)[edge].size() == 1;
    const auto ends = complex.relation(1, 0)[edge];
    return std::all_of(ends.begin(), ends.end(),
                       [&](Index vertex) { return complex.relation(0, 3)[vertex].size() <= 2; });
}

/// Sets a sharpness that follows from the topology.
/// \throws TopologyError if a mark would remove it
void force(const MarkedSharpness& marked, Entity entity, const std::string& why,
           SharpnessValues& sharpness) {
    const auto& marks = entity.dimension == 0 ? marked.vertices : marked.edges;
    const auto mark = marks.find(entity.index);
    if (mark != marks.end() && mark->second == kSmooth)
        throw TopologyError(TopologyCause::BadMark, entity,
                            concat(dimensionName(entity.dimension), " ", entity.index,
                                   " is marked smooth, but ", why));
    (entity.dimension == 0 ? sharpness.vertices : sharpness.edges)[entity.index] = kInfinitelySharp;
}

void sharpenEdges(const CellComplex& complex, const SurfaceFans& fans, Boundary boundary,
                  SharpEdges rule, const MarkedSharpness& marked, SharpnessValues& sharpness) {
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        checkCancelledEvery(edge, 12);
        const SurfaceFans::EdgeKind kind = fans.edge(edge);
        if (kind == SurfaceFans::EdgeKind::None) continue;
        if (kind != SurfaceFans::EdgeKind::Manifold) {
            const Index faces = fans.faceCount(edge);
            force(marked, {1, edge},
                  faces == 2 ? std::string("its two faces do not pass it in opposite directions")
                             : concat("it lies in ", faces, faces == 1 ? " face" : " faces",
                                      " of the surface; expected 2"),
                  sharpness);
        } else if (complex.dimension() == 3 && boundary != Boundary::Open &&
                   marked.edges.count(edge) == 0 && isSharpByRule(complex, rule, edge)) {
            sharpness.edges[edge] = kInfinitelySharp;
        }
    }
}

void sharpenVertices(const CellComplex& complex, const SurfaceFans& fans, Boundary boundary,
                     const MarkedSharpness& marked, SharpnessValues& sharpness) {
    const int dimension = complex.dimension();
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        checkCancelledEvery(vertex, 12);
        const bool isAlone = complex.relation(0, dimension)[vertex].size() == 1;
        const SurfaceFans::VertexKind kind = fans.vertex(vertex);
        if (kind == SurfaceFans::VertexKind::None && dimension == 2)
            sharpness.vertices[vertex] = kInfinitelySharp;
        else if (kind == SurfaceFans::VertexKind::NonManifold)
            force(marked, {0, vertex}, "the surface faces around it do not form one fan",
                  sharpness);
        else if (isAlone && boundary == Boundary::Sharp && dimension == 2)
            force(marked, {0, vertex},
                  "it lies in one face, and the boundary mode 'sharp' keeps such corners sharp",
                  sharpness);
        else if (isAlone && boundary == Boundary::Sharp && marked.vertices.count(vertex) == 0)
            sharpness.vertices[vertex] = kInfinitelySharp;
    }
}

void sharpenEnds(const CellComplex& curve, const MarkedSharpness& marked,
                 SharpnessValues& sharpness) {
    for (Index vertex = 0; vertex < curve.count(0); ++vertex)
        if (curve.relation(0, 1)[vertex].size() != 2)
            force(marked, {0, vertex}, "it is not between two edges of the curve", sharpness);
}

}  // namespace

Strata classify(const CellComplex& complex, Boundary boundary, SharpEdges rule,
                const Marks& marks) {
    const MarkedSharpness marked = readMarks(complex, marks);
    SharpnessValues sharpness = markedSharpness(complex, marked);
    Strata::Numbers smooth = classifySmooth(complex), isOpen;
    if (boundary == Boundary::Open) isOpen = classifyOpen(complex, sharpness);
    if (complex.dimension() == 1) {
        sharpenEnds(complex, marked, sharpness);
    } else {
        std::vector<std::uint8_t> isSurfaceFace;
        for (const std::uint8_t stratum : smooth[2]) isSurfaceFace.push_back(stratum == 2);
        const SurfaceFans fans(complex, std::move(isSurfaceFace));
        sharpenEdges(complex, fans, boundary, rule, marked, sharpness);
        sharpenVertices(complex, fans, boundary, marked, sharpness);
    }
    return Strata(complex, std::move(smooth), std::move(isOpen), std::move(sharpness));
}

Strata refineStrata(const CellComplex& parent, const Strata& strata, const Refinement& refinement,
                    Boundary boundary, Creasing creasing) {
    const CellComplex& child = refinement.child();
    Strata::Numbers smooth = refinement.inherit(strata.smoothStrata()), isOpen;
    SharpnessValues sharpness{std::vector<float>(child.count(0), kSmooth),
                              std::vector<float>(child.count(1), kSmooth)};
    refinement.forEachChild(0, 0, [&](Entity entity, const Interval& interval) {
        sharpness.vertices[entity.index] = subdivideSharpness(strata.sharpness(interval.upper));
    });
    refinement.forEachChild(0, 1, [&](Entity entity, const Interval& interval) {
        if (strata.sharpness(interval.upper) > kSmooth)
            sharpness.edges[entity.index] =
                childSharpness(parent, strata, creasing, interval.upper, interval.lower.index);
    });
    if (boundary == Boundary::Open) isOpen = classifyOpen(child, sharpness);
    return Strata(child, std::move(smooth), std::move(isOpen), std::move(sharpness));
}

}  // namespace espalier::far
