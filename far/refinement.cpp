// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/far/refinement.h>
#include <espalier/far/topology_error.h>

#include "cell_corners.h"

#include <numeric>
#include <string>

namespace espalier::far {

// With σ(x, y) the incidence number of y in the boundary of x, and d = dim b − dim a,
//
//     ∂[a,b] = Σ σ(b,b') [a,b']  +  (−1)^d Σ σ(a',a) [a',b]
//
// over the b' of one dimension less than b, and the a' of one more than a, inside [a,b]. The sign
// (−1)^d makes the mixed terms of ∂∂ cancel, so a coherently oriented parent has a coherently
// oriented child, and [v,c] is oriented as c is.

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

/// Rows that a range of parents has made.
struct SignedRows {
    Array<Index> values, lengths;
    Array<std::int8_t> signs;
};

SignedIncidence join(const std::vector<SignedRows>& chunks) {
    Rows<Index> rows;
    Array<std::int8_t> signs;
    std::size_t rowCount = 0, valueCount = 0;
    for (const SignedRows& chunk : chunks) {
        rowCount += chunk.lengths.size();
        valueCount += chunk.values.size();
    }
    rows.values.reserve(valueCount);
    signs.reserve(valueCount);
    for (const SignedRows& chunk : chunks) {
        rows.values.insert(rows.values.end(), chunk.values.begin(), chunk.values.end());
        signs.insert(signs.end(), chunk.signs.begin(), chunk.signs.end());
    }
    const auto first = std::find_if(chunks.begin(), chunks.end(),
                                    [](const SignedRows& chunk) { return !chunk.lengths.empty(); });
    const Index length = first->lengths.front();  // There is one: the child is not empty.
    const auto isUniform = [&](const SignedRows& chunk) {
        return std::all_of(chunk.lengths.begin(), chunk.lengths.end(),
                           [&](Index other) { return other == length; });
    };
    if (std::all_of(chunks.begin(), chunks.end(), isUniform))
        return {Incidence::uniform(length, std::move(rows.values)), std::move(signs)};
    rows.offsets.reserve(rowCount + 1);
    for (const SignedRows& chunk : chunks)
        for (const Index next : chunk.lengths) rows.offsets.push_back(rows.offsets.back() + next);
    return {Incidence(std::move(rows)), std::move(signs)};
}

}  // namespace

Refinement::Refinement(const CellComplex& parent, const Kept* kept)
    : parent_(parent), dimension_(parent.dimension()) {
    numberChildren(kept);
    if (childCounts_[dimension_] == 0)
        throw TopologyError(TopologyCause::EmptyComplex, {dimension_, 0},
                            std::string("refined without boundary control, the complex has no ") +
                                dimensionName(dimension_) + " left: it has no interior vertex");
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
    child_ = CellComplex(dimension_, childCounts_[0], std::move(boundaries));
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
            // Numbered before they are made.
            if (count + familyCount > kMaxIndex)
                throw TopologyError(TopologyCause::TooManyEntities, {d, kMaxIndex},
                                    "the refined complex has more than " +
                                        std::to_string(kMaxIndex) + " entities of one dimension");
            family.firstChild = static_cast<Index>(count);
            family.childCount = static_cast<Index>(familyCount);
            count += familyCount;
        }
        childCounts_[d] = static_cast<Index>(count);
    }
}

/// Bytes that the child takes at least.
std::uint64_t Refinement::leastBytes() const {
    constexpr std::uint64_t kSignedEntry = sizeof(Index) + sizeof(Signed::sign);
    return kSignedEntry * (2 * static_cast<std::uint64_t>(childCounts_[1]) +
                           4 * static_cast<std::uint64_t>(childCounts_[2]));
}

/// Leaves the entries with both ends marked.
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

/// [a,b] for the a in the boundary of b: it joins the points of the two, that of a being its tail
/// where σ(b,a) is −1.
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

/// [v,f]: the corner of a face, which the loop of f enters along one edge and leaves along the
/// next. By positions, not by names: a loop may pass a vertex more than once (degenerate faces of
/// meshes).
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
                // The vertex is the tail of the edge that it leaves along, if that runs its way.
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

/// [e,c], with an edge of a cell and the two faces x and y at it, and [v,c] of the returned rows,
/// the corner of a cell with its faces [v,f] and [e,c].
SignedIncidence Refinement::addSides(Quadrilaterals& quadrilaterals) const {
    const Family& vertexFaces = family(0, 2);
    const Family& edgeFaces = family(1, 2);
    const Family& edgeCells = family(1, 3);
    const Family& faceCells = family(2, 3);
    const Family& corners = family(0, 3);

    // [v,c] come cell by cell; each range of cells collects its own.
    const Index cellCount = parent_.count(3);
    std::vector<SignedRows> chunks((cellCount + kGrain - 1) / kGrain);
    parallelFor(cellCount, kGrain, [&](Offset firstCell, Offset lastCell) {
        SignedRows& chunk = chunks[firstCell / kGrain];
        CellCorners cell(parent_);
        for (Offset index = firstCell; index < lastCell; ++index) {
            cell.visit(static_cast<Index>(index));
            for (const CellCorners::Edge& edge : cell.edges()) {
                if (!edgeCells.isKept(edge.inCell)) continue;
                // ∂∂ = 0: the signs of the two faces in c and of e in these multiply to 1 and −1.
                // The loop leaves [e,e] for x, with which it is −1.
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
                for (const CellCorners::VertexFace& face : cell.facesAt(v)) {
                    chunk.values.push_back(vertexFaces.child(face.vertexInFace));
                    chunk.signs.push_back(face.inCellSign);
                }
                for (const CellCorners::VertexEdge& edge : cell.edgesAt(v)) {
                    chunk.values.push_back(edgeCells.child(edge.inCell));
                    chunk.signs.push_back(opposite(edge.vertexSign));
                }
                chunk.lengths.push_back(
                    static_cast<Index>(cell.facesAt(v).size() + cell.edgesAt(v).size()));
            }
        }
    });
    return join(chunks);
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

}  // namespace espalier::far
