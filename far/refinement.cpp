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
template <std::size_t kLength>
Index placeInRow(std::span<const Index, kLength> row, Index value) {
    // Short rows are scanned without a branch.
    constexpr std::size_t kShort = 16;
    if (row.size() > kShort)
        return static_cast<Index>(std::lower_bound(row.begin(), row.end(), value) - row.begin());
    Index less = 0;
    for (const Index other : row) less += other < value;
    return less;
}

/// A list of at most `kCapacity` values.
template <class T, std::size_t kCapacity>
class ShortList {
public:
    void clear() { size_ = 0; }
    void push_back(const T& value) { values_[size_++] = value; }
    std::size_t size() const { return size_; }
    const T* begin() const { return values_.data(); }
    const T* end() const { return values_.data() + size_; }

private:
    std::array<T, kCapacity> values_;
    std::size_t size_ = 0;
};

/// How CellCorners stores the parts of any cell.
struct AnyCell {
    static constexpr std::size_t kVertices = std::dynamic_extent, kEdges = std::dynamic_extent,
                                 kFaces = std::dynamic_extent, kCorners = std::dynamic_extent;
    template <class T>
    using PerVertex = std::vector<T>;
    template <class T>
    using PerEdge = std::vector<T>;
    template <class T>
    using AtVertex = std::vector<T>;
};

/// How CellCorners stores the parts of a hexahedron. With these numbers known to the compiler, a
/// hexahedron takes a third of the time. Nearly all cells of a refined lattice are hexahedra.
struct Hexahedron {
    static constexpr std::size_t kVertices = 8, kEdges = 12, kFaces = 6, kCorners = 4;
    template <class T>
    using PerVertex = std::array<T, kVertices>;
    template <class T>
    using PerEdge = std::array<T, kEdges>;
    template <class T>
    using AtVertex = ShortList<T, 3>;
};

/// Collects the faces and edges that meet at the edges and vertices of a cell of a lattice. A pair
/// of incident entities is identified by its position in the values of a relation.
template <class Kind>
class CellCorners {
public:
    /// \param lattice must outlive this object
    explicit CellCorners(const CellComplex& lattice)
        : cellFaces_(lattice.boundary(3)),
          faceEdges_(lattice.boundary(2)),
          faceVertices_(lattice.relation(2, 0)),
          cellVertices_(lattice.relation(3, 0)),
          cellEdges_(lattice.relation(3, 1)) {}

    /// One of the two faces at an edge of the cell.
    struct EdgeFace {
        Offset edgeInFace;       ///< position of the edge in face → edges
        Offset inCell;           ///< position of the face in cell → faces
        std::int8_t edgeSign;    ///< of the edge in the boundary of the face
        std::int8_t inCellSign;  ///< of the face in the boundary of the cell
    };
    struct Edge {
        Offset inCell;  ///< position in cell → edges
        std::array<EdgeFace, 2> faces;
        std::array<Index, 2> ends;  ///< tail and head, as positions among the vertices of the cell
    };
    struct VertexFace {
        Offset vertexInFace;  ///< position in face → vertices
        std::int8_t inCellSign;
    };
    struct VertexEdge {
        Offset inCell;           ///< position in cell → edges
        std::int8_t vertexSign;  ///< −1 if the vertex is the tail
    };

