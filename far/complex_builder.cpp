// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/hash.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "canonical_loop.h"
#include "valid_lattice.h"

namespace espalier::far {
namespace {

/// The host may cancel once in 2^12 cells or loops, which take about a millisecond.
constexpr int kBitsBetweenPolls = 12;

}  // namespace

ComplexBuilder::ComplexBuilder(int dimension, Index vertexCount)
    : dimension_(dimension), vertexCount_(vertexCount) {}

void ComplexBuilder::checkLoop(std::span<const Index> loop, std::size_t least,
                               Entity entity) const {
    // Before anything is added, so that the builder is unchanged.
    checkCancelledEvery(entity.index, kBitsBetweenPolls);
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
    corners_.insert(corners_.end(), loop.begin(), loop.end());
    loops_.append(static_cast<Index>(loop.size()));
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
    const Entity cell{3, cells_.rowCount()};
    for (const auto& loop : loops) checkLoop(loop, 3, cell);
    for (const auto& loop : loops) appendLoop(loop);
    cells_.append(static_cast<Index>(loops.size()));
    return cell.index;
}

Index ComplexBuilder::addCell(StandardCell kind, std::span<const Index> vertices) {
    const Entity cell{3, cells_.rowCount()};
    if (std::ssize(vertices) != vertexCount(kind))
        throw TopologyError(TopologyCause::TooFewVertices, cell,
                            concat("cell ", cell.index, " has ", vertices.size(),
                                   " vertices; expected ", vertexCount(kind)));
    checkDimension(3);
    const auto& faces = faceLoops(kind);
    const auto forEachLoop = [&](auto visit) {
        for (const auto& places : faces) {
            std::array<Index, 4> loop = {};
            for (std::size_t i = 0; i < places.size(); ++i) loop[i] = vertices[places[i]];
            visit(std::span(loop).first(places.size()));
        }
    };
    forEachLoop([&](std::span<const Index> loop) { checkLoop(loop, 3, cell); });
    forEachLoop([&](std::span<const Index> loop) { appendLoop(loop); });
    cells_.append(static_cast<Index>(faces.size()));
    return cell.index;
}

Index ComplexBuilder::addFace(std::span<const Index> loop) {
    checkDimension(2);
    const Entity face{2, loops_.rowCount()};
    checkLoop(loop, 3, face);
    appendLoop(loop);
    return face.index;
}

Index ComplexBuilder::addEdge(Index tail, Index head) {
    checkDimension(1);
    const Entity edge{1, loops_.rowCount()};
    const Index ends[] = {tail, head};
    checkLoop(ends, 2, edge);
    appendLoop(ends);
    return edge.index;
}

std::vector<Index> ComplexBuilder::dropUnusedVertices() {
    std::vector<bool> isUsed(vertexCount_, false);
    for (const Index vertex : corners_) isUsed[vertex] = true;
    std::vector<Index> dropped;
    for (Index vertex = 0; vertex < vertexCount_; ++vertex)
        if (!isUsed[vertex]) dropped.push_back(vertex);
    if (dropped.empty()) return dropped;
    std::vector<Index> newNumbers(isUsed.size());
    Index next = 0;
    for (std::size_t vertex = 0; vertex < isUsed.size(); ++vertex)
        newNumbers[vertex] = isUsed[vertex] ? next++ : -1;
    for (Index& vertex : corners_) vertex = newNumbers[vertex];
    vertexCount_ = next;
    return dropped;
}

namespace {

/// The loops of a builder.
struct Loops {
    const RowStarts& starts;
    std::span<const Index> corners;

    Index count() const { return starts.rowCount(); }
    std::span<const Index> operator[](Index loop) const {
        return corners.subspan(starts[loop], starts[loop + 1] - starts[loop]);
    }
};

/// Numbers lists of vertices in the order of their first appearance. Equal lists get one number.
///
/// A hash table. The bucket of a list moves by k if all its vertices move by k: in a lattice whose
/// vertices are numbered row by row, successive searches look at memory that is near. A file can
/// choose its vertices so that all lists have one bucket; lists that a full bucket does not take
/// are in a sorted map.
class Numbering {
public:
    /// \param expected the most numbers that are to be expected; more are allowed
    Numbering(Index vertexCount, Offset expected)
        : latest_(std::bit_ceil(static_cast<std::size_t>(vertexCount) + 1), kNone) {
        before_.reserve(expected);
    }

