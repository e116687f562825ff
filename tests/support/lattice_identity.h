// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/standard_cells.h>
#include <espalier/shapes/lattice.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

// Compares lattices.

namespace espalier::test {

/// Returns the faces of each cell as loops anticlockwise from outside, in an order that does not
/// depend on where loops start or how faces are ordered.
inline std::vector<std::vector<std::vector<Index>>> orientedCells(const far::CellComplex& complex) {
    std::vector<std::vector<std::vector<Index>>> cells;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        auto loops = far::outwardLoops(complex, CellId(cell));
        for (auto& loop : loops)
            std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
        std::sort(loops.begin(), loops.end());
        cells.push_back(loops);
    }
    return cells;
}

inline std::vector<std::uint64_t> bitsOf(const std::vector<double>& values) {
    std::vector<std::uint64_t> bits;
    for (const double value : values) bits.push_back(std::bit_cast<std::uint64_t>(value));
    return bits;
}

inline std::vector<std::uint64_t> bitsOf(const std::vector<Point3>& points) {
    std::vector<double> values;
    for (const Point3& point : points) values.insert(values.end(), point.begin(), point.end());
    return bitsOf(values);
}

}  // namespace espalier::test