    /// Collects the data of a cell. Returns false if the cell is not of this kind. \cost O(n log n)
    /// in the faces of the cell
    bool visit(Index cell) {
        constexpr bool isFixed = Kind::kFaces != std::dynamic_extent;
        const auto allVertices = cellVertices_[cell], allEdges = cellEdges_[cell],
                   allFaces = cellFaces_[cell];
        vertexCount_ = allVertices.size();
        if constexpr (isFixed) {
            if (vertexCount_ != Kind::kVertices || allEdges.size() != Kind::kEdges ||
                allFaces.size() != Kind::kFaces)
                return false;
        } else {
            edges_.resize(allEdges.size());
            facesSeen_.resize(allEdges.size());
            if (facesAt_.size() < vertexCount_) {
                facesAt_.resize(vertexCount_);
                edgesAt_.resize(vertexCount_);
            }
        }
        const std::span<const Index, Kind::kVertices> vertices(allVertices);
        const std::span<const Index, Kind::kEdges> edges(allEdges);
        const std::span<const Index, Kind::kFaces> faces(allFaces);
        const auto faceSigns = cellFaces_.signs(cell);
        const Offset firstFace = cellFaces_.unsignedRows().offset(cell);
        const Offset firstEdge = cellEdges_.offset(cell);
        firstVertex_ = cellVertices_.offset(cell);
        std::fill(facesSeen_.begin(), facesSeen_.end(), std::uint8_t{0});
        for (std::size_t v = 0; v < vertices.size(); ++v) {
            facesAt_[v].clear();
            edgesAt_[v].clear();
        }

        for (std::size_t f = 0; f < faces.size(); ++f) {
            const auto wholeLoop = faceVertices_[faces[f]];
            if (isFixed && wholeLoop.size() != Kind::kCorners) return false;
            const std::span<const Index, Kind::kCorners> loop(wholeLoop);
            const std::span<const Index, Kind::kCorners> loopEdges(faceEdges_[faces[f]]);
            const std::int8_t* signs = faceEdges_.signs(faces[f]).data();
            const Offset first = faceVertices_.offset(faces[f]);
            const Index start = placeInRow(vertices, loop[0]);
            Index next = start;
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const Index vertex = next;
                next = i + 1 < loop.size() ? placeInRow(vertices, loop[i + 1]) : start;
                const Offset position = first + static_cast<Offset>(i);
                if constexpr (isFixed)
                    if (facesAt_[vertex].size() == 3) return false;
                facesAt_[vertex].push_back({position, faceSigns[f]});
                const Index e = placeInRow(edges, loopEdges[i]);
                Edge& edge = edges_[e];
                // In a valid lattice, each edge of a cell is in two of its faces.
                if (facesSeen_[e] == 2) continue;
                edge.faces[facesSeen_[e]++] = {position, firstFace + static_cast<Offset>(f),
                                               signs[i], faceSigns[f]};
                edge.ends = {signs[i] > 0 ? vertex : next, signs[i] > 0 ? next : vertex};
            }
        }
        for (std::size_t e = 0; e < edges.size(); ++e) {
            edges_[e].inCell = firstEdge + static_cast<Offset>(e);
            const auto [tail, head] = edges_[e].ends;
            if constexpr (isFixed)
                if (edgesAt_[tail].size() == 3 || edgesAt_[head].size() == 3) return false;
            edgesAt_[tail].push_back({edges_[e].inCell, -1});
            edgesAt_[head].push_back({edges_[e].inCell, 1});
        }
        return true;
    }

    /// The edges of the cell, in the order of cell → edges.
    std::span<const Edge> edges() const { return edges_; }

    std::size_t vertexCount() const { return vertexCount_; }

    /// Returns the position of vertex `v` of the cell in cell → vertices.
    Offset vertexInCell(std::size_t v) const { return firstVertex_ + static_cast<Offset>(v); }

    /// The faces at vertex `v` in the order of cell → faces, and its edges in the order of cell →
    /// edges. There are as many edges as faces.
    const auto& facesAt(std::size_t v) const { return facesAt_[v]; }
    const auto& edgesAt(std::size_t v) const { return edgesAt_[v]; }

private:
    const SignedIncidence& cellFaces_;
    const SignedIncidence& faceEdges_;
    const Incidence& faceVertices_;
    const Incidence& cellVertices_;
    const Incidence& cellEdges_;

    typename Kind::template PerEdge<Edge> edges_;
    typename Kind::template PerEdge<std::uint8_t> facesSeen_;
    std::size_t vertexCount_ = 0;
    Offset firstVertex_ = 0;
    // The number of lists is the largest number of vertices of any cell so far.
    typename Kind::template PerVertex<typename Kind::template AtVertex<VertexFace>> facesAt_;
    typename Kind::template PerVertex<typename Kind::template AtVertex<VertexEdge>> edgesAt_;
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
        std::size_t at = 4 * static_cast<std::size_t>(face);
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
    boundaries[0] = childEdges();
    if (dimension_ > 1) {
        Quadrilaterals faces;
        faces.edges.resize(4 * static_cast<std::size_t>(childCounts_[2]));
        faces.signs.resize(faces.edges.size());
        addCorners(faces);
        if (dimension_ > 2) boundaries[2] = addSides(faces);
        boundaries[1] =
            SignedIncidence(Incidence::uniform(4, std::move(faces.edges)), std::move(faces.signs));
    }
    child_ = CellComplex::refined(dimension_, childCounts_[0], std::move(boundaries));
}

