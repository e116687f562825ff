// SPDX-License-Identifier: Apache-2.0
#include "valid_lattice.h"

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/hash.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <vector>

namespace espalier::far {
namespace {

/// A value for each of a few numbers: a hash table that is cheap to empty.
class FewValues {
public:
    /// Empties the table.
    /// \param count upper bound of the number of keys
    void reset(std::size_t count) {
        if (slots_.size() < 2 * count) {
            const auto bits = static_cast<int>(std::bit_width(2 * count));
            slots_.assign(std::size_t{1} << bits, {});
            shift_ = 64 - bits;
            round_ = 0;
        }
        if (++round_ == 0) {
            std::fill(slots_.begin(), slots_.end(), Slot{});
            round_ = 1;
        }
    }

    /// Returns the value of a key; 0 at first.
    Index& operator[](Index key) {
        std::size_t at = (static_cast<std::uint64_t>(key) * kHashFactor) >> shift_;
        while (slots_[at].round == round_ && slots_[at].key != key)
            at = (at + 1) & (slots_.size() - 1);
        if (slots_[at].round != round_) slots_[at] = {round_, key, 0};
        return slots_[at].value;
    }

private:
    struct Slot {
        std::uint32_t round = 0;  ///< the slot is empty unless this is round_
        Index key = 0;
        Index value = 0;
    };
    std::vector<Slot> slots_;
    std::uint32_t round_ = 0;
    int shift_ = 63;
};

/// Returns true if a relation has signs of ±1 and names all of `count` entities and no other.
bool namesAll(const SignedIncidence& relation, Index count) {
    const auto isSign = [](std::int8_t sign) { return sign == 1 || sign == -1; };
    if (!std::all_of(relation.signs().begin(), relation.signs().end(), isSign)) return false;
    std::vector<bool> isNamed(count, false);
    const auto values = relation.unsignedRows().values();
    for (std::size_t i = 0; i < values.size(); ++i) {
        checkCancelledEvery(i, 16);
        if (values[i] < 0 || values[i] >= count) return false;
        isNamed[values[i]] = true;
    }
    return std::find(isNamed.begin(), isNamed.end(), false) == isNamed.end();
}

/// Returns the vertex where a face enters (end 0) or leaves (end 1) an edge of its loop.
Index vertexOf(const SignedIncidence& ends, Index edge, std::int8_t sign, int end) {
    return ends[edge][sign > 0 ? end : 1 - end];
}

/// Checks edges, faces and cells, and reuses its memory.
class LatticeCheck {
public:
    explicit LatticeCheck(const CellComplex& complex)
        : ends_(complex.boundary(1)), edges_(complex.boundary(2)), faces_(complex.boundary(3)) {}

    /// Returns true if an edge runs from its first vertex to another one, its second.
    bool isEdge(Index edge) {
        return ends_[edge].size() == 2 && ends_[edge][0] != ends_[edge][1] &&
               ends_.signs(edge)[0] == -1 && ends_.signs(edge)[1] == 1;
    }

    /// Returns true if a face is a loop of three or more different vertices.
    bool isLoop(Index face) {
        const auto edges = edges_[face];
        const auto signs = edges_.signs(face);
        if (edges.size() < 3) return false;
        loop_.clear();
        Index last = vertexOf(ends_, edges.back(), signs.back(), 1);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            if (vertexOf(ends_, edges[i], signs[i], 0) != last) return false;
            loop_.push_back(last);
            last = vertexOf(ends_, edges[i], signs[i], 1);
        }
        return !repeatedIn(loop_);
    }

