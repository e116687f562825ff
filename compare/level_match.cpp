// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "level_match.h"

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

namespace {

namespace Far = OpenSubdiv::Far;

LevelMatch emptyMatch(const far::CellComplex& complex) {
    LevelMatch match;
    for (int d = 0; d <= 2; ++d) match.numbers[d].resize(complex.count(d));
    return match;
}

bool contains(Far::ConstIndexArray row, Index value) {
    return std::find(row.begin(), row.end(), value) != row.end();
}

/// For each corner and edge of our face, the corner and edge of the matching face. Side i of a loop
/// runs from corner i to corner i + 1.
struct FaceAlignment {
    std::vector<std::size_t> corners, sides;
};

/// Aligns our face with OpenSubdiv's, corner by corner.
FaceAlignment align(const far::CellComplex& complex, Index face, const LevelMatch& match,
                    Far::ConstIndexArray openSubdivLoop) {
    const auto ours = complex.relation(2, 0)[face];
    const std::size_t n = ours.size();
    const bool isReversed = isWoundInward(complex, face);
    FaceAlignment alignment{std::vector<std::size_t>(n), std::vector<std::size_t>(n)};
    for (std::size_t start = 0; start < n; ++start) {
        bool fits = true;
        for (std::size_t i = 0; i < n && fits; ++i) {
            alignment.corners[i] = (start + (isReversed ? n - i : i)) % n;
            alignment.sides[i] =
                isReversed ? (alignment.corners[i] + n - 1) % n : alignment.corners[i];
            fits = match.of({0, ours[i]}) == openSubdivLoop[static_cast<int>(alignment.corners[i])];
        }
        if (fits) break;
    }
    return alignment;
}

}  // namespace

LevelMatch matchBase(const far::CellComplex& complex, const Surface& surface,
                     const Far::TopologyLevel& openSubdiv) {
    LevelMatch match = emptyMatch(complex);
    for (std::size_t i = 0; i < surface.vertices.size(); ++i)
        match.numbers[0][surface.vertices[i]] = static_cast<Index>(i);
    for (std::size_t i = 0; i < surface.faces.size(); ++i)
        match.numbers[2][surface.faces[i]] = static_cast<Index>(i);
    // Match edges as sides of faces, because several edges may have the same two ends.
    for (const Index face : surface.faces) {
        const Index openSubdivFace = *match.of({2, face});
        const FaceAlignment alignment =
            align(complex, face, match, openSubdiv.GetFaceVertices(openSubdivFace));
        const auto edges = complex.relation(2, 1)[face];
        for (std::size_t i = 0; i < edges.size(); ++i)
            match.numbers[1][edges[i]] =
                openSubdiv.GetFaceEdges(openSubdivFace)[static_cast<int>(alignment.sides[i])];
    }
    return match;
}

LevelMatch matchChildren(const far::CellComplex& parent, const LevelMatch& match,
                         const far::Refinement& refinement,
                         const Far::TopologyLevel& openSubdivParent) {
    LevelMatch result = emptyMatch(refinement.child());
    // Children of one kind are ordered by their upper end. Children with the same upper end (a
    // family) have the order of `lowerEnds`, in which refinement may have left out some entities.
    std::pair<int, Entity> family;
    std::span<const Index> lowerEnds;
    std::size_t next = 0;
    FaceAlignment alignment;
    refinement.forEachChild([&](Entity child, const far::Interval& interval) {
        const auto& [lower, upper] = interval;
        if (upper.dimension > 2) return;
        const std::optional<Index> whole = match.of(upper);
        if (!whole) return;
        if (lowerEnds.empty() || family != std::pair(child.dimension, upper)) {
            family = {child.dimension, upper};
            lowerEnds = parent.relation(upper.dimension, lower.dimension)[upper.index];
            next = 0;
            if (upper.dimension == 2 && child.dimension > 0)
                alignment =
                    align(parent, upper.index, match, openSubdivParent.GetFaceVertices(*whole));
        }
        while (lowerEnds[next] != lower.index) ++next;
        const std::size_t position = next++;

        Index number = Far::INDEX_INVALID;
        if (child.dimension == 0) {
            number = upper.dimension == 0   ? openSubdivParent.GetVertexChildVertex(*whole)
                     : upper.dimension == 1 ? openSubdivParent.GetEdgeChildVertex(*whole)
                                            : openSubdivParent.GetFaceChildVertex(*whole);
        } else if (child.dimension == 2) {
            number = openSubdivParent.GetFaceChildFaces(
                *whole)[static_cast<int>(alignment.corners[position])];
        } else if (upper.dimension == 2) {
            number = openSubdivParent.GetFaceChildEdges(
                *whole)[static_cast<int>(alignment.sides[position])];
        } else {
            const bool isReversed =
                match.of({0, lowerEnds[0]}) != openSubdivParent.GetEdgeVertices(*whole)[0];
            number = openSubdivParent.GetEdgeChildEdges(
                *whole)[static_cast<int>(isReversed ? 1 - position : position)];
        }
        if (Far::IndexIsValid(number)) result.numbers[child.dimension][child.index] = number;
    });
    return result;
}

