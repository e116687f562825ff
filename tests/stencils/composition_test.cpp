// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/sparse_matrix.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "support/meshes.h"
#include "support/random_lattices.h"
#include "support/refined_lattice.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::stencils {
namespace {

using far::Boundary;
using far::TopologyRefiner;
using test::NamedLattice;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Calls check(name, refiner) for each lattice of the zoo, refined `level` times; with open
/// boundaries too, where enough is left.
template <class Check>
void forEachRefinedLattice(int level, Check check) {
    for (const auto& [name, lattice] : test::zoo())
        for (const Boundary boundary : {Boundary::Sharp, Boundary::Open}) {
            TopologyRefiner refiner(lattice.complex,
                                    {.boundary = boundary, .marks = lattice.marks});
            try {
                refiner.refineUniform(level);
            } catch (const far::TopologyError&) {
                ASSERT_EQ(boundary, Boundary::Open) << name;
                continue;
            }
            check(name + (boundary == Boundary::Open ? ", open" : ""), refiner, lattice);
        }
}

TEST(Stencils, RowsSumToOne) {
    forEachRefinedLattice(
        3, [](const std::string& name, const TopologyRefiner& refiner, const Lattice&) {
            for (const Rules rules : test::kLatticeRules)
                for (int level = 0; level <= 3; ++level) {
                    const auto table = buildStencils(refiner, level, rules);
                    ASSERT_EQ(table.rowCount(), refiner.level(level).complex.count(0));
                    ASSERT_EQ(table.columnCount(), refiner.level(0).complex.count(0));
                    for (Index row = 0; row < table.rowCount(); ++row) {
                        double sum = 0;
                        for (const double weight : table.weights(row)) sum += weight;
                        // The bound that the project promises.
                        ASSERT_NEAR(sum, 1, 1e-14) << name << " level " << level << " row " << row;
                    }
                }
        });
}

// Refining the image of the points under an affine map gives the image of the refined points.
TEST(Stencils, AreAffinelyInvariant) {
    const auto map = [](const Point3& p) {
        return Point3{2 * p[0] - 3 * p[1] + 0.5 * p[2] + 7, p[0] + p[1] - 4 * p[2] - 2,
                      0.25 * p[0] + 5 * p[2] + 1};
    };
    forEachRefinedLattice(
        2, [&](const std::string& name, const TopologyRefiner& refiner, const Lattice& lattice) {
            std::vector<Point3> images;
            for (const Point3& p : lattice.positions) images.push_back(map(p));
            for (const Rules rules : test::kLatticeRules) {
                const auto refined = refinePositions(refiner, 2, rules, lattice.positions);
                const auto refinedImages = refinePositions(refiner, 2, rules, images);
                for (std::size_t i = 0; i < refined.size(); ++i)
                    for (std::size_t c = 0; c < 3; ++c)
                        // Sums of some 60 products of size up to 50: 60 × 50 × 1e-16.
                        ASSERT_NEAR(refinedImages[i][c], map(refined[i])[c], 3e-13) << name;
            }
        });
}

TEST(Stencils, ComposedEqualsAppliedLevelByLevel) {
    forEachRefinedLattice(
        3, [](const std::string& name, const TopologyRefiner& refiner, const Lattice&) {
            const auto values = test::randomValues(
                static_cast<std::size_t>(refiner.level(0).complex.count(0)) * 2, 1);
            for (const Rules rules : test::kLatticeRules) {
                const auto stepwise = refineValues(refiner, 3, rules, values, 2);
                const auto table = buildStencils(refiner, 3, rules);
                for (Index row = 0; row < table.rowCount(); ++row)
                    for (std::size_t c = 0; c < 2; ++c) {
                        double sum = 0;
                        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                            sum += table.weights(row)[k] *
                                   values[2 * static_cast<std::size_t>(table.columns(row)[k]) + c];
                        // Values are below 1, rows have at most a few hundred entries.
                        ASSERT_NEAR(stepwise[2 * static_cast<std::size_t>(row) + c], sum, 1e-14)
                            << name;
                    }
            }
        });
}

/// A lattice or a mesh with a seventh of its edges and a thirteenth of its vertices sharp, at
/// random.
Lattice sharpened(Lattice lattice) {
    std::mt19937 random(1);
    const far::CellComplex& complex = lattice.complex;
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        const auto ends = complex.relation(1, 0)[edge];
        if (random() % 7 == 0)
            lattice.marks.edges.push_back({{ends[0], ends[1]}, far::kInfinitelySharp});
    }
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        if (random() % 13 == 0) lattice.marks.vertices.push_back({vertex, far::kInfinitelySharp});
    return lattice;
}

