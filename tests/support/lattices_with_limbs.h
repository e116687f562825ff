// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/inventory.h>
#include <espalier/shapes/remove_cells.h>

#include <algorithm>
#include <array>
#include <vector>

// Lattices of unit cubes with limbs.
namespace espalier::test {

/// Returns the unit cubes of a block of cubes whose lowest corners hasCube(x, y, z) accepts.
template <class HasCube>
Lattice cubes(const std::array<int, 3>& size, const HasCube& hasCube) {
    const Lattice block = shapes::box(
        {.cells = size, .min = {0, 0, 0}, .max = {1.0 * size[0], 1.0 * size[1], 1.0 * size[2]}});
    std::vector<Index> removed;
    for (Index cell = 0; cell < block.complex.count(3); ++cell) {
        Point3 low = {1e9, 1e9, 1e9};
        for (const Index vertex : block.complex.relation(3, 0)[cell])
            for (std::size_t c = 0; c < 3; ++c)
                low[c] = std::min(low[c], block.positions[vertex][c]);
        if (!hasCube(static_cast<int>(low[0] + 0.5), static_cast<int>(low[1] + 0.5),
                     static_cast<int>(low[2] + 0.5)))
            removed.push_back(cell);
    }
    return shapes::removeCells(block, removed);
}

/// A body of 4 × 4 × 6 cubes, from x = 5 to 9, and two arms of 2 × 2 × 5 cubes along x, at
/// 1 ≤ y ≤ 3 and 4 ≤ z ≤ 6.
inline Lattice figure() {
    return cubes({14, 4, 6}, [](int x, int y, int z) {
        return (x >= 5 && x < 9) || (y >= 1 && y < 3 && z >= 4);
    });
}

/// Two legs of 1 × 1 × 4 cubes, at x = 0 and x = 2, and a cube between them at z = 0.
inline Lattice twoLegs() {
    return cubes({3, 1, 4}, [](int x, int, int z) { return x != 1 || z == 0; });
}

}  // namespace espalier::test
