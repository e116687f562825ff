// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_match.h>

#include <algorithm>
#include <numeric>

#include "canonical_loop.h"

namespace espalier::far {
namespace {

/// Returns a cell of any dimension as numbers that do not depend on how it was written: for each of
/// its sides in ascending order, the length and the canonical loop of the side.
std::vector<Index> canonicalCell(const CellComplex& complex, Index cell) {
    const int dimension = complex.dimension();
    std::vector<std::vector<Index>> sides;
    for (const Index side : complex.boundary(dimension)[cell]) {
        const auto vertices = complex.relation(dimension - 1, 0)[side];
        std::vector<Index> key = {static_cast<Index>(vertices.size())};
        appendCanonicalLoop(vertices, key);
        sides.push_back(std::move(key));
    }
    std::sort(sides.begin(), sides.end());
    std::vector<Index> result;
    for (const auto& side : sides) result.insert(result.end(), side.begin(), side.end());
    return result;
}

struct NumberedCell {
    std::vector<Index> key;
    Index cell;
    friend auto operator<=>(const NumberedCell&, const NumberedCell&) = default;
};

std::vector<NumberedCell> sortedCells(const CellComplex& complex) {
    std::vector<NumberedCell> cells;
    for (Index cell = 0; cell < complex.count(complex.dimension()); ++cell)
        cells.push_back({canonicalCell(complex, cell), cell});
    std::sort(cells.begin(), cells.end());
    return cells;
}

/// FNV-1a over the bytes of numbers, lowest byte first.
class Fnv1a {
public:
    void add(std::uint64_t number) {
        for (int byte = 0; byte < 8; ++byte) {
            value_ = (value_ ^ (number & 0xff)) * 0x100000001b3u;
            number >>= 8;
        }
    }
    std::uint64_t value() const { return value_; }

private:
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
    for (std::size_t i = 0; i < firstCells.size(); ++i) {
        const auto& [firstKey, firstCell] = firstCells[i];
        const auto& [secondKey, secondCell] = secondCells[i];
        if (firstKey == secondKey) continue;
        const bool isInFirst = firstKey < secondKey;
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
    for (const NumberedCell& cell : sortedCells(complex)) {
        hash.add(cell.key.size());
        for (const Index number : cell.key) hash.add(static_cast<std::uint64_t>(number));
    }
    return hash.value();
}

}  // namespace espalier::far