// Rows that are copies of others too: in regular bases nearly all are, and every feature must be
// where they end.
TEST(Stencils, AreTheProductsOfTheLevelTablesToTheLastBit) {
    std::vector<NamedLattice> shapes = test::zoo();
    for (auto& shape : test::featureLattices()) shapes.push_back(std::move(shape));
    for (auto& shape : test::meshZoo()) shapes.push_back(std::move(shape));
    for (unsigned seed = 0; seed < 4; ++seed)
        shapes.push_back({"seed " + std::to_string(seed), test::randomLattice(seed)});
    const Lattice box = shapes::box({.cells = {5, 4, 4}}), patch = test::patch(12);
    Lattice shuffled = box;
    shuffled.complex =
        test::relabelled(box.complex, test::shuffledIndices(box.complex.count(0), 7), 8);
    shapes.push_back({"regular box", box});
    shapes.push_back({"shuffled box", shuffled});
    shapes.push_back({"sharpened box", sharpened(box)});
    shapes.push_back({"regular patch", patch});
    shapes.push_back({"sharpened patch", sharpened(patch)});
    shapes.push_back({"more shapes than are remembered", sharpened(test::patch(48))});
    for (const auto& [name, lattice] : shapes) {
        TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
        const int finest = lattice.complex.count(0) < 20 ? 3 : 2;
        refiner.refineUniform(finest);
        for (const Rules rules : {Rules::Siggraph96, Rules::Mlca}) {
            if (rules == Rules::Mlca &&
                refiner.options().triangles == far::TriangleSubdivision::Smooth)
                continue;
            StencilTable<double> product = buildStencils(refiner, 0);
            for (int level = 1; level <= finest; ++level) {
                product = multiply(buildLevelTable(refiner, level, rules), product);
                ASSERT_EQ(buildStencils(refiner, level, rules), product)
                    << name << " level " << level;
            }
        }
    }
}

// The same sums in the same order: equal to the last bit.
TEST(Stencils, DemandedRowsAreTheRowsOfTheWholeTable) {
    forEachRefinedLattice(3, [](const std::string& name, const TopologyRefiner& refiner,
                                const Lattice&) {
        for (const Rules rules : test::kLatticeRules) {
            const auto whole = buildStencils(refiner, 3, rules);
            auto rows = test::shuffledIndices(whole.rowCount(), 3);
            rows.resize(std::min<std::size_t>(rows.size(), 20));
            rows.push_back(rows.front());
            const auto some = buildStencils(refiner, 3, rules, rows);
            ASSERT_EQ(some.rowCount(), static_cast<Index>(rows.size()));
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const auto row = static_cast<Index>(i);
                ASSERT_TRUE(std::ranges::equal(some.columns(row), whole.columns(rows[i]))) << name;
                ASSERT_TRUE(std::ranges::equal(some.weights(row), whole.weights(rows[i]))) << name;
            }
        }
    });
}

// Renaming vertices, reordering cells and faces, and rewinding loops permutes the table.
TEST(Stencils, RelabellingPermutesTheTable) {
    for (const auto& [name, lattice] : test::zoo()) {
        const auto names = test::shuffledIndices(lattice.complex.count(0), 5);
        far::Marks marks = lattice.marks;
        for (auto& edge : marks.edges)
            for (Index& vertex : edge.vertices) vertex = names[vertex];
        for (auto& mark : marks.vertices) mark.vertex = names[mark.vertex];
        TopologyRefiner first(lattice.complex, {.marks = lattice.marks});
        TopologyRefiner second(test::relabelled(lattice.complex, names, 6), {.marks = marks});
        first.refineUniform(2);
        second.refineUniform(2);
        const auto maps = test::matchLevels(first, second, names);
        for (const Rules rules : test::kLatticeRules) {
            const auto a = buildStencils(first, 2, rules), b = buildStencils(second, 2, rules);
            for (Index row = 0; row < a.rowCount(); ++row) {
                const Index image = maps[2][row];
                std::map<Index, double> expected, got;
                for (std::size_t k = 0; k < a.columns(row).size(); ++k)
                    expected[names[a.columns(row)[k]]] = a.weights(row)[k];
                for (std::size_t k = 0; k < b.columns(image).size(); ++k)
                    got[b.columns(image)[k]] = b.weights(image)[k];
                // A weight that cancels to 0 in one order of summing may not in the other.
                for (const auto& [column, weight] : expected)
                    ASSERT_NEAR(got[column], weight, 1e-15) << name << " row " << row;
                for (const auto& [column, weight] : got)
                    ASSERT_NEAR(expected[column], weight, 1e-15) << name << " row " << row;
            }
        }
    }
}

