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
    for (int d = 0; d <= 2; ++d) match.theirs[d].resize(complex.count(d));
    return match;
}

bool contains(Far::ConstIndexArray row, Index value) {
    return std::find(row.begin(), row.end(), value) != row.end();
}

/// Which corner and which edge of their face stands for each of ours. Side i of a loop runs from
/// corner i to corner i + 1.
struct FaceAlignment {
    std::vector<std::size_t> corners, sides;
};

/// Lays our face on theirs, corner on corner.
FaceAlignment align(const far::CellComplex& complex, Index face, const LevelMatch& match,
                    Far::ConstIndexArray theirLoop) {
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
            fits = match.of({0, ours[i]}) == theirLoop[static_cast<int>(alignment.corners[i])];
        }
        if (fits) break;
    }
    return alignment;
}

}  // namespace

LevelMatch matchBase(const far::CellComplex& complex, const Surface& surface,
                     const Far::TopologyLevel& theirs) {
    LevelMatch match = emptyMatch(complex);
    for (std::size_t i = 0; i < surface.vertices.size(); ++i)
        match.theirs[0][surface.vertices[i]] = static_cast<Index>(i);
    for (std::size_t i = 0; i < surface.faces.size(); ++i)
        match.theirs[2][surface.faces[i]] = static_cast<Index>(i);
    // Edges as the sides of faces: their ends may not tell them apart.
    for (const Index face : surface.faces) {
        const Index theirFace = *match.of({2, face});
        const FaceAlignment alignment =
            align(complex, face, match, theirs.GetFaceVertices(theirFace));
        const auto edges = complex.relation(2, 1)[face];
        for (std::size_t i = 0; i < edges.size(); ++i)
            match.theirs[1][edges[i]] =
                theirs.GetFaceEdges(theirFace)[static_cast<int>(alignment.sides[i])];
    }
    return match;
}

LevelMatch matchChildren(const far::CellComplex& parent, const LevelMatch& match,
                         const far::Refinement& refinement, const Far::TopologyLevel& theirParent) {
    LevelMatch result = emptyMatch(refinement.child());
    // Children come by upper end, and in it by the position of the lower one. Of the latter some
    // may have been left out.
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
                alignment = align(parent, upper.index, match, theirParent.GetFaceVertices(*whole));
        }
        while (lowerEnds[next] != lower.index) ++next;
        const std::size_t position = next++;

        Index theirs = Far::INDEX_INVALID;
        if (child.dimension == 0) {
            theirs = upper.dimension == 0   ? theirParent.GetVertexChildVertex(*whole)
                     : upper.dimension == 1 ? theirParent.GetEdgeChildVertex(*whole)
                                            : theirParent.GetFaceChildVertex(*whole);
        } else if (child.dimension == 2) {
            theirs = theirParent.GetFaceChildFaces(
                *whole)[static_cast<int>(alignment.corners[position])];
        } else if (upper.dimension == 2) {
            theirs =
                theirParent.GetFaceChildEdges(*whole)[static_cast<int>(alignment.sides[position])];
        } else {
            const bool isReversed =
                match.of({0, lowerEnds[0]}) != theirParent.GetEdgeVertices(*whole)[0];
            theirs = theirParent.GetEdgeChildEdges(
                *whole)[static_cast<int>(isReversed ? 1 - position : position)];
        }
        if (Far::IndexIsValid(theirs)) result.theirs[child.dimension][child.index] = theirs;
    });
    return result;
}

Surface comparedRegion(const far::TopologyRefiner& refiner, int level, const LevelMatch& match,
                       const Far::TopologyLevel& theirs) {
    const far::CellComplex& complex = refiner.level(level).complex;
    Surface surface = surfaceOf(complex);
    if (refiner.boundary() != far::Boundary::Open) return surface;
    std::array<std::vector<char>, 2> isKept = {std::vector<char>(complex.count(0), 0),
                                               std::vector<char>(complex.count(1), 0)};
    std::erase_if(surface.faces, [&](Index face) {
        const std::optional<Index> theirFace = match.of({2, face});
        return !theirFace || theirs.IsFaceHole(*theirFace);
    });
    for (const Index face : surface.faces)
        for (int d = 0; d < 2; ++d)
            for (const Index part : complex.relation(2, d)[face]) isKept[d][part] = 1;
    std::erase_if(surface.vertices, [&](Index vertex) { return !isKept[0][vertex]; });
    std::erase_if(surface.edges, [&](Index edge) { return !isKept[1][edge]; });
    return surface;
}

std::array<Index, 3> countTheirs(far::Boundary boundary, const Far::TopologyLevel& theirs) {
    if (boundary != far::Boundary::Open)
        return {theirs.GetNumVertices(), theirs.GetNumEdges(), theirs.GetNumFaces()};
    std::vector<char> vertices(theirs.GetNumVertices(), 0), edges(theirs.GetNumEdges(), 0);
    std::array<Index, 3> counts = {};
    for (Index face = 0; face < theirs.GetNumFaces(); ++face) {
        if (theirs.IsFaceHole(face)) continue;
        ++counts[2];
        for (const Index vertex : theirs.GetFaceVertices(face)) vertices[vertex] = 1;
        for (const Index edge : theirs.GetFaceEdges(face)) edges[edge] = 1;
    }
    counts[0] = static_cast<Index>(std::count(vertices.begin(), vertices.end(), 1));
    counts[1] = static_cast<Index>(std::count(edges.begin(), edges.end(), 1));
    return counts;
}

