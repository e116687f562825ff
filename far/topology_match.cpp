// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/far/topology_match.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

#include "canonical_loop.h"

namespace espalier::far {
namespace {

using Row = std::span<const Index>;

bool isLess(Row a, Row b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

/// Appends a cell of any dimension as numbers that do not depend on how it was written: for each of
/// its sides in ascending order, the length and the canonical loop of the side.
void appendCanonicalCell(const CellComplex& complex, Index cell, std::vector<Index>& out) {
    const int dimension = complex.dimension();
    const Row boundary = complex.boundary(dimension)[cell];
    const Incidence& loops = complex.relation(dimension - 1, 0);
    std::vector<Index> keys;
    std::vector<Row> sides;
    std::size_t size = 0;
    for (const Index side : boundary) size += 1 + loops[side].size();
    keys.reserve(size);  // Spans of it stay valid.
    sides.reserve(boundary.size());
    for (const Index side : boundary) {
        const Row loop = loops[side];
        keys.push_back(static_cast<Index>(loop.size()));
        appendCanonicalLoop(loop, keys);
        sides.push_back(Row(keys).last(1 + loop.size()));
    }
    std::sort(sides.begin(), sides.end(), isLess);
    for (const Row side : sides) out.insert(out.end(), side.begin(), side.end());
}

/// The cells of a complex as numbers, and their order.
struct SortedCells {
    Incidence keys;            ///< the key of each cell
    std::vector<Index> order;  ///< the cells by their keys; cells with equal keys by their numbers
};

SortedCells sortedCells(const CellComplex& complex) {
    SortedCells cells;
    const Index count = complex.count(complex.dimension());
    cells.keys = Incidence(buildRows<Index>(count, [&](Index cell, std::vector<Index>& out) {
        appendCanonicalCell(complex, cell, out);
    }));
    cells.order.resize(count);
    std::iota(cells.order.begin(), cells.order.end(), Index{0});
    const auto isBefore = [&](Index a, Index b) {
        const Row first = cells.keys[a], second = cells.keys[b];
        return isLess(first, second) || (a < b && !isLess(second, first));
    };
    // The cells of many lattices are sorted as they are.
    if (!std::is_sorted(cells.order.begin(), cells.order.end(), isBefore))
        sortCancellably(cells.order.begin(), cells.order.end(), isBefore);
    return cells;
}

/// FNV-1a over the bytes of numbers, lowest byte first.
class Fnv1a {
public:
    void add(std::uint64_t number) {
        int byte = 0;
        for (; number != 0; ++byte, number >>= 8) value_ = (value_ ^ (number & 0xff)) * kPrime;
        value_ *= kPowers[8 - byte];  // The other bytes are 0.
    }
    std::uint64_t value() const { return value_; }

private:
    static constexpr std::uint64_t kPrime = 0x100000001b3u;
    static constexpr std::array<std::uint64_t, 9> kPowers = [] {
        std::array<std::uint64_t, 9> powers = {1};
        for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = powers[i - 1] * kPrime;
        return powers;
    }();

    std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace

std::optional<std::string> topologyDifference(const CellComplex& first, const CellComplex& second) {
    if (first.dimension() != second.dimension())
        return concat("the dimensions differ: the first has ", first.dimension(), ", the second ",
                      second.dimension());
    const int dimension = first.dimension();
    for (const int d : {0, dimension})
        if (first.count(d) != second.count(d))
            return concat("the numbers of ", d == 0 ? "vertices" : "cells",
                          " differ: the first has ", first.count(d), ", the second ",
                          second.count(d));
    const auto firstCells = sortedCells(first), secondCells = sortedCells(second);
    for (std::size_t i = 0; i < firstCells.order.size(); ++i) {
        const Index firstCell = firstCells.order[i], secondCell = secondCells.order[i];
        const Row firstKey = firstCells.keys[firstCell], secondKey = secondCells.keys[secondCell];
        const bool isInFirst = isLess(firstKey, secondKey);
        if (!isInFirst && !isLess(secondKey, firstKey)) continue;
        return concat(dimensionName(dimension), " ", isInFirst ? firstCell : secondCell, " of the ",
                      isInFirst ? "first" : "second",
                      " has no counterpart on the same vertices in the ",
                      isInFirst ? "second" : "first");
    }
    return std::nullopt;
}

std::uint64_t topologyHash(const CellComplex& complex) {
    Fnv1a hash;
    hash.add(static_cast<std::uint64_t>(complex.dimension()));
    hash.add(static_cast<std::uint64_t>(complex.count(0)));
    const SortedCells cells = sortedCells(complex);
    for (const Index cell : cells.order) {
        hash.add(cells.keys[cell].size());
        for (const Index number : cells.keys[cell]) hash.add(static_cast<std::uint64_t>(number));
    }
    return hash.value();
}

}  // namespace espalier::far