    /// Returns true if the faces of a cell form a sphere.
    ///
    /// If each edge has two sides with opposite directions, the faces form closed surfaces, except
    /// that several vertices of these surfaces may be one vertex of the cell. One closed surface
    /// has an Euler characteristic of 2 if it is a sphere and less otherwise, and each vertex that
    /// is missing decreases the sum below. So the sum is 2 for a sphere only.
    bool isSphere(Index cell) {
        const auto faces = faces_[cell];
        const auto faceSigns = faces_.signs(cell);
        if (repeatedIn(faces)) return false;
        std::size_t sideCount = 0;
        for (const Index face : faces) sideCount += edges_[face].size();
        // Per edge, the first side: the number of its face in the cell, counted from 1, with the
        // sign of the edge; then kTwoSides.
        constexpr Index kTwoSides = std::numeric_limits<Index>::max();
        firstSides_.reset(sideCount);
        isVertex_.reset(sideCount);
        pieces_.reset(faces.size());
        std::size_t edgeCount = 0, vertexCount = 0;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const auto edges = edges_[faces[f]];
            const auto signs = edges_.signs(faces[f]);
            for (std::size_t i = 0; i < edges.size(); ++i) {
                const auto side = static_cast<Index>(f + 1) * faceSigns[f] * signs[i];
                Index& first = firstSides_[edges[i]];
                if (first == 0) {
                    first = side;
                    ++edgeCount;
                } else {
                    if (first == kTwoSides || (first > 0) == (side > 0)) return false;
                    pieces_.join(std::abs(first) - 1, f);
                    first = kTwoSides;
                }
                Index& isKnown = isVertex_[vertexOf(ends_, edges[i], signs[i], 0)];
                vertexCount += isKnown == 0;
                isKnown = 1;
            }
        }
        return 2 * edgeCount == sideCount && pieces_.setCount() == 1 &&
               vertexCount + faces.size() == edgeCount + 2;
    }

private:
    const SignedIncidence& ends_;
    const SignedIncidence& edges_;
    const SignedIncidence& faces_;
    std::vector<Index> loop_;
    FewValues firstSides_;
    FewValues isVertex_;
    DisjointSets pieces_{0};
};

/// Returns true if all entities of a dimension pass a check.
bool allPass(const CellComplex& complex, int dimension, bool (LatticeCheck::*passes)(Index)) {
    std::atomic<bool> allDo = true;
    parallelFor(complex.count(dimension), 4096, [&](Offset first, Offset last) {
        LatticeCheck check(complex);
        for (; first < last; ++first)
            if (!(check.*passes)(static_cast<Index>(first))) {
                allDo = false;
                return;
            }
    });
    return allDo;
}

/// Returns true if each face has at most two cells, from opposite sides, and no two cells have the
/// same faces.
bool areCellsApart(const SignedIncidence& faces, Index faceCount) {
    // Per face: twice the number of its first cell, plus 1 if the sign is −1; kTwoCells after the
    // second cell.
    constexpr std::uint32_t kNoCell = 0xFFFFFFFF, kTwoCells = 0xFFFFFFFE;
    Array<std::uint32_t> firstSides(faceCount);
    std::fill(firstSides.begin(), firstSides.end(), kNoCell);
    for (Index cell = 0; cell < faces.unsignedRows().rowCount(); ++cell) {
        checkCancelledEvery(cell, 12);
        const auto row = faces[cell];
        const auto signs = faces.signs(cell);
        if (const std::uint32_t first = firstSides[row[0]]; first < kTwoCells) {
            const auto other = faces[static_cast<Index>(first / 2)];
            if (std::is_permutation(row.begin(), row.end(), other.begin(), other.end()))
                return false;
        }
        for (std::size_t f = 0; f < row.size(); ++f) {
            std::uint32_t& first = firstSides[row[f]];
            const std::uint32_t side = 2 * static_cast<std::uint32_t>(cell) + (signs[f] < 0);
            if (first == kTwoCells || (first != kNoCell && first % 2 == side % 2)) return false;
            first = first == kNoCell ? side : kTwoCells;
        }
    }
    return true;
}

}  // namespace

bool isValidLattice(const CellComplex& complex) {
    if (complex.dimension() != 3 || complex.count(0) < 0 || complex.count(3) == 0) return false;
    for (int d = 1; d <= 3; ++d)
        if (!namesAll(complex.boundary(d), complex.count(d - 1))) return false;
    return allPass(complex, 1, &LatticeCheck::isEdge) &&
           allPass(complex, 2, &LatticeCheck::isLoop) &&
           allPass(complex, 3, &LatticeCheck::isSphere) &&
           areCellsApart(complex.boundary(3), complex.count(2));
}

}  // namespace espalier::far
