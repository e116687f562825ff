// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/refinement.h>
#include <espalier/far/topology_error.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>

namespace espalier::far {
namespace {

/// Returns the position of a value in an ascending row that contains it.
Index placeInRow(std::span<const Index> row, Index value) {
    // Short rows are scanned without a branch: a hexahedron has 12 edges and 8 vertices.
    constexpr std::size_t kShort = 16;
    if (row.size() > kShort)
        return static_cast<Index>(std::lower_bound(row.begin(), row.end(), value) - row.begin());
    Index less = 0;
    for (const Index other : row) less += other < value;
    return less;
}

/// Finds the corners of the faces of a cell among the vertices and edges of the cell.
class CornerPlaces {
public:
    /// \param lattice must outlive this object
    explicit CornerPlaces(const CellComplex& lattice)
        : isRefined_(lattice.isRefined()),
          cellFaces_(lattice.relation(3, 2)),
          faceEdges_(lattice.relation(2, 1)),
          faceVertices_(lattice.relation(2, 0)),
          cellVertices_(lattice.relation(3, 0)),
          cellEdges_(lattice.relation(3, 1)) {}

    /// Finds the places for a cell. \cost O(n log n) in the faces of the cell
    void find(Index cell) {
        if (isRefined_ && cellFaces_[cell].size() == 6) return findInHexahedron(cellFaces_[cell]);
        vertices_.clear();
        edges_.clear();
        for (const Index face : cellFaces_[cell]) {
            for (const Index vertex : faceVertices_[face])
                vertices_.push_back(placeInRow(cellVertices_[cell], vertex));
            for (const Index edge : faceEdges_[face])
                edges_.push_back(placeInRow(cellEdges_[cell], edge));
        }
    }

    /// For each corner of each face, in the order of the loops, its position in cell → vertices.
    const Index* vertices() const { return vertices_.data(); }

    /// For each corner, the position in cell → edges of the edge along which the loop leaves it.
    const Index* edges() const { return edges_.data(); }

private:
    /// Finds the places in a hexahedron of a refined lattice in a closed form, several times as
    /// fast. Nearly all cells of a refined lattice are such hexahedra.
    ///
    /// The hexahedron is a cell [v, c] with three edges e and three faces f between v and c. Its
    /// vertices are v, the points of e₀, e₁ and e₂, the points of the faces in ascending order, and
    /// c. Its faces [v, f_i] have the loops v, e_p, f_i, e_q; its faces [e_j, c] have the loops
    /// e_j, f_x, c, f_y. Its edges are the edges [v, e_j], then the edges [e, f], in the order of
    /// the faces and for each face by number, then the edges [f_i, c].
    void findInHexahedron(std::span<const Index> faces) {
        vertices_.resize(24);
        edges_.resize(24);
        std::array<const Index*, 6> loops;
        for (std::size_t face = 0; face < 6; ++face)
            loops[face] = faceVertices_[faces[face]].data();
        const auto edgeNamed = [&](Index point) {
            return point == loops[3][0] ? 0 : point == loops[4][0] ? 1 : 2;
        };
        const auto faceNamed = [&](Index point) {
            return point == loops[0][2] ? 0 : point == loops[1][2] ? 1 : 2;
        };
        std::array<Index, 3> rank;                   // rank of the point of f_i among the three
        std::array<std::array<Index, 3>, 3> edgeOf;  // [i][j] is the place of [e_j, f_i]
        const auto set = [&](std::size_t face, const std::array<Index, 4>& vertices,
                             const std::array<Index, 4>& edges) {
            std::copy(vertices.begin(), vertices.end(), vertices_.begin() + 4 * face);
            std::copy(edges.begin(), edges.end(), edges_.begin() + 4 * face);
        };
        for (std::size_t i = 0; i < 3; ++i) {
            const Index point = loops[i][2];
            rank[i] = (loops[0][2] < point) + (loops[1][2] < point) + (loops[2][2] < point);
            const Index p = edgeNamed(loops[i][1]), q = edgeNamed(loops[i][3]);
            const std::span<const Index> loopEdges = faceEdges_[faces[i]];
            const Index isSecond = loopEdges[1] > loopEdges[2] ? 1 : 0;
            edgeOf[i][p] = 3 + 2 * rank[i] + isSecond;
            edgeOf[i][q] = 3 + 2 * rank[i] + 1 - isSecond;
            set(i, {0, 1 + p, 4 + rank[i], 1 + q}, {p, edgeOf[i][p], edgeOf[i][q], q});
        }
        for (Index j = 0; j < 3; ++j) {
            const Index x = faceNamed(loops[3 + j][1]), y = faceNamed(loops[3 + j][3]);
            set(3 + j, {1 + j, 4 + rank[x], 7, 4 + rank[y]},
                {edgeOf[x][j], 9 + x, 9 + y, edgeOf[y][j]});
        }
    }