TEST(Stencils, DoNotDependOnTheNumberOfThreads) {
    const Lattice lattice = shapes::box({.cells = {5, 5, 5}});
    const auto build = [&](int threads) {
        return test::withThreads(threads, [&] {
            TopologyRefiner refiner(lattice.complex);
            refiner.refineUniform(2);
            return buildStencils(refiner, 2);
        });
    };
    EXPECT_EQ(build(1), build(2));
    EXPECT_EQ(build(1), build(8));
}

TEST(LevelTables, AreThoseOfTheLevelsInOrder) {
    TopologyRefiner refiner(test::bipyramid(5));
    refiner.refineUniform(2);
    EXPECT_EQ(buildLevelTables(refiner, 2),
              (std::vector{buildLevelTable(refiner, 1), buildLevelTable(refiner, 2)}));
    EXPECT_TRUE(buildLevelTables(refiner, 0).empty());
    EXPECT_THROW(buildLevelTables(refiner, 3), Error);
}

TEST(Stencils, LevelZeroIsTheIdentity) {
    const TopologyRefiner refiner(test::bipyramid(3));
    const auto table = buildStencils(refiner, 0);
    for (Index row = 0; row < 5; ++row) {
        EXPECT_THAT(table.columns(row), ElementsAre(row));
        EXPECT_THAT(table.weights(row), ElementsAre(1));
    }
}

// Derived by hand from section 2.2 for the cell point of a tetrahedron, and from section 3 for the
// rest: faces and edges of a single cell are on its surface and its edges, vertices are corners.
TEST(Stencils, GoldenRowsOfATetrahedron) {
    TopologyRefiner refiner(test::singleCell(far::StandardCell::Tetrahedron));
    refiner.refineUniform(1);
    const auto table = buildLevelTable(refiner, 1);
    ASSERT_EQ(table.rowCount(), 4 + 6 + 4 + 1);
    EXPECT_THAT(table.columns(2), ElementsAre(2));
    EXPECT_THAT(table.weights(2), ElementsAre(1));
    for (Index edge = 4; edge < 10; ++edge) EXPECT_THAT(table.weights(edge), ElementsAre(.5, .5));
    for (Index face = 10; face < 14; ++face)
        EXPECT_THAT(table.weights(face), ElementsAre(1. / 3, 1. / 3, 1. / 3));
    EXPECT_THAT(table.weights(14), ElementsAre(.25, .25, .25, .25));
}

// Two pyramids base to base, without marks, under Open they vanish; under Sharp the shared square
// is interior: its face point is (C0 + 2A + C1)/4 with C = (sum of base + apex)/5. Weights: base
// vertices (1/5 + 2/4 + 1/5)/4 = 9/40 each, apexes 1/20 each.
TEST(Stencils, GoldenFacePointBetweenTwoPyramids) {
    far::ComplexBuilder builder(3, 6);
    builder.addCell(far::StandardCell::Pyramid, {0, 1, 2, 3, 4});
    builder.addCell(far::StandardCell::Pyramid, {3, 2, 1, 0, 5});
    TopologyRefiner refiner(builder.build());
    refiner.refineUniform(1);
    const far::CellComplex& base = refiner.level(0).complex;
    Index between = 0;
    while (base.relation(2, 3)[between].size() != 2) ++between;
    const auto table = buildLevelTable(refiner, 1);
    const Index row = refiner.refinement(1).childOf({{2, between}, {2, between}})->index;
    const std::vector<double> expected = {.225, .225, .225, .225, .05, .05};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(table.weights(row)[i], expected[i], 1e-16);
}