void Refinement::numberChildren(const Kept* kept) {
    for (int d = 0; d <= dimension_; ++d) {
        Offset count = 0;
        for (int lower = 0; lower + d <= dimension_; ++lower) {
            Family& family = families_[lower][lower + d];
            family.parts = &parent_.relation(lower + d, lower);
            if (kept != nullptr) family.drop(kept->lower[lower], kept->upper[lower + d]);
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
            if (lower[part(entry)] == 0) continue;
            childOfEntry[entry] = static_cast<Index>(entryOfChild.size());
            entryOfChild.push_back(entry);
        }
    }
    isWhole = entryOfChild.size() == entryCount;
}

/// Builds the child edges [a,b], with a in the boundary of b. The edge joins the points of a and b;
/// the point of a is its tail if σ(b,a) is −1.
SignedIncidence Refinement::childEdges() const {
    Array<Index> ends(2 * static_cast<std::size_t>(childCounts_[1]));
    Array<std::int8_t> signs(ends.size());
    for (int upper = 1; upper <= dimension_; ++upper) {
        const Family& f = family(upper - 1, upper);
        const auto sides = parent_.boundary(upper).signs();
        parallelFor(f.parts->rowCount(), kGrain, [&](Offset first, Offset last) {
            for (Offset row = first; row < last; ++row) {
                const auto whole = static_cast<Index>(row);
                for (Offset entry = f.parts->offset(whole); entry < f.parts->offset(whole + 1);
                     ++entry) {
                    if (!f.isKept(entry)) continue;
                    Index tail = pointOf({upper - 1, f.part(entry)});
                    Index head = pointOf({upper, whole});
                    if (sides[entry] > 0) std::swap(tail, head);
                    const std::size_t at = 2 * static_cast<std::size_t>(f.child(entry));
                    ends[at] = tail;
                    ends[at + 1] = head;
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
void Refinement::addCorners(Quadrilaterals& quadrilaterals) const {
    const Family& corners = family(0, 2);
    const Family& ends = family(0, 1);
    const Family& sides = family(1, 2);
    const auto signs = parent_.boundary(2).signs();
    parallelFor(corners.parts->rowCount(), kGrain, [&](Offset firstFace, Offset lastFace) {
        for (Offset f = firstFace; f < lastFace; ++f) {
            const auto face = static_cast<Index>(f);
            const Offset begin = corners.parts->offset(face), end = corners.parts->offset(face + 1);
            for (Offset at = begin; at < end; ++at) {
                if (!corners.isKept(at)) continue;
                const Offset before = at == begin ? end - 1 : at - 1;
                const std::int8_t leaving = signs[at];
                const std::int8_t entering = signs[before];
                // The vertex is the tail of the edge it leaves along, if the edge runs in the
                // direction of the loop.
                const Offset tail = ends.parts->offset(sides.part(at)) + (leaving > 0 ? 0 : 1);
                const Offset head = ends.parts->offset(sides.part(before)) + (entering > 0 ? 1 : 0);
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
RowStarts Refinement::startsOfCorners() const {
    const Incidence& cellFaces = parent_.relation(3, 2);
    if (parent_.isRefined() && cellFaces.commonLength() == 6)  // All cells are hexahedra.
        return {childCounts_[3], 6};
    const Family& corners = family(0, 3);
    const Incidence& cellEdges = parent_.relation(3, 1);
    const Incidence& ends = parent_.relation(1, 0);
    Array<Index> lengths(childCounts_[3]);
    parallelFor(parent_.count(3), kGrain, [&](Offset first, Offset last) {
        std::vector<Index> valences;
        for (Offset c = first; c < last; ++c) {
            const auto cell = static_cast<Index>(c);
            const std::span<const Index> vertices = (*corners.parts)[cell];
            if (parent_.isRefined()) {
                valences.assign(vertices.size(), 3);
                valences.front() = valences.back() =
                    static_cast<Index>(cellFaces[cell].size() / 2);
            } else {
                valences.assign(vertices.size(), 0);
                for (const Index edge : cellEdges[cell])
                    for (const Index end : ends[edge]) ++valences[placeInRow(vertices, end)];
            }
            const Offset begin = corners.parts->offset(cell);
            for (Offset v = 0; v < std::ssize(valences); ++v)
                if (corners.isKept(begin + v)) lengths[corners.child(begin + v)] = 2 * valences[v];
        }
    });
    return RowStarts::ofLengths(lengths);
}

/// Builds the child faces [e,c], from an edge of a cell and the two faces x and y at the edge.
/// Returns the rows of the child cells [v,c], the corners of cells, with their faces [v,f] and
/// [e,c].
SignedIncidence Refinement::addSides(Quadrilaterals& quadrilaterals) const {
    const Family& vertexFaces = family(0, 2);
    const Family& edgeFaces = family(1, 2);
    const Family& edgeCells = family(1, 3);
    const Family& faceCells = family(2, 3);
    const Family& corners = family(0, 3);

    RowStarts starts = startsOfCorners();
    Array<Index> values(starts[childCounts_[3]]);
    Array<std::int8_t> signs(values.size());
    const auto addChildren = [&](const auto& cell) {
        for (const auto& edge : cell.edges()) {
            if (!edgeCells.isKept(edge.inCell)) continue;
            // Since ∂∂ = 0, the product of a face's sign in c and the edge's sign in the face is 1
            // for one of the two faces and −1 for the other. Here x is the face whose product is
            // −1; the loop leaves [e,e] towards x.
            auto x = edge.faces[0], y = edge.faces[1];
            if (x.inCellSign == x.edgeSign) std::swap(x, y);
            quadrilaterals.set(edgeCells.child(edge.inCell),
                               {{{edgeFaces.child(x.edgeInFace), x.inCellSign},
                                 {faceCells.child(x.inCell), x.edgeSign},
                                 {faceCells.child(y.inCell), y.edgeSign},
                                 {edgeFaces.child(y.edgeInFace), y.inCellSign}}});
        }
        for (std::size_t v = 0; v < cell.vertexCount(); ++v) {
            if (!corners.isKept(cell.vertexInCell(v))) continue;
            Offset at = starts[corners.child(cell.vertexInCell(v))];
            for (const auto& face : cell.facesAt(v)) {
                values[at] = vertexFaces.child(face.vertexInFace);
                signs[at++] = face.inCellSign;
            }
            for (const auto& edge : cell.edgesAt(v)) {
                values[at] = edgeCells.child(edge.inCell);
                signs[at++] = opposite(edge.vertexSign);
            }
        }
    };
    parallelFor(parent_.count(3), kGrain, [&](Offset firstCell, Offset lastCell) {
        CellCorners<Hexahedron> hexahedron(parent_);
        CellCorners<AnyCell> other(parent_);
        for (Offset cell = firstCell; cell < lastCell; ++cell) {
            if (hexahedron.visit(static_cast<Index>(cell))) {
                addChildren(hexahedron);
            } else {
                other.visit(static_cast<Index>(cell));
                addChildren(other);
            }
        }
    });
    return {Incidence(std::move(starts), std::move(values)), std::move(signs)};
}

Interval Refinement::parentOf(Entity child) const {
    int lower = 0;
    const auto isIn = [&](const Family& f) { return child.index - f.firstChild < f.childCount; };
    while (!isIn(family(lower, lower + child.dimension))) ++lower;
    const Family& f = family(lower, lower + child.dimension);
    const auto at = child.index - f.firstChild;
    const Offset entry = f.isWhole ? Offset{at} : f.entryOfChild[at];
    return {{lower, f.part(entry)}, {lower + child.dimension, f.parts->rowOf(entry)}};
}

std::optional<Entity> Refinement::childOf(const Interval& interval) const {
    const auto& [lower, upper] = interval;
    if (lower.dimension > upper.dimension || upper.dimension > dimension_) return std::nullopt;
    const Family& f = family(lower.dimension, upper.dimension);
    const auto row = (*f.parts)[upper.index];
    const auto at = std::find(row.begin(), row.end(), lower.index) - row.begin();
    const Offset entry = f.parts->offset(upper.index) + at;
    if (at == std::ssize(row) || !f.isKept(entry)) return std::nullopt;
    return Entity{upper.dimension - lower.dimension, f.child(entry)};
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
