// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/embed/embedding.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include "support/meshes.h"
#include "support/random_lattices.h"
#include "support/refined_lattice.h"
#include "support/rows.h"
#include "support/sanitizers.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

// Tests properties of the tables of every lattice.

namespace espalier::stencils {
namespace {

/// Calls check(name, refiner, lattice) for each lattice of the zoo, refined `level` times; also
/// with open boundaries, if cells are left.
template <class Check>
void forEachRefinedLattice(int level, Check check) {
    for (const auto& [name, lattice] : someOf(test::zoo()))
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
            for (const Rules rules : kLatticeRules) {
                const TopologyRefiner own = withRules(refiner, rules);
                for (int level = 0; level <= 3; ++level) {
                    const auto table = buildStencils(own, level);
                    ASSERT_EQ(table.rowCount(), refiner.level(level).complex.count(0));
                    ASSERT_EQ(table.columnCount(), refiner.level(0).complex.count(0));
                    for (Index row = 0; row < table.rowCount(); ++row) {
                        double sum = 0;
                        for (const double weight : table.weights(row)) sum += weight;
                        // The accuracy that the project promises.
                        ASSERT_NEAR(sum, 1, 1e-14) << name << " level " << level << " row " << row;
                    }
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
            for (const Rules rules : kLatticeRules) {
                const TopologyRefiner own = withRules(refiner, rules);
                const auto refined = refinePositions(own, 2, lattice.positions);
                const auto refinedImages = refinePositions(own, 2, images);
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
            const auto values = randomValues(std::size_t(refiner.level(0).complex.count(0)) * 2, 1);
            for (const Rules rules : kLatticeRules) {
                const TopologyRefiner own = withRules(refiner, rules);
                const auto stepwise = refineValues(own, 3, values, 2);
                const auto table = buildStencils(own, 3);
                for (Index row = 0; row < table.rowCount(); ++row)
                    for (std::size_t c = 0; c < 2; ++c) {
                        double sum = 0;
                        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                            sum += table.weights(row)[k] *
                                   values[2 * std::size_t(table.columns(row)[k]) + c];
                        // Values are below 1, and rows have at most a few hundred entries.
                        ASSERT_NEAR(stepwise[2 * std::size_t(row) + c], sum, 1e-14) << name;
                    }
            }
        });
}

/// Makes a seventh of the edges and a thirteenth of the vertices of a lattice or a mesh sharp,
/// chosen at random.
Lattice sharpened(Lattice lattice) {
    std::mt19937 random(1);
    const CellComplex& complex = lattice.complex;
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        const auto ends = complex.relation(1, 0)[edge];
        if (random() % 7 == 0)
            lattice.marks.edges.push_back({{ends[0], ends[1]}, far::kInfinitelySharp});
    }
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        if (random() % 13 == 0) lattice.marks.vertices.push_back({vertex, far::kInfinitelySharp});
    return lattice;
}

// This also tests rows that are copied from others: nearly all rows in regular bases. Every feature
// must be at the edge of some copied rows.
TEST(Stencils, EqualProductsOfLevelTablesToTheLastBit) {
    std::vector<NamedLattice> shapes = test::zoo();
    for (auto& shape : featureLattices()) shapes.push_back(std::move(shape));
    for (auto& shape : meshZoo()) shapes.push_back(std::move(shape));
    for (unsigned seed = 0; seed < 4; ++seed)
        shapes.push_back({"seed " + std::to_string(seed), randomLattice(seed)});
    const Lattice box = shapes::box({.cells = {5, 4, 4}}), patch = test::patch(12);
    Lattice shuffled = box;
    shuffled.complex = relabelled(box.complex, shuffledIndices(box.complex.count(0), 7), 8);
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
            const TopologyRefiner own = withRules(refiner, rules);
            StencilTable<double> product = buildStencils(own, 0);
            for (int level = 1; level <= finest; ++level) {
                product = multiply(buildLevelTable(own, level), product);
                ASSERT_EQ(buildStencils(own, level), product) << name << " level " << level;
            }
        }
    }
}

// The sums are the same and in the same order, so rows are equal to the last bit.
TEST(Stencils, DemandedRowsAreTheRowsOfTheWholeTable) {
    forEachRefinedLattice(3, [](const std::string& name, const TopologyRefiner& refiner,
                                const Lattice&) {
        for (const Rules rules : kLatticeRules) {
            const TopologyRefiner own = withRules(refiner, rules);
            const auto whole = buildStencils(own, 3);
            auto rows = shuffledIndices(whole.rowCount(), 3);
            rows.resize(std::min<std::size_t>(rows.size(), 20));
            rows.push_back(rows.front());
            const auto some = buildStencils(own, 3, rows);
            ASSERT_EQ(some.rowCount(), Index(rows.size()));
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const auto row = Index(i);
                ASSERT_TRUE(std::ranges::equal(some.columns(row), whole.columns(rows[i]))) << name;
                ASSERT_TRUE(std::ranges::equal(some.weights(row), whole.weights(rows[i]))) << name;
            }
        }
    });
}