Surface comparedRegion(const far::TopologyRefiner& refiner, int level, const LevelMatch& match,
                       const Far::TopologyLevel& openSubdiv) {
    const far::CellComplex& complex = refiner.level(level).complex;
    Surface surface = surfaceOf(complex);
    if (refiner.boundary() != far::Boundary::Open) return surface;
    std::array<std::vector<char>, 2> isKept = {std::vector<char>(complex.count(0), 0),
                                               std::vector<char>(complex.count(1), 0)};
    std::erase_if(surface.faces, [&](Index face) {
        const std::optional<Index> openSubdivFace = match.of({2, face});
        return !openSubdivFace || openSubdiv.IsFaceHole(*openSubdivFace);
    });
    for (const Index face : surface.faces)
        for (int d = 0; d < 2; ++d)
            for (const Index part : complex.relation(2, d)[face]) isKept[d][part] = 1;
    std::erase_if(surface.vertices, [&](Index vertex) { return !isKept[0][vertex]; });
    std::erase_if(surface.edges, [&](Index edge) { return !isKept[1][edge]; });
    return surface;
}

std::array<Index, 3> countOpenSubdiv(far::Boundary boundary, const Far::TopologyLevel& openSubdiv) {
    if (boundary != far::Boundary::Open)
        return {openSubdiv.GetNumVertices(), openSubdiv.GetNumEdges(), openSubdiv.GetNumFaces()};
    std::vector<char> vertices(openSubdiv.GetNumVertices(), 0), edges(openSubdiv.GetNumEdges(), 0);
    std::array<Index, 3> counts = {};
    for (Index face = 0; face < openSubdiv.GetNumFaces(); ++face) {
        if (openSubdiv.IsFaceHole(face)) continue;
        ++counts[2];
        for (const Index vertex : openSubdiv.GetFaceVertices(face)) vertices[vertex] = 1;
        for (const Index edge : openSubdiv.GetFaceEdges(face)) edges[edge] = 1;
    }
    counts[0] = static_cast<Index>(std::count(vertices.begin(), vertices.end(), 1));
    counts[1] = static_cast<Index>(std::count(edges.begin(), edges.end(), 1));
    return counts;
}

namespace {

/// Finds the first difference between a level and its match.
class Inspector {
public:
    Inspector(const far::TopologyRefiner& refiner, int level, const LevelMatch& match,
              const Far::TopologyLevel& openSubdiv)
        : level_(refiner.level(level)),
          isOpen_(refiner.boundary() == far::Boundary::Open),
          match_(match),
          openSubdiv_(openSubdiv) {}

    std::string inspect(const Surface& region) const {
        const std::array<std::span<const Index>, 3> entities = {region.vertices, region.edges,
                                                                region.faces};
        for (int d = 0; d <= 2; ++d) {
            std::vector<char> isTaken(d == 0   ? openSubdiv_.GetNumVertices()
                                      : d == 1 ? openSubdiv_.GetNumEdges()
                                               : openSubdiv_.GetNumFaces(),
                                      0);
            for (const Index index : entities[d]) {
                const std::optional<Index> match = match_.of({d, index});
                if (!match) return name({d, index}) + " has no match in OpenSubdiv's level";
                if (isTaken[*match]++)
                    return concat(name({d, index}),
                                  " has the same match in OpenSubdiv's level as another one, ",
                                  *match);
            }
        }
        // Under Boundary::Open, the region does not contain OpenSubdiv's holes. Each of our holes
        // must be one of OpenSubdiv's holes.
        if (isOpen_)
            for (const Index hole : level_.holes) {
                const std::optional<Index> match = match_.of({2, hole});
                if (match && !openSubdiv_.IsFaceHole(*match))
                    return name({2, hole}) + " is a hole; in OpenSubdiv it is not";
            }
        // Inspect faces first: if a face has other vertices, the message must say so, rather than
        // name the sharpness of a vertex.
        for (int d = 2; d >= 0; --d)
            for (const Index index : entities[d]) {
                const std::string text = d == 0   ? inspectVertex(index)
                                         : d == 1 ? inspectEdge(index)
                                                  : inspectFace(index);
                if (!text.empty())
                    return concat(name({d, index}), " (OpenSubdiv: ", *match_.of({d, index}), ") ",
                                  text);
            }
        return {};
    }

private:
    static std::string name(Entity entity) {
        return concat(dimensionName(entity.dimension), " ", entity.index);
    }