    /// Returns the number of a list; count() before the call if the list is new.
    /// \param isEqual called with numbers; returns true for the number of this list
    /// \cost O(1) on average, O(log n) at most
    template <class IsEqual>
    Index find(std::span<const Index> vertices, IsEqual isEqual) {
        Index& latest = latest_[bucketOf(vertices)];
        int room = kBucketSize;
        for (Index number = latest; number != kNone; number = before_[number], --room)
            if (isEqual(number)) return number;
        if (room == 0) return findInMap(vertices, isEqual);
        before_.push_back(latest);
        return latest = count() - 1;
    }

    /// Returns a number that find() never returns.
    Index addSeparate() {
        before_.push_back(kNone);
        return count() - 1;
    }

    Index count() const { return static_cast<Index>(before_.size()); }

private:
    static constexpr Index kNone = -1;

    // A vertex of a lattice of tetrahedra has about 12 faces and a bucket of its own, so by chance
    // hardly a bucket has five times as many.
    static constexpr int kBucketSize = 64;

    template <class IsEqual>
    Index findInMap(std::span<const Index> vertices, IsEqual isEqual) {
        std::vector<Index> key;
        appendCanonicalLoop(vertices, key);
        const auto [known, isNew] = others_.try_emplace(std::move(key), count());
        // Only loops that repeat a vertex may have one key and be different.
        return !isNew && isEqual(known->second) ? known->second : addSeparate();
    }

    /// The bucket does not depend on the order of the vertices.
    std::size_t bucketOf(std::span<const Index> vertices) const {
        std::uint64_t low = vertices[0], sum = 0;
        for (const Index vertex : vertices) {
            low = std::min(low, std::uint64_t(vertex));
            sum += vertex;
        }
        const std::uint64_t hash = low + (sum - vertices.size() * low) * kHashFactor;
        return hash & (latest_.size() - 1);
    }

    Array<Index> latest_;                         ///< the latest number in each bucket
    Array<Index> before_;                         ///< the number before each number in its bucket
    std::map<std::vector<Index>, Index> others_;  ///< the rest of full buckets, by canonical loop
};

/// Returns +1 if two loops without repeated vertices are the same face and run in the same
/// direction, −1 if they are the same face and run in opposite directions, 0 for different faces.
int relativeDirection(std::span<const Index> loop, std::span<const Index> reference) {
    const std::size_t n = loop.size();
    if (reference.size() != n) return 0;
    const std::size_t at =
        std::find(reference.begin(), reference.end(), loop[0]) - reference.begin();
    if (at == n) return 0;
    const bool isForward = reference[at + 1 < n ? at + 1 : 0] == loop[1];
    std::size_t place = at;
    for (const Index vertex : loop) {
        if (reference[place] != vertex) return 0;
        if (isForward)
            place = place + 1 < n ? place + 1 : 0;
        else
            place = place > 0 ? place - 1 : n - 1;
    }
    return isForward ? 1 : -1;
}

/// Finds the steps of a loop that are separate edges: steps from a vertex to itself, and steps
/// between two vertices that the loop has joined before. Returns one value per step; none if the
/// loop passes each vertex once.
std::vector<bool> separateSteps(std::span<const Index> loop) {
    if (!repeatedIn(loop)) return {};
    std::vector<std::array<Index, 3>> sorted;  // the two ends, and the step
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const auto [low, high] = std::minmax(loop[i], loop[(i + 1) % loop.size()]);
        sorted.push_back({low, high, static_cast<Index>(i)});
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<bool> areSeparate(loop.size(), false);
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        const auto& [low, high, step] = sorted[i];
        areSeparate[step] =
            low == high || (i > 0 && sorted[i - 1][0] == low && sorted[i - 1][1] == high);
    }
    return areSeparate;
}

/// The entries of a SignedIncidence, in the order of its rows.
struct SignedArrays {
    Array<Index> values;
    Array<std::int8_t> signs;

    void reserve(std::size_t count) {
        values.reserve(count);
        signs.reserve(count);
    }
    void add(Index value, int sign) {
        values.push_back(value);
        signs.push_back(static_cast<std::int8_t>(sign));
    }
    SignedIncidence relation(RowStarts starts) {
        return {{std::move(starts), std::move(values)}, std::move(signs)};
    }
};

/// The relations of the edges of some loops.
struct Edges {
    SignedIncidence ends;     ///< edge → (tail, head), in the direction of the edge's first step
    SignedIncidence ofFaces;  ///< face → (edge, sign), in the order of its loop

