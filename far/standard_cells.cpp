// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <utility>

namespace espalier::far {

namespace {

using Loop = std::vector<Index>;

/// Returns the vertex that follows b in the loop that steps from a to b.
std::optional<Index> follower(const std::vector<Loop>& loops, Index a, Index b) {
    for (const Loop& loop : loops)
        for (std::size_t i = 0; i < loop.size(); ++i)
            if (loop[i] == a && loop[(i + 1) % loop.size()] == b)
                return loop[(i + 2) % loop.size()];
    return std::nullopt;
}

/// Returns true if two loops differ only in where they start.
bool isRotation(const Loop& a, const Loop& b) {
    if (a.size() != b.size()) return false;
    const std::size_t start = std::find(b.begin(), b.end(), a[0]) - b.begin();
    if (start == b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i] != b[(start + i) % b.size()]) return false;
    return true;
}

bool haveEqualSizes(const std::vector<Loop>& a, const std::vector<Loop>& b) {
    return std::is_permutation(a.begin(), a.end(), b.begin(), b.end(),
                               [](const Loop& x, const Loop& y) { return x.size() == y.size(); });
}

/// Finds the vertices of `loops` at each position of `pattern`.
class PatternMatch {
public:
    PatternMatch(const std::vector<Loop>& pattern, const std::vector<Loop>& loops,
                 std::size_t vertexCount)
        : pattern_(pattern), loops_(loops), vertexAt_(vertexCount) {}

    std::optional<Loop> find() {
        // By symmetry, any loop of the right length can be the first one.
        const Loop& first = *std::find_if(loops_.begin(), loops_.end(), [&](const Loop& loop) {
            return loop.size() == pattern_[0].size();
        });
        for (std::size_t i = 0; i < first.size(); ++i) at(pattern_[0][i]) = first[i];
        while (step()) {
        }
        if (!isComplete()) return std::nullopt;
        Loop vertices;
        for (const auto& vertex : vertexAt_) vertices.push_back(*vertex);
        return isMatch(vertices) ? std::optional(vertices) : std::nullopt;
    }

private:
    std::optional<Index>& at(Index position) { return vertexAt_[position]; }

    /// Derives the third position of a loop from two known ones. Returns true if it found any.
    bool step() {
        bool found = false;
        for (const Loop& loop : pattern_)
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const auto a = at(loop[i]);
                const auto b = at(loop[(i + 1) % loop.size()]);
                auto& c = at(loop[(i + 2) % loop.size()]);
                if (!a || !b || c) continue;
                c = follower(loops_, *a, *b);
                found = found || c;
            }
        return found;
    }

    bool isComplete() const {
        return std::all_of(vertexAt_.begin(), vertexAt_.end(),
                           [](const auto& vertex) { return vertex.has_value(); });
    }

    bool isMatch(const Loop& vertices) const {
        Loop sorted = vertices;
        std::sort(sorted.begin(), sorted.end());
        if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return false;
        return std::all_of(pattern_.begin(), pattern_.end(), [&](Loop loop) {
            for (Index& vertex : loop) vertex = vertices[vertex];
            return std::any_of(loops_.begin(), loops_.end(),
                               [&](const Loop& other) { return isRotation(loop, other); });
        });
    }

    const std::vector<Loop>& pattern_;
    const std::vector<Loop>& loops_;
    std::vector<std::optional<Index>> vertexAt_;
};

using Quadrilateral = std::array<Index, 4>;

/// A quadrilateral that shares an edge with another one, the base.
struct BaseSide {
    std::size_t edge = 0;   ///< the shared edge: from corner `edge` of the base to the next corner
    Index aboveFirst = 0;   ///< the vertex above the first of these corners
    Index aboveSecond = 0;  ///< the vertex above the second
};

/// Returns the first edge of the base that a face contains, in either direction; nothing if there
/// is none.
std::optional<BaseSide> sideOn(const Quadrilateral& base, std::span<const Index> face) {
    for (std::size_t edge = 0; edge < 4; ++edge)
        for (std::size_t i = 0; i < 4; ++i) {
            if (face[i] != base[edge]) continue;
            const Index after = face[(i + 1) % 4], across = face[(i + 2) % 4],
                        before = face[(i + 3) % 4];
            if (after == base[(edge + 1) % 4]) return BaseSide{edge, before, across};
            if (before == base[(edge + 1) % 4]) return BaseSide{edge, after, across};
        }
    return std::nullopt;
}

}  // namespace

Index vertexCount(StandardCell cell) {
    constexpr Index kCounts[] = {4, 5, 6, 8};
    return kCounts[static_cast<std::size_t>(cell)];
}

const std::vector<std::vector<Index>>& faceLoops(StandardCell cell) {
    static const std::vector<std::vector<Index>> kLoops[] = {
        {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}},
        {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}},
        {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}},
        {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};
    return kLoops[static_cast<std::size_t>(cell)];
}