    /// Returns the sharpness as OpenSubdiv stores it, where infinite is 10.
    float sharpness(Entity entity) const {
        return std::min(level_.strata.sharpness(entity), static_cast<float>(far::kLeastInfinite));
    }

    /// Allows for rounding: the sum of three or more semi-sharp values depends on the order of
    /// summation (marks.h).
    static bool isSameSharpness(float ours, float openSubdiv) {
        constexpr float kRounding = 8 * std::numeric_limits<float>::epsilon();
        return std::abs(ours - openSubdiv) <= kRounding * std::max(ours, openSubdiv);
    }

    static std::string differ(float ours, float openSubdiv) {
        std::ostringstream text;
        text.precision(std::numeric_limits<float>::max_digits10);
        text << "has sharpness " << ours << "; in OpenSubdiv " << openSubdiv;
        return text.str();
    }

    /// The text for each stratum.
    static constexpr std::array kPlaces = {"at a corner", "on a sharp edge",
                                           "on the smooth surface", "inside"};

    std::string inspectVertex(Index vertex) const {
        using Rule = OpenSubdiv::Sdc::Crease::Rule;
        const Entity entity{0, vertex};
        if (level_.strata.isOpen(entity)) return {};
        const Index match = *match_.of(entity);
        if (!isSameSharpness(sharpness(entity), openSubdiv_.GetVertexSharpness(match)))
            return differ(sharpness(entity), openSubdiv_.GetVertexSharpness(match));
        const Rule rule = openSubdiv_.GetVertexRule(match);
        const int stratum = rule == Rule::RULE_CORNER ? 0 : rule == Rule::RULE_CREASE ? 1 : 2;
        if (level_.strata.of(entity) != stratum)
            return concat("lies ", kPlaces[level_.strata.of(entity)], "; in OpenSubdiv ",
                          kPlaces[stratum]);
        return {};
    }

    std::string inspectEdge(Index edge) const {
        const Entity entity{1, edge};
        const Index match = *match_.of(entity);
        for (const Index end : level_.complex.relation(1, 0)[edge])
            if (!contains(openSubdiv_.GetEdgeVertices(match), *match_.of({0, end})))
                return concat("ends in vertex ", end, "; in OpenSubdiv it does not");
        if (!level_.strata.isOpen(entity) &&
            !isSameSharpness(sharpness(entity), openSubdiv_.GetEdgeSharpness(match)))
            return differ(sharpness(entity), openSubdiv_.GetEdgeSharpness(match));
        return {};
    }

    std::string inspectFace(Index face) const {
        const Index match = *match_.of({2, face});
        std::vector<Index> loop = surfaceLoop(level_.complex, face);
        for (Index& vertex : loop) vertex = *match_.of({0, vertex});
        const Far::ConstIndexArray openSubdivLoop = openSubdiv_.GetFaceVertices(match);
        // The loops must be the same cycle, with any start.
        std::size_t turns = 0;
        while (turns < loop.size() && !std::equal(loop.begin(), loop.end(), openSubdivLoop.begin(),
                                                  openSubdivLoop.end())) {
            std::rotate(loop.begin(), loop.begin() + 1, loop.end());
            ++turns;
        }
        if (turns == loop.size())
            return "has other vertices than in OpenSubdiv, or in another order";
        const bool isHole = std::binary_search(level_.holes.begin(), level_.holes.end(), face);
        if (!isOpen_ && isHole != openSubdiv_.IsFaceHole(match))
            return isHole ? "is a hole; in OpenSubdiv it is not"
                          : "is not a hole; in OpenSubdiv it is";
        return {};
    }

    const far::Level& level_;
    bool isOpen_;
    const LevelMatch& match_;
    const Far::TopologyLevel& openSubdiv_;
};

}  // namespace

std::string describeDifference(const far::TopologyRefiner& refiner, int level,
                               const Surface& region, const LevelMatch& match,
                               const Far::TopologyLevel& openSubdiv) {
    return Inspector(refiner, level, match, openSubdiv).inspect(region);
}

}  // namespace espalier::compare