// Catmull-Clark on the closed mesh of a cube, by hand. A vertex of valence 3 is (Ā + 2M̄)/3. Ā gives
// it 1/4, each of its 3 neighbours 1/6 and each of the 3 diagonals 1/12; M̄ gives it 1/2 and each
// neighbour 1/6. So 5/12, 1/6 and 1/36. An edge point is (A₀ + A₁ + P₀ + P₁)/4: 3/8 of each end,
// and 1/16 of each of the 4 other vertices of its faces.
TEST(Stencils, GoldenRowsOfTheSurfaceOfACube) {
    const auto mesh = far::buildMesh(8, far::faceLoops(far::StandardCell::Hexahedron));
    TopologyRefiner refiner(mesh);
    refiner.refineUniform(1);
    const auto table = buildLevelTable(refiner, 1);
    const auto sorted = [&](Index row) {
        std::vector<double> weights(table.weights(row).begin(), table.weights(row).end());
        std::sort(weights.begin(), weights.end());
        return weights;
    };
    for (Index vertex = 0; vertex < 8; ++vertex)
        EXPECT_THAT(sorted(vertex),
                    ::testing::Pointwise(::testing::DoubleEq(), {1. / 36, 1. / 36, 1. / 36, 1. / 6,
                                                                 1. / 6, 1. / 6, 5. / 12}));
    for (Index edge = 8; edge < 20; ++edge)
        EXPECT_THAT(sorted(edge), ElementsAre(1. / 16, 1. / 16, 1. / 16, 1. / 16, 3. / 8, 3. / 8));
    EXPECT_THAT(table.weights(20), ElementsAre(.25, .25, .25, .25));
}

// A bipyramid's axis, cut into wedges: its n interior faces meet in the axis, an interior edge.
// With n = 5, siggraph96 gives (C̄ + 2Ā + 2M)/5, cse96 (C̄ + 2Ā + M)/4. Each of the 5 wedge-shaped
// cells has 4 vertices (a tetrahedron): C̄ gives an end of the axis 1/4 and a girdle vertex 2/20; Ā
// gives an end 1/3 and a girdle vertex 1/15; M an end 1/2.
TEST(Stencils, GoldenEdgeRowsOfBothEditions) {
    const Index n = 5;
    far::ComplexBuilder builder(3, n + 2);
    for (Index i = 0; i < n; ++i)
        builder.addCell(far::StandardCell::Tetrahedron, {i, (i + 1) % n, n + 1, n});
    TopologyRefiner refiner(builder.build());
    refiner.refineUniform(1);
    const auto& [base, strata, holes] = refiner.level(0);
    Index axis = 0;
    while (strata.of({1, axis}) != 3) ++axis;
    const Index row = refiner.refinement(1).childOf({{1, axis}, {1, axis}})->index;
    const double girdleC = 2. / 20, girdleA = 1. / 15;
    const std::map<Rules, std::array<double, 2>> expected = {
        {Rules::Siggraph96, {(girdleC + 2 * girdleA) / 5, (1. / 4 + 2. / 3 + 2 * 0.5) / 5}},
        {Rules::Cse96, {(girdleC + 2 * girdleA) / 4, (1. / 4 + 2. / 3 + 0.5) / 4}}};
    for (const auto& [rules, weights] : expected) {
        const auto table = buildLevelTable(refiner, 1, rules);
        ASSERT_EQ(table.columns(row).size(), 7u);
        for (std::size_t i = 0; i < 7; ++i)
            // Some twenty shares below 0.2, rounded each.
            EXPECT_NEAR(table.weights(row)[i], weights[i < 5 ? 0 : 1], 4e-16);
    }
}

TEST(Stencils, VerticesAndLevelsThatAreNotThereAreRefused) {
    TopologyRefiner refiner(test::bipyramid(3));
    refiner.refineUniform(1);
    const auto build = [&](int level, Index vertex) {
        return buildStencils(refiner, level, Rules::Siggraph96, std::vector<Index>{vertex});
    };
    EXPECT_NO_THROW(build(1, 0));
    EXPECT_THROW(build(1, -1), Error);
    EXPECT_THROW(build(1, refiner.level(1).complex.count(0)), Error);
    EXPECT_THROW(build(0, 5), Error);
    EXPECT_THROW(build(2, 0), Error);
    EXPECT_THROW(build(-1, 0), Error);
}

TEST(RefineValues, RefusesAWrongNumberOfValues) {
    const TopologyRefiner refiner(test::bipyramid(3));
    const std::vector<double> values(14);
    try {
        refineValues(refiner, 0, Rules::Siggraph96, values, 3);
        FAIL() << "accepted";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("got 14 values; expected 3 for each of 5"));
    }
}

}  // namespace
}  // namespace espalier::stencils