// Renumbering vertices, reordering cells and faces, and rewinding loops permutes the table.
TEST(Stencils, RelabellingPermutesTheTable) {
    for (const auto& [name, lattice] : someOf(test::zoo())) {
        const auto names = shuffledIndices(lattice.complex.count(0), 5);
        far::Marks marks = lattice.marks;
        for (auto& edge : marks.edges)
            for (Index& vertex : edge.vertices) vertex = names[vertex];
        for (auto& mark : marks.vertices) mark.vertex = names[mark.vertex];
        TopologyRefiner first(lattice.complex, {.marks = lattice.marks});
        TopologyRefiner second(relabelled(lattice.complex, names, 6), {.marks = marks});
        first.refineUniform(2);
        second.refineUniform(2);
        const auto maps = matchLevels(first, second, names);
        for (const Rules rules : kLatticeRules) {
            const auto a = buildStencils(withRules(first, rules), 2),
                       b = buildStencils(withRules(second, rules), 2);
            for (Index row = 0; row < a.rowCount(); ++row) {
                const Index image = maps[2][row];
                Row expected;
                for (const auto& [column, weight] : rowOf(a, row).weights)
                    expected.weights[names[column]] = weight;
                // A weight that cancels to 0 in one order of summation may not cancel in another.
                ASSERT_LE(difference(rowOf(b, image), expected), 1e-15) << name << " row " << row;
            }
        }
    }
}

}  // namespace
}  // namespace espalier::stencils

namespace espalier::embed {
namespace {

/// Adds a point on each side of a lattice, outside but near enough to be carried.
void addPointsBeside(const Lattice& lattice, std::vector<Point3>& points) {
    const BoundingBox box(lattice.positions);
    for (const double x : {-0.1, 1.1}) points.push_back({box.min[0] + x * box.size()[0], 0.3, 0.2});
}

// An undeformed lattice reproduces the model within 1e-12 of its size (the accuracy that the
// project promises). An affine map of the lattice maps the model in the same way, including points
// outside.
TEST(Embedding, ReproducesAffineMaps) {
    Eigen::Matrix3d linear;
    linear << 2, -1, 0.5, 0.3, 1.5, -0.2, 0, 0.7, -1;
    const Eigen::Vector3d shift(3, -2, 5);
    for (const auto& [name, lattice] : test::zoo()) {
        const Refined refined(lattice, 2);
        auto points = pointsIn(refined, 200, 1);
        addPointsBeside(lattice, points);
        const Embedding embedding = refined.embed(points, {.outside = OutsidePolicy::Nearest});
        EXPECT_EQ(embedding.count(PointStatus::NotConverged), 0) << name;
        EXPECT_LT(embedding.largestResidual(), 1e-13) << name;
        const auto table = refined.table(embedding);
        EXPECT_LT(largestDistance(times(table, refined.base), asMatrix(points)), 4e-12) << name;
        const auto moved = [&](std::vector<Point3> from) {
            for (Point3& p : from) {
                const Eigen::Vector3d q = linear * vec(p) + shift;
                p = {q[0], q[1], q[2]};
            }
            return from;
        };
        EXPECT_LT(largestDistance(times(table, moved(refined.base)), asMatrix(moved(points))),
                  1e-11)
            << name;
    }
}

// Rows of W and D sum to 1 like rows of S. Inside, they do within 1e-14. Outside, weights continue
// along a tangent and grow with the distance, so the tolerance is 1e-14 of the sum of their
// absolute values.
TEST(Embedding, RowsSumToOne) {
    for (const auto& [name, lattice] : test::zoo()) {
        SCOPED_TRACE(name);
        const Refined refined(lattice, 2);
        auto points = pointsIn(refined, 100, 11);
        addPointsBeside(lattice, points);
        const Embedding embedding = refined.embed(points, {.outside = OutsidePolicy::Nearest});
        for (const auto& table :
             {buildEmbeddingTable(refined.complex(), embedding), refined.table(embedding)})
            expectRowsSumToOne(table);
    }
}

}  // namespace
}  // namespace espalier::embed
