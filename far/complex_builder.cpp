// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>

#include <numeric>
#include <string>
#include <utility>

#include "canonical_loop.h"

namespace espalier::far {

ComplexBuilder::ComplexBuilder(int dimension, Index vertexCount)
    : dimension_(dimension), vertexCount_(vertexCount) {}

void ComplexBuilder::checkLoop(std::span<const Index> loop, std::size_t least,
                               Entity entity) const {
    const auto refuse = [&](TopologyCause cause, const std::string& why) {
        throw TopologyError(cause, entity,
                            concat(dimensionName(entity.dimension), " ", entity.index, ": loop (",
                                   listed(loop, 32), ")", why));
    };
    if (loop.size() < least)
        refuse(TopologyCause::TooFewVertices, concat(" has fewer than ", least, " vertices"));
    for (const Index vertex : loop)
        if (vertex < 0 || vertex >= vertexCount_)
            refuse(TopologyCause::VertexOutOfRange,
                   concat(" names vertex ", vertex, "; there are ", vertexCount_));
    if (dimension_ == 2) return;
    if (const auto twice = repeatedIn(loop))
        refuse(TopologyCause::RepeatedVertex, concat(" names vertex ", *twice, " twice"));
}

void ComplexBuilder::appendLoop(std::span<const Index> loop) {
    loops_.values.insert(loops_.values.end(), loop.begin(), loop.end());
    loops_.offsets.push_back(static_cast<Offset>(loops_.values.size()));
}

void ComplexBuilder::checkDimension(int dimension) const {
    if (dimension != dimension_)
        throw TopologyError(
            TopologyCause::WrongDimension, {dimension, 0},
            concat("a complex of dimension ", dimension_, " is made of ", dimensionName(dimension_),
                   "s; got a", dimension == 1 ? "n " : " ", dimensionName(dimension)));
}

Index ComplexBuilder::addCell(std::span<const std::vector<Index>> loops) {
    checkDimension(3);
    const Entity cell{3, static_cast<Index>(cellOffsets_.size() - 1)};
    for (const auto& loop : loops) checkLoop(loop, 3, cell);
    for (const auto& loop : loops) appendLoop(loop);
    cellOffsets_.push_back(static_cast<Offset>(loops_.offsets.size()) - 1);
    return cell.index;
}

Index ComplexBuilder::addCell(StandardCell cell, std::span<const Index> vertices) {
    if (vertices.size() != static_cast<std::size_t>(vertexCount(cell)))
        throw TopologyError(TopologyCause::TooFewVertices,
                            {3, static_cast<Index>(cellOffsets_.size() - 1)},
                            concat("cell ", cellOffsets_.size() - 1, " has ", vertices.size(),
                                   " vertices; expected ", vertexCount(cell)));
    std::array<std::vector<Index>, 6> loops;
    std::size_t count = 0;
    for (const auto& places : faceLoops(cell)) {
        loops[count].reserve(places.size());
        for (const Index place : places) loops[count].push_back(vertices[place]);
        ++count;
    }
    return addCell(std::span(loops).first(count));
}

Index ComplexBuilder::addFace(std::span<const Index> loop) {
    checkDimension(2);
    const Entity face{2, static_cast<Index>(loops_.offsets.size() - 1)};
    checkLoop(loop, 3, face);
    appendLoop(loop);
    return face.index;
}

Index ComplexBuilder::addEdge(Index tail, Index head) {
    checkDimension(1);
    const Entity edge{1, static_cast<Index>(loops_.offsets.size() - 1)};
    const Index ends[] = {tail, head};
    checkLoop(ends, 2, edge);
    appendLoop(ends);
    return edge.index;
}

std::vector<Index> ComplexBuilder::dropUnusedVertices() {
    std::vector<bool> isUsed(vertexCount_, false);
    for (const Index vertex : loops_.values) isUsed[vertex] = true;
    std::vector<Index> dropped;
    std::vector<Index> newNumbers(isUsed.size());
    Index next = 0;
    for (std::size_t vertex = 0; vertex < isUsed.size(); ++vertex)
        if (isUsed[vertex])
            newNumbers[vertex] = next++;
        else
            dropped.push_back(static_cast<Index>(vertex));
    if (dropped.empty()) return dropped;
    for (Index& vertex : loops_.values) vertex = newNumbers[vertex];
    vertexCount_ = next;
    return dropped;
}

namespace {

/// Equivalence classes of the items 0 to count − 1, numbered in the order of their first items.
struct Classes {
    std::vector<Index> classOf;         ///< per item
    std::vector<Index> representative;  ///< per class: its first item
};

/// Finds the classes of items. Sorts only items with the same smallest vertex, which are few and
/// near to each other in memory.
/// \param smallestVertex called with an item; equal for equivalent items
/// \param less orders items with the same smallest vertex; equivalent items are not less
template <class SmallestVertex, class Less>
Classes classify(Index vertexCount, Index count, SmallestVertex smallestVertex, Less less) {
    std::vector<Index> ends(static_cast<std::size_t>(vertexCount) + 1, 0);
    for (Index item = 0; item < count; ++item) ++ends[smallestVertex(item) + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<Index> items(count);  // in the order of their smallest vertices
    for (Index item = 0; item < count; ++item) items[ends[smallestVertex(item)]++] = item;

    Classes classes;
    classes.classOf.resize(count);  // at first the first item of the class, then its number
    Index begin = 0;
    for (Index vertex = 0; vertex < vertexCount; ++vertex) {
        const Index end = ends[vertex];
        std::sort(items.begin() + begin, items.begin() + end, [&](Index a, Index b) {
            if (less(a, b)) return true;
            return !less(b, a) && a < b;
        });
        for (Index i = begin; i < end; ++i)
            classes.classOf[items[i]] = i == begin || less(items[i - 1], items[i])
                                            ? items[i]
                                            : classes.classOf[items[i - 1]];
        begin = end;
    }
    for (Index item = 0; item < count; ++item) {
        const Index first = classes.classOf[item];
        if (first == item) {
            classes.classOf[item] = static_cast<Index>(classes.representative.size());
            classes.representative.push_back(item);
        } else {
            classes.classOf[item] = classes.classOf[first];
        }
    }
    return classes;
}

/// Returns +1 if two ways of writing the same face run in the same direction, else −1.
int relativeDirection(std::span<const Index> loop, std::span<const Index> reference) {
    const std::size_t n = loop.size();
    const std::size_t at =
        std::find(reference.begin(), reference.end(), loop[0]) - reference.begin();
    return reference[(at + 1) % n] == loop[1] ? 1 : -1;
}

/// All steps from one vertex to the next in some loops.
struct Steps {
    std::vector<std::array<Index, 2>> ends;  ///< one per position in the values of the loops
    Classes edges;                           ///< steps with the same two ends are the same edge

    Steps(Index vertexCount, const Incidence& loops) {
        // 0 for most steps. A step from a vertex to itself, or one that its loop has made before,
        // gets a number of its own, and so becomes a separate edge.
        std::vector<Index> repeats(loops.values().size(), 0);
        std::vector<std::array<Index, 3>> sorted;  // the two ends, and the position
        ends.reserve(repeats.size());
        for (Index row = 0; row < loops.rowCount(); ++row) {
            const auto loop = loops[row];
            const auto first = static_cast<Index>(ends.size());
            for (std::size_t i = 0; i + 1 < loop.size(); ++i)
                ends.push_back({loop[i], loop[i + 1]});
            ends.push_back({loop.back(), loop.front()});
            if (!repeatedIn(loop)) continue;
            sorted.clear();
            for (auto step = first; step < std::ssize(ends); ++step) {
                const auto [low, high] = std::minmax(ends[step][0], ends[step][1]);
                sorted.push_back({low, high, step});
            }
            std::sort(sorted.begin(), sorted.end());
            for (std::size_t i = 0; i < sorted.size(); ++i) {
                const auto& [low, high, step] = sorted[i];
                if (low == high || (i > 0 && sorted[i - 1][0] == low && sorted[i - 1][1] == high))
                    repeats[step] = step + 1;
            }
        }
        const auto low = [&](Index step) { return std::min(ends[step][0], ends[step][1]); };
        const auto key = [&](Index step) {
            return std::pair(std::max(ends[step][0], ends[step][1]), repeats[step]);
        };
        edges = classify(vertexCount, static_cast<Index>(ends.size()), low,
                         [&](Index a, Index b) { return key(a) < key(b); });
    }

    Index edge(Offset step) const { return edges.classOf[step]; }

    /// Returns +1 if the step runs from the tail to the head of its edge, else −1.
    std::int8_t sign(Offset step) const {
        const auto leader = edges.representative[edge(step)];
        return ends[step] == ends[leader] ? std::int8_t{1} : std::int8_t{-1};
    }

    /// Returns edge → (tail, head), in the direction of the edge's first step.
    SignedIncidence edgeEnds() const {
        Rows<Signed> rows;
        for (const Index step : edges.representative) {
            rows.values.push_back({ends[step][0], -1});
            rows.values.push_back({ends[step][1], +1});
            rows.offsets.push_back(static_cast<Offset>(rows.values.size()));
        }
        return SignedIncidence(rows);
    }

    /// Returns face → (edge, sign) for the loops that represent the faces.
    SignedIncidence faceEdges(const Incidence& loops, std::span<const Index> faces) const {
        Rows<Signed> rows;
        for (const Index loop : faces) {
            for (Offset step = loops.offset(loop); step < loops.offset(loop + 1); ++step)
                rows.values.push_back({edge(step), sign(step)});
            rows.offsets.push_back(static_cast<Offset>(rows.values.size()));
        }
        return SignedIncidence(rows);
    }
};

/// Two loops that both are to be reversed or both not; or exactly one of them, if not `sameTurn`.
struct Tie {
    Index a;
    Index b;
    bool sameTurn;
};

/// Finds which loops of a lattice to reverse so that all run anticlockwise seen from outside their
/// cells. Loops are tied in pairs: two loops of one cell that share an edge must run along it in
/// opposite directions, and the two loops of one face must also be opposite. In each connected
/// piece, the smaller number of loops is reversed. Pairs that cannot be satisfied are left to
/// validate(), which names them. Returns −1 for each loop to reverse, +1 for the others.
std::vector<int> turnsOf(Index loopCount, const std::vector<Tie>& ties) {
    std::vector<std::vector<Tie>> tiesOf(loopCount);
    for (const auto& [a, b, sameTurn] : ties) {
        tiesOf[a].push_back({a, b, sameTurn});
        tiesOf[b].push_back({b, a, sameTurn});
    }
    std::vector<int> turn(loopCount, 0);
    std::vector<Index> piece;
    for (Index start = 0; start < loopCount; ++start) {
        if (turn[start] != 0) continue;
        turn[start] = 1;
        piece.assign(1, start);
        int sum = 0;
        for (std::size_t next = 0; next < piece.size(); ++next) {
            sum += turn[piece[next]];
            for (const auto& [loop, other, sameTurn] : tiesOf[piece[next]]) {
                if (turn[other] != 0) continue;
                turn[other] = sameTurn ? turn[loop] : -turn[loop];
                piece.push_back(other);
            }
        }
        if (sum < 0)
            for (const Index loop : piece) turn[loop] = -turn[loop];
    }
    return turn;
}

CellComplex latticeOf(Index vertexCount, const Incidence& loops,
                      const std::vector<Offset>& cellOffsets) {
    const Incidence canonical(buildRows<Index>(
        loops.rowCount(),
        [&](Index row, std::vector<Index>& out) { appendCanonicalLoop(loops[row], out); }));
    const auto low = [&](Index loop) { return canonical[loop].front(); };
    const Classes faces = classify(vertexCount, loops.rowCount(), low, [&](Index a, Index b) {
        return std::lexicographical_compare(canonical[a].begin(), canonical[a].end(),
                                            canonical[b].begin(), canonical[b].end());
    });
    const Steps steps(vertexCount, loops);
    const auto faceOf = [&](Offset loop) { return faces.classOf[loop]; };
    const auto directionInFace = [&](Offset loop) {
        const Index leader = faces.representative[faceOf(loop)];
        return relativeDirection(loops[static_cast<Index>(loop)], loops[leader]);
    };

    const auto forEachTie = [&](auto visit) {
        // The edge, the loop, and whether the step runs against the edge, in one number for the
        // speed of sorting.
        std::vector<std::uint64_t> sides;
        const auto edgeOf = [](std::uint64_t side) { return side >> 32; };
        const auto loopOf = [](std::uint64_t side) {
            return static_cast<Index>(static_cast<std::uint32_t>(side) >> 1);
        };
        for (std::size_t cell = 0; cell + 1 < cellOffsets.size(); ++cell) {
            sides.clear();
            const auto first = static_cast<Index>(cellOffsets[cell]);
            const auto last = static_cast<Index>(cellOffsets[cell + 1]);
            for (Index loop = first; loop < last; ++loop)
                for (Offset step = loops.offset(loop); step < loops.offset(loop + 1); ++step)
                    sides.push_back(std::uint64_t(steps.edge(step)) << 32 |
                                    std::uint64_t(loop) << 1 | std::uint64_t(steps.sign(step) < 0));
            std::sort(sides.begin(), sides.end());
            for (std::size_t i = 0; i + 1 < sides.size(); ++i)
                if (edgeOf(sides[i]) == edgeOf(sides[i + 1]))
                    visit(Tie{loopOf(sides[i]), loopOf(sides[i + 1]),
                              (sides[i] & 1) != (sides[i + 1] & 1)});
        }
        for (Index loop = 0; loop < loops.rowCount(); ++loop) {
            const Index leader = faces.representative[faceOf(loop)];
            if (leader != loop) visit(Tie{leader, loop, directionInFace(loop) < 0});
        }
    };
    // Most lattices are oriented as they are given.
    bool isOriented = true;
    forEachTie([&](const Tie& tie) { isOriented = isOriented && tie.sameTurn; });
    std::vector<int> turn(loops.rowCount(), 1);
    if (!isOriented) {
        std::vector<Tie> ties;
        forEachTie([&](const Tie& tie) { ties.push_back(tie); });
        turn = turnsOf(loops.rowCount(), ties);
    }

    Rows<Signed> cellFaces;
    for (std::size_t cell = 0; cell + 1 < cellOffsets.size(); ++cell) {
        for (Offset loop = cellOffsets[cell]; loop < cellOffsets[cell + 1]; ++loop)
            cellFaces.values.push_back(
                {faceOf(loop), static_cast<std::int8_t>(turn[loop] * directionInFace(loop))});
        cellFaces.offsets.push_back(static_cast<Offset>(cellFaces.values.size()));
    }
    return CellComplex(3, vertexCount,
                       {steps.edgeEnds(), steps.faceEdges(loops, faces.representative),
                        SignedIncidence(cellFaces)});
}

CellComplex meshOf(Index vertexCount, const Incidence& loops) {
    const Steps steps(vertexCount, loops);
    std::vector<Index> faces(loops.rowCount());
    std::iota(faces.begin(), faces.end(), Index{0});
    return CellComplex(2, vertexCount, {steps.edgeEnds(), steps.faceEdges(loops, faces), {}});
}

CellComplex curveOf(Index vertexCount, const Incidence& edges) {
    Rows<Signed> ends;
    for (Index edge = 0; edge < edges.rowCount(); ++edge) {
        ends.values.push_back({edges[edge][0], -1});
        ends.values.push_back({edges[edge][1], +1});
        ends.offsets.push_back(static_cast<Offset>(ends.values.size()));
    }
    return CellComplex(1, vertexCount, {SignedIncidence(ends), {}, {}});
}

}  // namespace

CellComplex ComplexBuilder::build() const {
    if (loops_.values.size() > static_cast<std::size_t>(kMaxIndex))
        throw TopologyError(TopologyCause::TooManyEntities, {dimension_, kMaxIndex},
                            concat("the loops name ", loops_.values.size(),
                                   " vertices in all; the most is ", kMaxIndex));
    const Incidence loops(loops_);
    CellComplex complex = dimension_ == 3   ? latticeOf(vertexCount_, loops, cellOffsets_)
                          : dimension_ == 2 ? meshOf(vertexCount_, loops)
                                            : curveOf(vertexCount_, loops);
    validate(complex);
    return complex;
}

CellComplex buildCurve(Index vertexCount, bool closed) {
    ComplexBuilder builder(1, vertexCount);
    for (Index vertex = 1; vertex < vertexCount; ++vertex) builder.addEdge(vertex - 1, vertex);
    if (closed) builder.addEdge(vertexCount - 1, 0);
    return builder.build();
}

CellComplex buildMesh(Index vertexCount, std::span<const std::vector<Index>> loops) {
    ComplexBuilder builder(2, vertexCount);
    for (const auto& loop : loops) builder.addFace(loop);
    return builder.build();
}

}  // namespace espalier::far
