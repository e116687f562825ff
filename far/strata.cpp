// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/strata.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <string>

namespace espalier::far {

Strata::Strata(const CellComplex& complex, int stratum) {
    for (int d = 0; d <= complex.dimension(); ++d)
        strata_[static_cast<std::size_t>(d)].assign(static_cast<std::size_t>(complex.count(d)),
                                                    static_cast<std::uint8_t>(stratum));
}

void Strata::lower(Entity entity, int stratum) {
    std::uint8_t& current =
        strata_[static_cast<std::size_t>(entity.dimension)][static_cast<std::size_t>(entity.index)];
    current = std::min(current, static_cast<std::uint8_t>(stratum));
}

Index Strata::count(int dimension, int stratum) const {
    const auto& strata = strata_[static_cast<std::size_t>(dimension)];
    return static_cast<Index>(
        std::count(strata.begin(), strata.end(), static_cast<std::uint8_t>(stratum)));
}

namespace {

/// Whether a sharpness is infinite or none.
enum class Sharpness { Sharp, Smooth };

Sharpness readSharpness(double sharpness, Entity entity, const std::string& name) {
    constexpr double kOpenSubdivInfinite = 10;
    if (sharpness >= kOpenSubdivInfinite) return Sharpness::Sharp;
    if (sharpness == kSmooth) return Sharpness::Smooth;
    throw TopologyError(TopologyCause::BadMark, entity,
                        name + " is marked with sharpness " + std::to_string(sharpness) +
                            "; expected 0 (smooth) or at least 10 (sharp)");
}

void checkVertex(const CellComplex& complex, Index vertex) {
    if (vertex < 0 || vertex >= complex.count(0))
        throw TopologyError(TopologyCause::VertexOutOfRange, {0, vertex},
                            "a mark names vertex " + std::to_string(vertex) + "; there are " +
                                std::to_string(complex.count(0)));
}

std::map<Index, Sharpness> readEdgeMarks(const CellComplex& complex, const Marks& marks) {
    std::map<Index, Sharpness> byEdge;
    for (const Marks::Edge& mark : marks.edges) {
        for (const Index vertex : mark.vertices) checkVertex(complex, vertex);
        const Index a = mark.vertices[0], b = mark.vertices[1];
        const std::string name = "edge (" + std::to_string(a) + ", " + std::to_string(b) + ")";
        const auto edges = complex.relation(0, 1)[a];
        const auto edge = std::find_if(edges.begin(), edges.end(), [&](Index candidate) {
            return a != b && contains(complex.relation(1, 0)[candidate], b);
        });
        if (edge == edges.end())
            throw TopologyError(TopologyCause::BadMark, {0, a},
                                "a mark names " + name + ", which does not exist");
        byEdge[*edge] = readSharpness(mark.sharpness, {1, *edge}, name);
    }
    return byEdge;
}

std::map<Index, Sharpness> readVertexMarks(const CellComplex& complex, const Marks& marks) {
    std::map<Index, Sharpness> byVertex;
    for (const Marks::Vertex& mark : marks.vertices) {
        checkVertex(complex, mark.vertex);
        byVertex[mark.vertex] = readSharpness(mark.sharpness, {0, mark.vertex},
                                              "vertex " + std::to_string(mark.vertex));
    }
    return byVertex;
}

template <class Key, class Value>
std::optional<Value> lookUp(const std::map<Key, Value>& map, Key key) {
    const auto at = map.find(key);
    return at == map.end() ? std::nullopt : std::optional(at->second);
}

/// Lowers the entities of dimension d − 1 in other than two of dimension d, and all in them.
void lowerBoundary(const CellComplex& complex, Strata& strata) {
    const int side = complex.dimension() - 1;
    for (Index index = 0; index < complex.count(side); ++index) {
        if (complex.relation(side, side + 1)[index].size() == 2) continue;
        strata.lower({side, index}, side);
        for (int d = 0; d < side; ++d)
            for (const Index part : complex.relation(side, d)[index]) strata.lower({d, part}, side);
    }
}

/// The faces of a row that lie on the surface: boundary faces of a lattice, all faces of a mesh.
std::vector<Index> surfaceFaces(const Strata& strata, std::span<const Index> faces) {
    std::vector<Index> result;
    for (const Index face : faces)
        if (strata.of({2, face}) <= 2) result.push_back(face);
    return result;
}

/// Whether the surface faces at a vertex form one fan, closed or open.
bool formOneFan(const CellComplex& complex, const Strata& strata, Index vertex) {
    const std::vector<Index> faces = surfaceFaces(strata, complex.relation(0, 2)[vertex]);
    if (faces.empty()) return true;
    // Cross from face to face over the edges at the vertex, and count what is reached.
    std::vector<Index> reached = {faces.front()};
    for (std::size_t next = 0; next < reached.size(); ++next)
        for (const Index edge : complex.relation(2, 1)[reached[next]]) {
            if (!contains(complex.relation(1, 0)[edge], vertex)) continue;
            const auto across = surfaceFaces(strata, complex.relation(1, 2)[edge]);
            if (across.size() > 2) return false;
            for (const Index face : across)
                if (!contains(reached, face)) reached.push_back(face);
        }
    return reached.size() == faces.size();
}

bool isSharpByRule(const CellComplex& complex, SharpEdges rule, Index edge) {
    if (rule == SharpEdges::SingleCell) return complex.relation(1, 3)[edge].size() == 1;
    const auto ends = complex.relation(1, 0)[edge];
    return std::all_of(ends.begin(), ends.end(),
                       [&](Index vertex) { return complex.relation(0, 3)[vertex].size() <= 2; });
}

void lowerSharpEdges(const CellComplex& complex, SharpEdges rule, const Marks& marks,
                     Strata& strata) {
    const std::map<Index, Sharpness> byEdge = readEdgeMarks(complex, marks);
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        const std::optional<Sharpness> mark = lookUp(byEdge, edge);
        const auto surface = surfaceFaces(strata, complex.relation(1, 2)[edge]);
        const bool onSurface = !surface.empty();
        const bool forced = onSurface && surface.size() != 2;
        if (forced && mark == Sharpness::Smooth)
            throw TopologyError(TopologyCause::BadMark, {1, edge},
                                "edge " + std::to_string(edge) + " is marked smooth, but lies in " +
                                    std::to_string(surface.size()) +
                                    " faces of the surface; a smooth edge has 2");
        const bool automatic =
            complex.dimension() == 3 && onSurface && isSharpByRule(complex, rule, edge);
        if (forced || (mark ? *mark == Sharpness::Sharp : automatic)) strata.lower({1, edge}, 1);
    }
}

void lowerVertices(const CellComplex& complex, const Marks& marks, Strata& strata) {
    const int dimension = complex.dimension();
    const std::map<Index, Sharpness> byVertex = readVertexMarks(complex, marks);
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        const std::optional<Sharpness> mark = lookUp(byVertex, vertex);
        const auto edges = complex.relation(0, 1)[vertex];
        const auto sharpCount = std::count_if(edges.begin(), edges.end(), [&](Index edge) {
            return strata.of({1, edge}) <= 1;
        });
        const bool forced =
            dimension >= 2 ? !formOneFan(complex, strata, vertex) : strata.of({0, vertex}) == 0;
        if (forced && mark == Sharpness::Smooth)
            throw TopologyError(TopologyCause::BadMark, {0, vertex},
                                "vertex " + std::to_string(vertex) + " is marked free, but " +
                                    (dimension >= 2 ? "its surface faces do not form one fan"
                                                    : "it is not between two edges"));
        const bool automatic = complex.relation(0, dimension)[vertex].size() == 1;
        if (forced || sharpCount > 2 || (mark ? *mark == Sharpness::Sharp : automatic))
            strata.lower({0, vertex}, 0);
        else if (sharpCount == 2)
            strata.lower({0, vertex}, 1);
    }
}

}  // namespace