    /// \param faces for each face its loop
    Edges(Index vertexCount, const Loops& loops, std::span<const Index> faces) {
        RowStarts starts;
        for (const Index face : faces) starts.append(static_cast<Index>(loops[face].size()));
        const Offset stepCount = starts[starts.rowCount()];
        SignedArrays edgeEnds, faceEdges;
        faceEdges.reserve(stepCount);
        // In most complexes at least two faces share an edge. Memory that is reserved and not used
        // costs nothing, while a growing array is copied, and exists twice meanwhile.
        edgeEnds.reserve(stepCount);
        Numbering edges(vertexCount, stepCount / 2);
        for (std::size_t number = 0; number < faces.size(); ++number) {
            checkCancelledEvery(number, kBitsBetweenPolls);
            const auto loop = loops[faces[number]];
            const std::vector<bool> areSeparate = separateSteps(loop);
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const Index tail = loop[i], head = loop[i + 1 < loop.size() ? i + 1 : 0];
                const auto isEqual = [&](Index edge) {
                    const Index* known = &edgeEnds.values[2 * std::size_t(edge)];
                    return (known[0] == tail && known[1] == head) ||
                           (known[0] == head && known[1] == tail);
                };
                const Index next = edges.count();
                const Index step[] = {tail, head};
                const Index edge = !areSeparate.empty() && areSeparate[i]
                                       ? edges.addSeparate()
                                       : edges.find(step, isEqual);
                if (edge == next) {
                    edgeEnds.add(tail, -1);
                    edgeEnds.add(head, +1);
                }
                faceEdges.add(edge, edgeEnds.values[2 * std::size_t(edge)] == tail ? 1 : -1);
            }
        }
        ends = edgeEnds.relation(RowStarts(edges.count(), 2));
        ofFaces = faceEdges.relation(std::move(starts));
    }
};

/// Two loops that both are to be reversed or both not; or exactly one of them, if not `sameTurn`.
struct LoopPair {
    Index a;
    Index b;
    bool sameTurn;
};