namespace {

/// Looks for differences between a level and its match.
class Inspector {
public:
    Inspector(const far::TopologyRefiner& refiner, int level, const LevelMatch& match,
              const Far::TopologyLevel& theirs)
        : level_(refiner.level(level)),
          isOpen_(refiner.boundary() == far::Boundary::Open),
          match_(match),
          theirs_(theirs) {}

    std::string inspect(const Surface& region) const {
        const std::array<std::span<const Index>, 3> entities = {region.vertices, region.edges,
                                                                region.faces};
        for (int d = 0; d <= 2; ++d) {
            std::vector<char> isTaken(d == 0   ? theirs_.GetNumVertices()
                                      : d == 1 ? theirs_.GetNumEdges()
                                               : theirs_.GetNumFaces(),
                                      0);
            for (const Index index : entities[d]) {
                const std::optional<Index> theirs = match_.of({d, index});
                if (!theirs) return name({d, index}) + " has no match in OpenSubdiv's level";
                if (isTaken[*theirs]++)
                    return concat(name({d, index}),
                                  " has the same match in OpenSubdiv's level as another one, ",
                                  *theirs);
            }
        }
        // OpenSubdiv's holes without boundary control are not in the region; ours must be among
        // them.
        if (isOpen_)
            for (const Index hole : level_.holes) {
                const std::optional<Index> theirs = match_.of({2, hole});
                if (theirs && !theirs_.IsFaceHole(*theirs))
                    return name({2, hole}) + " is a hole; in OpenSubdiv it is not";
            }
        // Faces first: what differs in their vertices need not be told of the latter's features.
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

    /// Sharpness as OpenSubdiv has it, where infinite is 10.
    float sharpness(Entity entity) const {
        return std::min(level_.strata.sharpness(entity), static_cast<float>(far::kLeastInfinite));
    }

    /// Sums of three or more semi-sharp values are rounded as their order has it (marks.h):
    /// that is not a difference of features.
    static bool isSameSharpness(float ours, float theirs) {
        constexpr float kRounding = 8 * std::numeric_limits<float>::epsilon();
        return std::abs(ours - theirs) <= kRounding * std::max(ours, theirs);
    }

    static std::string differ(float ours, float theirs) {
        std::ostringstream text;
        text.precision(std::numeric_limits<float>::max_digits10);
        text << "has sharpness " << ours << "; in OpenSubdiv " << theirs;
        return text.str();
    }

    /// By stratum.
    static constexpr std::array kPlaces = {"at a corner", "on a sharp edge",
                                           "on the smooth surface", "inside"};

    std::string inspectVertex(Index vertex) const {
        using Rule = OpenSubdiv::Sdc::Crease::Rule;
        const Entity entity{0, vertex};
        if (level_.strata.isOpen(entity)) return {};
        const Index theirs = *match_.of(entity);
        if (!isSameSharpness(sharpness(entity), theirs_.GetVertexSharpness(theirs)))
            return differ(sharpness(entity), theirs_.GetVertexSharpness(theirs));
        const Rule rule = theirs_.GetVertexRule(theirs);
        const int stratum = rule == Rule::RULE_CORNER ? 0 : rule == Rule::RULE_CREASE ? 1 : 2;
        if (level_.strata.of(entity) != stratum)
            return concat("lies ", kPlaces[level_.strata.of(entity)], "; in OpenSubdiv ",
                          kPlaces[stratum]);
        return {};
    }

    std::string inspectEdge(Index edge) const {
        const Entity entity{1, edge};
        const Index theirs = *match_.of(entity);
        for (const Index end : level_.complex.relation(1, 0)[edge])
            if (!contains(theirs_.GetEdgeVertices(theirs), *match_.of({0, end})))
                return concat("ends in vertex ", end, "; in OpenSubdiv it does not");
        if (!level_.strata.isOpen(entity) &&
            !isSameSharpness(sharpness(entity), theirs_.GetEdgeSharpness(theirs)))
            return differ(sharpness(entity), theirs_.GetEdgeSharpness(theirs));
        return {};
    }

    std::string inspectFace(Index face) const {
        const Index theirs = *match_.of({2, face});
        std::vector<Index> loop = surfaceLoop(level_.complex, face);
        for (Index& vertex : loop) vertex = *match_.of({0, vertex});
        const Far::ConstIndexArray theirLoop = theirs_.GetFaceVertices(theirs);
        // The same cycle, wherever it starts.
        std::size_t turns = 0;
        while (turns < loop.size() &&
               !std::equal(loop.begin(), loop.end(), theirLoop.begin(), theirLoop.end())) {
            std::rotate(loop.begin(), loop.begin() + 1, loop.end());
            ++turns;
        }
        if (turns == loop.size())
            return "has other vertices than in OpenSubdiv, or in another order";
        const bool isHole = std::binary_search(level_.holes.begin(), level_.holes.end(), face);
        if (!isOpen_ && isHole != theirs_.IsFaceHole(theirs))
            return isHole ? "is a hole; in OpenSubdiv it is not"
                          : "is not a hole; in OpenSubdiv it is";
        return {};
    }

    const far::Level& level_;
    bool isOpen_;
    const LevelMatch& match_;
    const Far::TopologyLevel& theirs_;
};

}  // namespace

std::string describeDifference(const far::TopologyRefiner& refiner, int level,
                               const Surface& region, const LevelMatch& match,
                               const Far::TopologyLevel& theirs) {
    return Inspector(refiner, level, match, theirs).inspect(region);
}

}  // namespace espalier::compare