Strata classifySharp(const CellComplex& complex, SharpEdges rule, const Marks& marks) {
    Strata strata(complex, complex.dimension());
    lowerBoundary(complex, strata);
    if (complex.dimension() >= 2) lowerSharpEdges(complex, rule, marks, strata);
    lowerVertices(complex, marks, strata);
    return strata;
}

Marks marksFor(const CellComplex& complex, const Strata& strata) {
    Marks marks;
    if (complex.dimension() >= 2) {
        const Strata automatic = classifySharp(complex, SharpEdges::SingleCell, {});
        for (Index edge = 0; edge < complex.count(1); ++edge) {
            const bool isSharp = strata.of({1, edge}) <= 1;
            if (isSharp == (automatic.of({1, edge}) <= 1)) continue;
            const auto ends = complex.relation(1, 0)[edge];
            marks.edges.push_back({{ends[0], ends[1]}, isSharp ? kInfinitelySharp : kSmooth});
        }
    }
    const Strata withEdges = classifySharp(complex, SharpEdges::SingleCell, marks);
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        const bool isCorner = strata.of({0, vertex}) == 0;
        if (isCorner != (withEdges.of({0, vertex}) == 0))
            marks.vertices.push_back({vertex, isCorner ? kInfinitelySharp : kSmooth});
    }
    return marks;
}

Strata classifyOpen(const CellComplex& complex) {
    Strata strata(complex, complex.dimension());
    lowerBoundary(complex, strata);
    return strata;
}

}  // namespace espalier::far