std::vector<std::vector<Index>> outwardLoops(const CellComplex& complex, CellId cell) {
    const auto faces = complex.relation(3, 2)[cell.value];
    const auto signs = complex.boundary(3).signs(cell.value);
    std::vector<std::vector<Index>> loops;
    loops.reserve(faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const auto loop = complex.relation(2, 0)[faces[i]];
        if (signs[i] > 0)
            loops.emplace_back(loop.begin(), loop.end());
        else
            loops.emplace_back(loop.rbegin(), loop.rend());
    }
    return loops;
}

std::optional<StandardCellVertices> asStandardCell(const CellComplex& complex, CellId cell) {
    if (const auto h = hexahedronVertices(complex, cell)) {
        // The first loop of the pattern is 0, 4, 7, 3. It begins where the outward loop of the
        // cell's first face begins; if the face is directed inwards, that is the loop's last
        // vertex.
        const std::size_t a = complex.boundary(3).signs(cell.value)[0] > 0 ? 0 : 3;
        const std::size_t b = (a + 1) % 4, c = (a + 2) % 4, d = (a + 3) % 4;
        const auto& v = *h;
        return StandardCellVertices{
            StandardCell::Hexahedron,
            {v[a], v[a + 4], v[b + 4], v[b], v[d], v[d + 4], v[c + 4], v[c]}};
    }
    const std::vector<Loop> loops = outwardLoops(complex, cell);
    for (const StandardCell kind :
         {StandardCell::Tetrahedron, StandardCell::Pyramid, StandardCell::Wedge}) {
        const auto& pattern = faceLoops(kind);
        const std::size_t count = vertexCount(kind);
        if (!haveEqualSizes(pattern, loops)) continue;
        if (auto vertices = PatternMatch(pattern, loops, count).find())
            return StandardCellVertices{kind, std::move(*vertices)};
    }
    return std::nullopt;
}

namespace {

/// Returns the vertices of a hexahedron of a refined lattice. The result is that of
/// hexahedronVertices(), which takes four times as long.
///
/// The hexahedron is a cell [v, c] with three edges and three faces f between v and c. Its first
/// three faces have the loops v, e, f, e'; each edge is in two of them. The loops of the other
/// faces pass c at their third corner.
std::array<Index, 8> refinedHexahedronVertices(std::span<const Index> faces, const Incidence& loops,
                                               bool isOutward) {
    const auto base = loops[faces[0]], second = loops[faces[1]], third = loops[faces[2]];
    const Index v = base[0], f = base[2], c = loops[faces[3]][2];
    const Index left = base[isOutward ? 3 : 1], right = base[isOutward ? 1 : 3];
    // The second and the third face have the third edge; the other edge tells which face is where.
    const bool isSecondLeft = second[1] == left || second[3] == left;
    const auto atLeft = isSecondLeft ? second : third, atRight = isSecondLeft ? third : second;
    const Index above = atLeft[atLeft[1] == left ? 3 : 1];
    return {v, left, f, right, above, atLeft[2], c, atRight[2]};
}

}  // namespace

std::optional<std::array<Index, 8>> hexahedronVertices(const CellComplex& complex, CellId cell) {
    const auto faces = complex.relation(3, 2)[cell.value];
    const Incidence& loops = complex.relation(2, 0);
    if (complex.isRefined() && faces.size() == 6)
        return refinedHexahedronVertices(faces, loops,
                                         complex.boundary(3).signs(cell.value)[0] > 0);
    if (faces.size() != 6 || std::any_of(faces.begin(), faces.end(),
                                         [&](Index face) { return loops[face].size() != 4; }))
        return std::nullopt;

    Quadrilateral base;
    std::copy_n(loops[faces[0]].begin(), 4, base.begin());
    // The loop must run anticlockwise seen from inside.
    if (complex.boundary(3).signs(cell.value)[0] > 0) std::swap(base[1], base[3]);
    // Four of the five other faces each share an edge with the base, and the fifth shares none.
    std::array<std::optional<BaseSide>, 4> sides;
    std::optional<Index> opposite;
    for (const Index face : faces.subspan(1)) {
        const auto side = sideOn(base, loops[face]);
        if (side ? sides[side->edge].has_value() : opposite.has_value()) return std::nullopt;
        if (side)
            sides[side->edge] = side;
        else
            opposite = face;
    }
    Quadrilateral top;
    for (std::size_t i = 0; i < 4; ++i) {
        top[i] = sides[i]->aboveFirst;
        if (sides[(i + 3) % 4]->aboveSecond != top[i] || contains(base, top[i]))
            return std::nullopt;
    }
    if (!std::is_permutation(top.begin(), top.end(), loops[*opposite].begin())) return std::nullopt;
    return std::array{base[0], base[1], base[2], base[3], top[0], top[1], top[2], top[3]};
}

}  // namespace espalier::far