    bool isRefined_;
    const Incidence& cellFaces_;
    const Incidence& faceEdges_;
    const Incidence& faceVertices_;
    const Incidence& cellVertices_;
    const Incidence& cellEdges_;
    std::vector<Index> vertices_, edges_;
};

/// An edge of a cell, and the first of its two faces.
struct EdgeOfCell {
    struct Face {
        Offset edgeInFace = 0;       ///< position of the edge in face → edges
        Offset inCell = -1;          ///< position of the face in cell → faces; −1: none yet
        std::int8_t edgeSign = 0;    ///< the sign of the edge in the boundary of the face
        std::int8_t inCellSign = 0;  ///< the sign of the face in the boundary of the cell
    };
    Face first = {};
    Index tail = 0, head = 0;  ///< positions in cell → vertices
};

}  // namespace

// With σ(x, y) the incidence number of y in the boundary of x, and d = dim b − dim a,
//
//     ∂[a,b] = Σ σ(b,b') [a,b']  +  (−1)^d Σ σ(a',a) [a',b]
//
// over the entities b' and a' inside [a,b], with dim b' = dim b − 1 and dim a' = dim a + 1. The
// sign (−1)^d makes the mixed terms of ∂∂ cancel. So a coherently oriented parent has a coherently
// oriented child, and [v,c] has the orientation of c.

/// The rows of the child's faces.
struct Refinement::Quadrilaterals {
    Array<Index> edges;
    Array<std::int8_t> signs;