/// Finds which loops of a lattice to reverse so that all run anticlockwise seen from outside their
/// cells. Directions depend on each other in pairs: two loops of one cell that share an edge must
/// run along it in opposite directions, and the two loops of one face must also be opposite. In
/// each connected piece, the smaller number of loops is reversed. Pairs that cannot be satisfied
/// are left to validate(), which names them. Returns −1 for each loop to reverse, +1 for the
/// others.
std::vector<int> turnsOf(Index loopCount, const std::vector<LoopPair>& pairs) {
    std::vector<std::vector<LoopPair>> pairsOf(loopCount);
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
        checkCancelledEvery(pair, kBitsBetweenPolls);
        const auto& [a, b, sameTurn] = pairs[pair];
        pairsOf[a].push_back({a, b, sameTurn});
        pairsOf[b].push_back({b, a, sameTurn});
    }
    std::vector<int> turn(loopCount, 0);
    std::vector<Index> piece;
    std::size_t reached = 0;
    for (Index start = 0; start < loopCount; ++start) {
        if (turn[start] != 0) continue;
        turn[start] = 1;
        piece.assign(1, start);
        int sum = 0;
        for (std::size_t next = 0; next < piece.size(); ++next) {
            checkCancelledEvery(reached++, kBitsBetweenPolls);
            sum += turn[piece[next]];
            for (const auto& [loop, other, sameTurn] : pairsOf[piece[next]]) {
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

/// Returns the pairs of loops of a lattice whose directions depend on each other. A loop is a face
/// of a cell. The number of a loop is its position in the relation from cells to faces.
std::vector<LoopPair> allLoopPairs(const CellComplex& lattice) {
    std::vector<LoopPair> pairs;
    // One number for each step of a loop, so that sorting is fast: the edge, the loop, and whether
    // the step runs against the edge.
    std::vector<std::uint64_t> sides;
    const auto edgeOf = [](std::uint64_t side) { return side >> 32; };
    const auto loopOf = [](std::uint64_t side) {
        return static_cast<Index>(static_cast<std::uint32_t>(side) >> 1);
    };
    const SignedIncidence& faces = lattice.boundary(3);
    const SignedIncidence& edges = lattice.boundary(2);
    for (Index cell = 0; cell < lattice.count(3); ++cell) {
        checkCancelledEvery(cell, kBitsBetweenPolls);
        sides.clear();
        auto loop = static_cast<std::uint64_t>(faces.unsignedRows().offset(cell));
        for (std::size_t f = 0; f < faces[cell].size(); ++f, ++loop) {
            const Index face = faces[cell][f];
            for (std::size_t i = 0; i < edges[face].size(); ++i) {
                const bool isAgainst = faces.signs(cell)[f] != edges.signs(face)[i];
                sides.push_back(std::uint64_t(edges[face][i]) << 32 | loop << 1 |
                                std::uint64_t(isAgainst));
            }
        }
        std::sort(sides.begin(), sides.end());
        for (std::size_t i = 0; i + 1 < sides.size(); ++i)
            if (edgeOf(sides[i]) == edgeOf(sides[i + 1]))
                pairs.push_back(
                    {loopOf(sides[i]), loopOf(sides[i + 1]), (sides[i] & 1) != (sides[i + 1] & 1)});
    }
    std::vector<Index> firstLoop(lattice.count(2), -1);  // per face
    const auto values = faces.unsignedRows().values();
    for (std::size_t at = 0; at < values.size(); ++at) {
        const auto loop = static_cast<Index>(at);
        Index& first = firstLoop[values[at]];
        if (first < 0)
            first = loop;
        else
            pairs.push_back({first, loop, faces.signs()[at] < 0});
    }
    return pairs;
}

/// Returns the lattice with its loops reversed as turnsOf() says.
/// \param lattice the sign of a face in a cell is −1 if its loop runs against its first loop
CellComplex oriented(const CellComplex& lattice) {
    const SignedIncidence& faces = lattice.boundary(3);
    Array<std::int8_t> signs(faces.signs().begin(), faces.signs().end());
    const std::vector<int> turns = turnsOf(static_cast<Index>(signs.size()), allLoopPairs(lattice));
    for (std::size_t loop = 0; loop < signs.size(); ++loop)
        signs[loop] = static_cast<std::int8_t>(turns[loop] * signs[loop]);
    return CellComplex(3, lattice.count(0),
                       {lattice.boundary(1), lattice.boundary(2),
                        SignedIncidence(faces.unsignedRows(), std::move(signs))});
}

/// Returns the lattice with loops directed as they are given.
CellComplex latticeOf(Index vertexCount, const Loops& loops, const RowStarts& cells) {
    Array<Index> firstLoops;  // per face
    SignedArrays cellFaces;
    cellFaces.reserve(loops.count());
    {
        firstLoops.reserve(loops.count());
        Numbering faces(vertexCount, loops.count());
        for (Index loop = 0; loop < loops.count(); ++loop) {
            checkCancelledEvery(loop, kBitsBetweenPolls);
            int direction = 1;
            const Index face = faces.find(loops[loop], [&](Index known) {
                direction = relativeDirection(loops[loop], loops[firstLoops[known]]);
                return direction != 0;
            });
            if (face == std::ssize(firstLoops)) {
                firstLoops.push_back(loop);
                direction = 1;
            }
            cellFaces.add(face, direction);
        }
    }
    Edges edges(vertexCount, loops, firstLoops);
    return CellComplex(
        3, vertexCount,
        {std::move(edges.ends), std::move(edges.ofFaces), cellFaces.relation(cells)});
}

CellComplex meshOf(Index vertexCount, const Loops& loops) {
    std::vector<Index> faces(loops.count());
    std::iota(faces.begin(), faces.end(), Index{0});
    Edges edges(vertexCount, loops, faces);
    return CellComplex(2, vertexCount, {std::move(edges.ends), std::move(edges.ofFaces), {}});
}

CellComplex curveOf(Index vertexCount, const Loops& loops) {
    SignedArrays ends;
    for (Index edge = 0; edge < loops.count(); ++edge) {
        checkCancelledEvery(edge, kBitsBetweenPolls);
        ends.add(loops[edge][0], -1);
        ends.add(loops[edge][1], +1);
    }
    return CellComplex(1, vertexCount, {ends.relation(RowStarts(loops.count(), 2)), {}, {}});
}

}  // namespace

CellComplex ComplexBuilder::build() const {
    if (std::ssize(corners_) > kMaxIndex)
        throw TopologyError(TopologyCause::TooManyEntities, {dimension_, kMaxIndex},
                            concat("the loops name ", corners_.size(),
                                   " vertices in all; the most is ", kMaxIndex));
    const Loops loops{loops_, corners_};
    CellComplex complex = dimension_ == 3   ? latticeOf(vertexCount_, loops, cells_)
                          : dimension_ == 2 ? meshOf(vertexCount_, loops)
                                            : curveOf(vertexCount_, loops);
    if (dimension_ == 3) {
        // Most lattices are oriented as they are given.
        if (isValidLattice(complex)) return complex;
        complex = oriented(complex);
    }
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
