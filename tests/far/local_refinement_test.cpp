// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_refiner.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

/// Maps each entity of each level of a part to the same entity in the whole level.
class Correspondence {
public:
    Correspondence(const TopologyRefiner& part, const TopologyRefiner& whole) {
        for (int k = 0; k <= part.maxLevel(); ++k) {
            levels_.emplace_back();
            if (k == 0) {
                for (int d = 0; d <= part.dimension(); ++d)
                    for (Index i = 0; i < part.level(0).complex.count(d); ++i)
                        levels_[0][d].push_back(i);
                continue;
            }
            part.refinement(k).forEachChild([&](const Entity& child, const Interval& interval) {
                const auto same = whole.refinement(k).childOf(
                    {of(k - 1, interval.lower), of(k - 1, interval.upper)});
                levels_.back()[child.dimension].push_back(same.value().index);
            });
        }
    }

    Entity of(int level, const Entity& entity) const {
        return {entity.dimension, ofDimension(level, entity.dimension)[entity.index]};
    }
    const std::vector<Index>& ofDimension(int level, int dimension) const {
        return levels_[level][dimension];
    }

private:
    std::vector<ByEntity<Index>> levels_;
};

std::vector<Index> mapped(const Correspondence& same, int level, int dimension,
                          std::span<const Index> row) {
    std::vector<Index> result;
    for (const Index index : row) result.push_back(same.of(level, {dimension, index}).index);
    return result;
}

std::vector<Index> copyOf(std::span<const Index> row) {
    return {row.begin(), row.end()};
}

/// Returns the children of `cells` in the finest level.
std::vector<Index> childrenOf(const TopologyRefiner& refiner, const std::vector<Index>& cells) {
    std::vector<Index> children;
    const int d = refiner.dimension();
    refiner.refinement(refiner.maxLevel())
        .forEachChild(0, d, [&](const Entity& child, const Interval& interval) {
            if (std::binary_search(cells.begin(), cells.end(), interval.upper.index))
                children.push_back(child.index);
        });
    return children;
}

/// Checks that the finest level, which was refined around `cells`, agrees with the whole level as
/// far as refineAround() documents.
void expectLikeWhole(const TopologyRefiner& part, const TopologyRefiner& whole,
                     const std::vector<Index>& cells) {
    const int k = part.maxLevel(), d = part.dimension();
    const Correspondence same(part, whole);
    const Level &ours = part.level(k), &theirs = whole.level(k);
    for (int dimension = 0; dimension <= d; ++dimension) {
        const auto& all = same.ofDimension(k, dimension);
        EXPECT_TRUE(std::is_sorted(all.begin(), all.end())) << "dimension " << dimension;
    }
    for (const Index child : childrenOf(part, cells))
        for (const Index vertex : ours.complex.relation(d, 0)[child])
            for (int dimension = 0; dimension <= d; ++dimension) {
                // Everything around the vertex exists,
                const auto around = ours.complex.relation(0, dimension)[vertex];
                const Index itself = same.of(k, {0, vertex}).index;
                EXPECT_EQ(mapped(same, k, dimension, around),
                          copyOf(theirs.complex.relation(0, dimension)[itself]));
                for (const Index index : around) {
                    // has the same boundary as in the whole level,
                    const Entity entity{dimension, index}, other = same.of(k, entity);
                    if (dimension > 0) {
                        EXPECT_EQ(
                            mapped(same, k, dimension - 1, ours.complex.boundary(dimension)[index]),
                            copyOf(theirs.complex.boundary(dimension)[other.index]));
                    }
                    // and has the same stratum, openness and sharpness.
                    EXPECT_EQ(ours.strata.of(entity), theirs.strata.of(other));
                    EXPECT_EQ(ours.strata.smoothStratum(entity),
                              theirs.strata.smoothStratum(other));
                    EXPECT_EQ(ours.strata.isOpen(entity), theirs.strata.isOpen(other));
                    if (dimension < 2) {
                        EXPECT_EQ(ours.strata.sharpness(entity), theirs.strata.sharpness(other));
                    }
                }
            }
}