    void set(Index face, const std::array<Signed, 4>& row) {
        std::size_t at = Offset{4} * face;
        for (const Signed& edge : row) {
            edges[at] = edge.index;
            signs[at++] = edge.sign;
        }
    }
};

namespace {

constexpr Offset kGrain = 4096;

std::int8_t opposite(std::int8_t sign) {
    return static_cast<std::int8_t>(-sign);
}

}  // namespace

Refinement::Refinement(const CellComplex& parent, const Kept* kept)
    : parent_(parent), dimension_(parent.dimension()) {
    numberChildren(kept);
    if (childCounts_[dimension_] == 0)
        throw TopologyError(TopologyCause::EmptyComplex, {dimension_, 0},
                            std::string("the boundary mode 'open' leaves no ") +
                                dimensionName(dimension_) +
                                " to refine: the complex has no interior vertex");
    requireMemory(leastBytes(), "the refined complex");
    CellComplex::Boundaries boundaries;
    withWhole([&](auto isWhole) {
        boundaries[0] = childEdges<isWhole>();
        if (dimension_ == 1) return;
        Quadrilaterals faces;
        faces.edges.resize(Offset{4} * childCounts_[2]);
        faces.signs.resize(faces.edges.size());
        addCorners<isWhole>(faces);
        if (dimension_ > 2) boundaries[2] = addSides<isWhole>(faces);
        boundaries[1] =
            SignedIncidence(Incidence::uniform(4, std::move(faces.edges)), std::move(faces.signs));
    });
    child_ = CellComplex::refined(dimension_, childCounts_[0], std::move(boundaries));
}

void Refinement::numberChildren(const Kept* kept) {
    for (int d = 0; d <= dimension_; ++d) {
        Offset count = 0;
        for (int lower = 0; lower + d <= dimension_; ++lower) {
            Family& family = families_[lower][lower + d];
            family.parts = &parent_.relation(lower + d, lower);
            if (kept != nullptr) family.drop(kept->lower[lower], kept->upper[lower + d]);
            isWhole_ = isWhole_ && family.isWhole;
            const Offset familyCount = family.isWhole ? std::ssize(family.parts->values())
                                                      : std::ssize(family.entryOfChild);
            // Checked before the children are numbered and created.
            if (count + familyCount > kMaxIndex)
                throw TopologyError(TopologyCause::TooManyEntities, {d, kMaxIndex},
                                    concat("the refined complex has more than ", kMaxIndex,
                                           " entities of dimension ", d, "; refine fewer times"));
            family.firstChild = static_cast<Index>(count);
            family.childCount = static_cast<Index>(familyCount);
            count += familyCount;
        }
        childCounts_[d] = static_cast<Index>(count);
    }
}

/// Returns a lower bound of the child's memory, in bytes.
std::uint64_t Refinement::leastBytes() const {
    constexpr std::uint64_t kSignedEntry = sizeof(Index) + sizeof(Signed::sign);
    return kSignedEntry * (2 * static_cast<std::uint64_t>(childCounts_[1]) +
                           4 * static_cast<std::uint64_t>(childCounts_[2]));
}

/// Keeps only the entries whose ends are both marked.
void Refinement::Family::drop(const std::vector<std::uint8_t>& lower,
                              const std::vector<std::uint8_t>& upper) {
    const auto entryCount = parts->values().size();
    childOfEntry.assign(entryCount, kMaxIndex);
    for (Index row = 0; row < parts->rowCount(); ++row) {
        if (upper[row] == 0) continue;
        for (Offset entry = parts->offset(row); entry < parts->offset(row + 1); ++entry) {
            if (lower[parts->values()[entry]] == 0) continue;
            childOfEntry[entry] = static_cast<Index>(entryOfChild.size());
            entryOfChild.push_back(entry);
        }
    }
    isWhole = entryOfChild.size() == entryCount;
}

/// Builds the child edges [a,b], with a in the boundary of b. The edge joins the points of a and b;
/// the point of a is its tail if σ(b,a) is −1.
template <bool kIsWhole>
SignedIncidence Refinement::childEdges() const {
    Array<Index> ends(Offset{2} * childCounts_[1]);
    Array<std::int8_t> signs(ends.size());
    for (int upper = 1; upper <= dimension_; ++upper) {
        parallelFor(parent_.count(upper), kGrain, [&](Offset first, Offset last) {
            const auto edges = numbers<kIsWhole>(upper - 1, upper);
            const auto lowerPoints = numbers<kIsWhole>(upper - 1, upper - 1),
                       upperPoints = numbers<kIsWhole>(upper, upper);
            const std::int8_t* const sides = parent_.boundary(upper).signs().data();
            for (Offset row = first; row < last; ++row) {
                const auto whole = static_cast<Index>(row);
                const Offset end = edges.offset(whole + 1);
                for (Offset entry = edges.offset(whole); entry < end; ++entry) {
                    if (!edges.isKept(entry)) continue;
                    const Index point = upperPoints.child(row);
                    const Index side = lowerPoints.child(edges.part(entry));
                    const Offset at = 2 * Offset{edges.child(entry)};
                    ends[at] = sides[entry] > 0 ? point : side;
                    ends[at + 1] = sides[entry] > 0 ? side : point;
                    signs[at] = -1;
                    signs[at + 1] = 1;
                }
            }
        });
    }
    return SignedIncidence(Incidence::uniform(2, std::move(ends)), std::move(signs));
}

/// Builds the child faces [v,f], the corners of faces: the loop of f enters the corner along one
/// edge and leaves it along the next. Corners are identified by position in the loop, since a loop
/// may pass a vertex more than once (degenerate faces of meshes).
template <bool kIsWhole>
void Refinement::addCorners(Quadrilaterals& quadrilaterals) const {
    parallelFor(parent_.count(2), kGrain, [&](Offset firstFace, Offset lastFace) {
        const auto corners = numbers<kIsWhole>(0, 2), ends = numbers<kIsWhole>(0, 1),
                   sides = numbers<kIsWhole>(1, 2);
        const std::int8_t* const signs = parent_.boundary(2).signs().data();
        for (Offset f = firstFace; f < lastFace; ++f) {
            const auto face = static_cast<Index>(f);
            const Offset begin = corners.offset(face), end = corners.offset(face + 1);
            for (Offset at = begin; at < end; ++at) {
                if (!corners.isKept(at)) continue;
                const Offset before = at == begin ? end - 1 : at - 1;
                const std::int8_t leaving = signs[at];
                const std::int8_t entering = signs[before];
                // The vertex is the tail of the edge it leaves along, if the edge runs in the
                // direction of the loop.
                const Offset tail = ends.offset(sides.part(at)) + (leaving > 0 ? 0 : 1);
                const Offset head = ends.offset(sides.part(before)) + (entering > 0 ? 1 : 0);
                quadrilaterals.set(corners.child(at), {{{ends.child(tail), leaving},
                                                        {sides.child(at), opposite(leaving)},
                                                        {sides.child(before), entering},
                                                        {ends.child(head), entering}}});
            }
        }
    });
}

/// Returns the starts of the rows of the child cells [v,c]: a row has one face [v,f] and one face
/// [e,c] for each edge e of c at v.
template <bool kIsWhole>
RowStarts Refinement::startsOfCorners() const {
    const Incidence& cellFaces = parent_.relation(3, 2);
    if (parent_.isRefined() && cellFaces.commonLength() == 6)  // All cells are hexahedra.
        return {childCounts_[3], 6};
    const auto corners = numbers<kIsWhole>(0, 3);
    const Incidence& cellVertices = parent_.relation(3, 0);
    const Incidence& cellEdges = parent_.relation(3, 1);
    const Incidence& ends = parent_.relation(1, 0);
    Array<Index> lengths(childCounts_[3]);
    parallelFor(parent_.count(3), kGrain, [&](Offset first, Offset last) {
        std::vector<Index> valences;
        for (Offset c = first; c < last; ++c) {
            const auto cell = static_cast<Index>(c);
            const std::span<const Index> vertices = cellVertices[cell];
            if (parent_.isRefined()) {
                valences.assign(vertices.size(), 3);
                valences.front() = valences.back() = static_cast<Index>(cellFaces[cell].size() / 2);
            } else {
                valences.assign(vertices.size(), 0);
                for (const Index edge : cellEdges[cell])
                    for (const Index end : ends[edge]) ++valences[placeInRow(vertices, end)];
            }
            const Offset begin = corners.offset(cell);
            for (Offset v = 0; v < std::ssize(valences); ++v)
                if (corners.isKept(begin + v)) lengths[corners.child(begin + v)] = 2 * valences[v];
        }
    });
    return RowStarts::ofLengths(lengths);
}

/// Builds the child faces [e,c], from an edge of a cell and the two faces x and y at the edge.
/// Returns the rows of the child cells [v,c], the corners of cells, with their faces [v,f] and
/// [e,c].
template <bool kIsWhole>
SignedIncidence Refinement::addSides(Quadrilaterals& quadrilaterals) const {
    RowStarts starts = startsOfCorners<kIsWhole>();
    Array<Index> values(starts[childCounts_[3]]);
    Array<std::int8_t> signs(values.size());

    parallelFor(parent_.count(3), kGrain, [&](Offset firstCell, Offset lastCell) {
        const auto vertexFaces = numbers<kIsWhole>(0, 2), edgeFaces = numbers<kIsWhole>(1, 2),
                   edgeCells = numbers<kIsWhole>(1, 3), faceCells = numbers<kIsWhole>(2, 3),
                   corners = numbers<kIsWhole>(0, 3);
        const std::int8_t* const cellFaceSigns = parent_.boundary(3).signs().data();
        const std::int8_t* const faceEdgeSigns = parent_.boundary(2).signs().data();
        const RowStarts::View rowStarts = starts;
        CornerPlaces places(parent_);
        std::vector<Offset> next;  // place of the next value of each row [v,c]; −1 if not kept
        std::vector<EdgeOfCell> edges;
        for (Offset c = firstCell; c < lastCell; ++c) {
            const auto cell = static_cast<Index>(c);
            places.find(cell);
            next.clear();
            for (Offset at = corners.offset(cell); at < corners.offset(cell + 1); ++at)
                next.push_back(corners.isKept(at) ? rowStarts[corners.child(at)] : -1);
            const Offset firstEdge = edgeCells.offset(cell);
            edges.assign(edgeCells.offset(cell + 1) - firstEdge, {});

            const Index *vertexOf = places.vertices(), *edgeOf = places.edges();
            for (Offset inCell = faceCells.offset(cell); inCell < faceCells.offset(cell + 1);
                 ++inCell) {
                const Index face = faceCells.part(inCell);
                const std::int8_t inCellSign = cellFaceSigns[inCell];
                const Offset begin = vertexFaces.offset(face);
                const auto length = static_cast<Index>(vertexFaces.offset(face + 1) - begin);
                for (Index i = 0; i < length; ++i) {
                    const Offset inFace = begin + i;
                    if (Offset& at = next[vertexOf[i]]; at >= 0) {
                        values[at] = vertexFaces.child(inFace);
                        signs[at++] = inCellSign;
                    }
                    const std::int8_t edgeSign = faceEdgeSigns[inFace];
                    EdgeOfCell& edge = edges[edgeOf[i]];
                    EdgeOfCell::Face x{inFace, inCell, edgeSign, inCellSign};
                    if (edge.first.inCell < 0) {
                        const Index end = vertexOf[i + 1 < length ? i + 1 : 0];
                        edge = {x, edgeSign > 0 ? vertexOf[i] : end,
                                edgeSign > 0 ? end : vertexOf[i]};
                    } else if (edgeCells.isKept(firstEdge + edgeOf[i])) {
                        // Since ∂∂ = 0, the product of a face's sign in c and the edge's sign in
                        // the face is 1 for one of the two faces and −1 for the other. Here x is
                        // the face whose product is −1; the loop leaves [e,e] towards x.
                        EdgeOfCell::Face y = edge.first;
                        if (x.inCellSign == x.edgeSign) std::swap(x, y);
                        quadrilaterals.set(edgeCells.child(firstEdge + edgeOf[i]),
                                           {{{edgeFaces.child(x.edgeInFace), x.inCellSign},
                                             {faceCells.child(x.inCell), x.edgeSign},
                                             {faceCells.child(y.inCell), y.edgeSign},
                                             {edgeFaces.child(y.edgeInFace), y.inCellSign}}});
                    }
                }
                vertexOf += length;
                edgeOf += length;
            }
            for (std::size_t e = 0; e < edges.size(); ++e)
                for (const auto& [end, sign] :
                     {std::pair(edges[e].tail, 1), std::pair(edges[e].head, -1)})
                    if (Offset& at = next[end]; at >= 0) {
                        values[at] = edgeCells.child(firstEdge + static_cast<Offset>(e));
                        signs[at++] = static_cast<std::int8_t>(sign);
                    }
        }
    });
    return {Incidence(std::move(starts), std::move(values)), std::move(signs)};
}

Interval Refinement::parentOf(Entity child) const {
    int lower = 0;
    const auto isIn = [&](const Family& f) { return child.index - f.firstChild < f.childCount; };
    while (!isIn(families_[lower][lower + child.dimension])) ++lower;
    const Family& family = families_[lower][lower + child.dimension];
    const auto at = child.index - family.firstChild;
    const Offset entry = family.isWhole ? Offset{at} : family.entryOfChild[at];
    return {{lower, family.parts->values()[entry]},
            {lower + child.dimension, family.parts->rowOf(entry)}};
}

std::optional<Entity> Refinement::childOf(const Interval& interval) const {
    const Entity lower = interval.lower;
    const Entity upper = interval.upper;
    if (lower.dimension > upper.dimension || upper.dimension > dimension_) return std::nullopt;
    const Family& family = families_[lower.dimension][upper.dimension];
    const auto row = parent_.relation(upper.dimension, lower.dimension)[upper.index];
    const auto at = std::find(row.begin(), row.end(), lower.index) - row.begin();
    if (at == std::ssize(row)) return std::nullopt;
    const Offset entry = family.parts->offset(upper.index) + at;
    return withWhole([&](auto isWhole) -> std::optional<Entity> {
        const Numbers<isWhole> numbers(family);
        if (!numbers.isKept(entry)) return std::nullopt;
        return Entity{upper.dimension - lower.dimension, numbers.child(entry)};
    });
}

namespace {

double pairCount(const CellComplex& complex, int from, int to) {
    if (from > complex.dimension()) return 0;
    return static_cast<double>(complex.relation(from, to).values().size());
}

/// The children are intervals [a, b]: edges if dim a = dim b − 1, and so on. Faces are
/// quadrilaterals. A cell [v, c], with n edges of c at v, has 2n faces, 4n edges and 2n + 2
/// vertices; the sum of n over all vertices of c is twice the number of edges of c.
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
    // Sizes other than 0 at least double on each level, so they are infinite long before this level
    // and stay so.
    constexpr int kAllInfinite = 2 * std::numeric_limits<double>::max_exponent;
    for (int level = 0; level < std::min(levels, kAllInfinite); ++level) size = next(size);
    return size;
}

}  // namespace espalier::far
