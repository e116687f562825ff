// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/refinement.h>
#include <espalier/far/topology_refiner.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

double pairs(const CellComplex& complex, int from, int to) {
    return from > complex.dimension() ? 0 : double(complex.relation(from, to).values().size());
}

void expectSizesOfLevels(const CellComplex& base, int levels) {
    TopologyRefiner refiner = refined(base, levels);
    for (int level = 0; level <= levels; ++level) {
        const CellComplex& complex = refiner.level(level).complex;
        const LevelSize size = levelSize(base, level);
        for (int d = 0; d <= kMaxDimension; ++d)
            EXPECT_EQ(size.counts[d], d <= base.dimension() ? complex.count(d) : 0)
                << "level " << level << " dimension " << d;
        EXPECT_EQ(size.faceEdges, pairs(complex, 2, 1)) << level;
        EXPECT_EQ(size.cellFaces, pairs(complex, 3, 2)) << level;
        EXPECT_EQ(size.cellEdges, pairs(complex, 3, 1)) << level;
        EXPECT_EQ(size.cellVertices, pairs(complex, 3, 0)) << level;
    }
}

TEST(LevelSize, EqualsTheSizeOfRefinedLevels) {
    expectSizesOfLevels(mixedCells(), 3);
    expectSizesOfLevels(bipyramid(7), 3);
    expectSizesOfLevels(grid({3, 2, 1}), 3);
    expectSizesOfLevels(buildMesh(5, {{{0, 1, 2, 3}, {3, 2, 4}}}), 3);
    expectSizesOfLevels(buildCurve(5, true), 3);
}

// No machine can hold this level: a cube has 8ⁿ cells on level n.
TEST(LevelSize, IsComputedForLevelsTooLargeToBuild) {
    const LevelSize size = levelSize(singleCell(StandardCell::Hexahedron), 30);
    EXPECT_EQ(size.counts[3], std::ldexp(1, 90));
    EXPECT_GT(size.bytes(), 10 * std::ldexp(1, 90));
}

// Takes no time: a loop through 2³¹ levels, a thousand times, would exceed CTest's time limit.
TEST(LevelSize, HighestLevelTakesNoLonger) {
    const CellComplex cube = singleCell(StandardCell::Hexahedron);
    for (int i = 0; i < 1000; ++i)
        for (const double count : levelSize(cube, std::numeric_limits<int>::max()).counts)
            EXPECT_TRUE(std::isinf(count));
}

}  // namespace
}  // namespace espalier::far