/// Returns marks of each kind.
Marks marksOf(const CellComplex& complex) {
    Marks marks;
    for (Index edge = 0; edge < complex.count(1); edge += 7) {
        const auto ends = complex.relation(1, 0)[edge];
        marks.edges.push_back({{ends[0], ends[1]}, 0.7F + float(edge % 4)});
    }
    marks.vertices.push_back({1, 1.5F});
    return marks;
}

TEST(LocalRefinement, IsAPartOfTheWholeLevel) {
    for (const CellComplex& base : {grid({4, 3, 3}), bipyramid(5), mixedCells(), gridMesh(5, 4)})
        for (const Boundary boundary : {Boundary::Sharp, Boundary::EdgeOnly, Boundary::Open})
            for (const Creasing creasing : {Creasing::Uniform, Creasing::Chaikin}) {
                const RefinerOptions options{
                    .boundary = boundary, .creasing = creasing, .marks = marksOf(base)};
                TopologyRefiner whole(base, options), part(base, options);
                try {
                    whole.refineUniform(3);
                } catch (const TopologyError&) {
                    continue;  // Without boundary control, no cell is left.
                }
                std::vector<Index> cells = {base.count(base.dimension()) / 2};
                for (int level = 1; level <= 3; ++level) {
                    part.refineAround(cells);
                    expectLikeWhole(part, whole, cells);
                    // Continue around all children, or around every third.
                    const auto children = childrenOf(part, cells);
                    cells.clear();
                    for (std::size_t i = 0; i < children.size(); i += level == 2 ? 3 : 1)
                        cells.push_back(children[i]);
                    if (cells.empty()) break;
                }
            }
}

TEST(LocalRefinement, RefinesOnlyWhatIsNeeded) {
    TopologyRefiner refiner(grid({9, 9, 9}));
    const std::vector<Index> middle = {4 * 81 + 4 * 9 + 4};
    refiner.refineAround(middle);
    // The eight children and one layer around them.
    EXPECT_EQ(refiner.level(1).complex.count(3), 4 * 4 * 4);
    EXPECT_FALSE(refiner.isUniform());
    const std::vector<Index> child = {childrenOf(refiner, middle)[0]};
    refiner.refineAround(child);
    EXPECT_EQ(refiner.level(2).complex.count(3), 4 * 4 * 4);
}

TEST(LocalRefinement, ExtentCellsRefinesOnlyTheChildren) {
    TopologyRefiner refiner(grid({5, 5, 5}));
    refiner.refineAround(std::vector<Index>{62, 63}, TopologyRefiner::Extent::Cells);
    const CellComplex& children = refiner.level(1).complex;
    const CellComplex expected = grid({4, 2, 2});
    for (int d = 0; d <= 3; ++d) EXPECT_EQ(children.count(d), expected.count(d));
    EXPECT_NO_THROW(validate(children));
    EXPECT_THROW(refiner.refineAround(std::vector<Index>{0}), Error);
    EXPECT_THROW(refiner.refineUniform(2), Error);
}

TEST(LocalRefinement, RefusesCellsThatLackNeighbours) {
    TopologyRefiner refiner(grid({3, 3, 3}));
    const auto expectRefused = [&](const std::vector<Index>& cells, const std::string& why) {
        const int level = refiner.maxLevel();
        EXPECT_REFUSED(Error, why, refiner.refineAround(cells));
        EXPECT_EQ(refiner.maxLevel(), level);
    };
    expectRefused({}, "no cell");
    expectRefused({27}, "cell 27 of level 0: there is no such cell");
    expectRefused({-1}, "cell -1");
    expectRefused({3, 2}, "cell 2 of level 0: cells must ascend");
    refiner.refineAround(std::vector<Index>{13});
    const auto children = childrenOf(refiner, {13});
    Index outer = 0;
    while (std::binary_search(children.begin(), children.end(), outer)) ++outer;
    expectRefused({outer}, "was not refined around");
    EXPECT_THROW(refiner.refineUniform(2), Error);
    EXPECT_NO_THROW(refiner.refineUniform(1)) << "it is there";
    refiner.refineAround(children);
    EXPECT_EQ(refiner.maxLevel(), 2);
}

}  // namespace
}  // namespace espalier::far
