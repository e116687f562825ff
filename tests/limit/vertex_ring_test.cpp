// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/regular_cells.h>
#include <espalier/far/standard_cells.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/limit/vertex_ring.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <iostream>
#include <numbers>

#include "support/random_lattices.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::limit {
namespace {

/// Returns tetrahedra that join a new vertex, the last one, to the triangles of a cell.
CellComplex starOfTetrahedra(const CellComplex& hull) {
    far::ComplexBuilder builder(3, hull.count(0) + 1);
    for (const auto& loop : far::outwardLoops(hull, CellId(0)))
        builder.addCell(far::StandardCell::Tetrahedron, {loop[0], loop[2], loop[1], hull.count(0)});
    return builder.build();
}

VertexRing ringIn(const CellComplex& complex, Rules rules, Index vertex) {
    const TopologyRefiner refiner(complex, {.rules = rules});
    return ringOf(refiner.level(0), refiner.options(), vertex);
}

void expectEigenvalues(const VertexRing& ring, const std::vector<double>& expected,
                       double tolerance) {
    const auto values = eigenvalues(ring);
    ASSERT_GT(values.size(), expected.size());
    EXPECT_NEAR(values[0].real(), 1, 1e-13);
    for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_NEAR(values[i + 1].real(), expected[i], tolerance) << i;
        EXPECT_EQ(values[i + 1].imag(), 0) << i;
    }
}

// The 27 points of a regular ring are a product of three rings (P₋ P P₊) of a curve. The matrix of
// a curve has the eigenvalues 1, 1/2 and 1/4. So the product has 1/2 three times, and 1/4 six
// times, of which three are 1/2 · 1/2.
TEST(VertexRing, EigenvaluesOfARegularStar) {
    const auto ring = ringIn(grid({2, 2, 2}), Rules::Siggraph96, 13);
    EXPECT_EQ(ring.subdivision.rows(), 27);
    expectEigenvalues(ring, {0.5, 0.5, 0.5, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.125}, 1e-12);
}

// The expected values come from an independent computation with four decimals.
TEST(VertexRing, EigenvaluesOfIrregularStars) {
    constexpr double kDecimals = 5e-5;
    // Two layers of five cells around an edge. The tested vertex is in the middle of the axis.
    const auto cylinder = shapes::cylinder({.sectors = 5, .layers = 2}).complex;
    Index middle = 0;
    for (Index v = 0; v < cylinder.count(0); ++v)
        if (cylinder.relation(0, 3)[v].size() == 10) middle = v;
    for (const Rules rules : {Rules::Siggraph96, Rules::Cse96}) {
        const auto values = eigenvalues(ringIn(cylinder, rules, middle));
        // The rules give a pair of equal moduli around the edge, and 1/2 along it.
        EXPECT_NEAR(std::abs(values[1] - values[2]), 0, 1e-12);
        EXPECT_NEAR(values[3].real(), 0.5, 1e-12);
    }
    expectEigenvalues(ringIn(cylinder, Rules::Siggraph96, middle), {0.55, 0.55, 0.5, 0.3401},
                      kDecimals);
    const auto icosahedral = starOfTetrahedra(shapes::icosahedron().complex);
    expectEigenvalues(ringIn(icosahedral, Rules::Siggraph96, 12), {0.6150, 0.6150, 0.6150},
                      kDecimals);
    expectEigenvalues(ringIn(icosahedral, Rules::Cse96, 12), {0.6289, 0.6289, 0.6289}, kDecimals);
    expectEigenvalues(ringIn(icosahedral, Rules::Mlca, 12), {0.6289, 0.6289, 0.6289}, kDecimals);
    const auto tetrahedral = starOfTetrahedra(shapes::tetrahedron().complex);
    expectEigenvalues(ringIn(tetrahedral, Rules::Siggraph96, 4), {0.3476, 0.3476, 0.3476},
                      kDecimals);
    expectEigenvalues(ringIn(tetrahedral, Rules::Cse96, 4), {0.3632, 0.3632, 0.3632}, kDecimals);
    expectEigenvalues(ringIn(tetrahedral, Rules::Mlca, 4), {0.3632, 0.3632, 0.3632}, kDecimals);
}

// Inside a regular lattice the cubic B-spline has the values (1, 4, 1)/6 at a knot: 8/27 for the
// vertex, and 4/9, 2/9 and 1/27 for the averages of the points across edges, faces and cells.
TEST(VertexRing, RegularLimitEqualsTheSpline) {
    const auto ring = ringIn(grid({2, 2, 2}), Rules::Siggraph96, 13);
    const Eigen::VectorXd mask = limitMask(ring);
    for (std::size_t i = 0; i < ring.entities.size(); ++i) {
        const std::array<double, 4> perEntity = {8.0 / 27, 4.0 / 9 / 6, 2.0 / 9 / 12, 1.0 / 27 / 8};
        EXPECT_NEAR(mask[Eigen::Index(i)], perEntity[ring.entities[i].dimension], 1e-15);
    }
}

/// Under MLCA, the limit of a vertex among hexahedra is 8/27 P + 4/9 ē + 2/9 f̄ + 1/27 c̄, as in
/// the regular case, for any valence. ē is the average of the vertices across edges, weighted by
/// the number of cells at the edge; f̄ and c̄ are the averages across faces and cells.
TEST(VertexRing, LimitUnderMlcaIsTheSplineWeightedByCells) {
    std::vector<CellComplex> stars = {starOfTetrahedra(shapes::icosahedron().complex),
                                      starOfTetrahedra(shapes::tetrahedron().complex),
                                      starOfTetrahedra(shapes::octahedron().complex),
                                      starOfTetrahedra(shapes::bipyramid({.sides = 5}).complex)};
    for (const auto& star : stars) {
        const Index centre = star.count(0) - 1;
        const auto ring = ringIn(star, Rules::Mlca, centre);
        const Eigen::VectorXd mask = limitMask(ring);
        // On the next level the ring is among hexahedra. Each face has two cells; each cell counts
        // once.
        const std::array<double, 4> shares = {8.0 / 27, 4.0 / 9, 2.0 / 9, 1.0 / 27};
        std::array<double, 4> totals = {};
        const auto cellsAt = [&](const Entity& entity) {
            return double(star.relation(entity.dimension, 3)[entity.index].size());
        };
        for (const auto& entity : ring.entities)
            totals[std::size_t(entity.dimension)] += cellsAt(entity);
        for (std::size_t i = 0; i < ring.entities.size(); ++i) {
            const auto d = std::size_t(ring.entities[i].dimension);
            // Sums of up to 63 terms, from an iterative solution.
            EXPECT_NEAR(mask[Eigen::Index(i)], shares[d] * cellsAt(ring.entities[i]) / totals[d],
                        1e-14);
        }
    }
}

/// The shortcut for regular vertices gives the same row as the left eigenvector.
TEST(VertexLimits, RegularRowsEqualTheEigenvector) {
    Index seen = 0;
    for (const auto& [name, lattice] : zoo()) {
        TopologyRefiner refiner = test::refined(lattice.complex, 1, {.marks = lattice.marks});
        for (int level = 0; level <= 1; ++level) {
            const far::Level& here = refiner.level(level);
            for (Index vertex = 0; vertex < here.complex.count(0); vertex += 1 + level * 6) {
                if (!embed::isRegularVertex(here, vertex)) continue;
                ++seen;
                const auto table = buildLimitMasks(refiner, level, {{vertex}});
                const auto ring = ringOf(here, refiner.options(), vertex);
                Eigen::VectorXd expected = ring.start.transpose() * limitMask(ring);
                for (std::size_t k = 0; k < table.columns(0).size(); ++k) {
                    const auto at = std::lower_bound(ring.vertices.begin(), ring.vertices.end(),
                                                     table.columns(0)[k]);
                    expected[at - ring.vertices.begin()] -= table.weights(0)[k];
                }
                // Sums of 27 products of size 1/6.
                EXPECT_LT(expected.cwiseAbs().maxCoeff(), 1e-14) << name << ' ' << vertex;
            }
        }
    }
    EXPECT_GT(seen, shownBySome(300));
}

/// Checks that the limits of the base vertices equal the limits of their children on further
/// levels, which are refined around these vertices only.
void expectInvariant(const std::string& name, const Lattice& lattice, Rules rules, int levels) {
    TopologyRefiner refiner =
        withRules(TopologyRefiner(lattice.complex, refinerOptions(lattice)), rules);
    std::vector<Index> vertices(lattice.complex.count(0));
    std::iota(vertices.begin(), vertices.end(), Index{0});
    const auto expected = times(buildVertexLimits(refiner, 0), lattice.positions);
    for (int level = 1; level <= levels; ++level) {
        std::set<Index> cells;
        for (const Index vertex : vertices)
            for (const Index cell : refiner.level(level - 1).complex.relation(0, 3)[vertex])
                cells.insert(cell);
        refiner.refineAround(std::vector<Index>(cells.begin(), cells.end()));
        for (Index& vertex : vertices)
            vertex = refiner.refinement(level).childOf({{0, vertex}, {0, vertex}}).value().index;
        const auto limits = buildVertexLimits(refiner, level, vertices);
        EXPECT_LT(largestDistance(times(limits, lattice.positions), expected), 1e-12)
            << name << " level " << level;
    }
}

// Covers irregular vertices, darts, and every stratum of the boundary.
TEST(VertexLimits, AreTheSameOnLevelsUpToFive) {
    for (const auto& [name, lattice] : zoo()) {
        expectInvariant(name, lattice, Rules::Siggraph96, 5);
        expectInvariant(name, lattice, Rules::Cse96, 2);
        expectInvariant(name, lattice, Rules::Mlca, 2);
    }
    for (const auto& [name, lattice] : featureLattices())
        expectInvariant(name, lattice, Rules::Siggraph96, 5);
    for (unsigned seed = 0; seed < 20; ++seed)
        expectInvariant("random " + std::to_string(seed), randomLattice(seed), Rules::Siggraph96,
                        2);
}

// Refined positions converge to the limits.
TEST(VertexLimits, RefinementConvergesToThem) {
    const auto check = [](const std::string& name, const Lattice& lattice, int levels) {
        TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
        const auto limits = times(buildVertexLimits(refiner, 0), lattice.positions);
        refiner.refineUniform(levels);
        const auto refined =
            asMatrix(stencils::refinePositions(refiner, levels, lattice.positions));
        // The remaining distance shrinks by the second eigenvalue of the ring, at most 0.62 here,
        // once no sharpness is left: sharpness is below 3 here.
        EXPECT_LT(largestDistance(refined.topRows(limits.rows()), limits),
                  std::pow(0.62, levels - 2))
            << name;
    };
    check("cylinder", shapes::cylinder({.sectors = 5}), 5);
    check("star", shapes::star(), 5);
    for (const auto& [name, lattice] : featureLattices()) check(name, lattice, 4);
}

/// The order in which the vertices of a level converge to their limits, measured on the last two
/// levels: log2 of the ratio of the largest distances, and of the mean distances.
struct Order {
    double ofLargest, ofMean;
};
Order orderOf(const std::string& name, const Lattice& lattice, int finest) {
    TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    double largest = 0, mean = 0;
    Order order{};
    for (int level = 1; level <= finest; ++level) {
        refiner.refineUniform(level);
        const auto limits = times(buildVertexLimits(refiner, level), lattice.positions);
        const auto at = asMatrix(stencils::refinePositions(refiner, level, lattice.positions));
        const Eigen::VectorXd distances = (at - limits).rowwise().norm();
        order = {std::log2(largest / distances.maxCoeff()), std::log2(mean / distances.mean())};
        largest = distances.maxCoeff();
        mean = distances.mean();
        std::cout << name << ", level " << level << ": largest " << largest << ", mean " << mean;
        if (level > 1)
            std::cout << "; order " << order.ofLargest << ", on the average " << order.ofMean;
        std::cout << std::endl;
    }
    return order;
}

// In regular regions second differences fall to a quarter with each level. The ring of an irregular
// edge or vertex shrinks by its second eigenvalue (0.55 at an edge of five cells), and so do the
// distances in the ring. So the largest distance converges in first order or less. The mean
// distance converges faster, because the volume of the ring shrinks, too.
TEST(VertexLimits, LevelsConvergeInSecondOrder) {
    Lattice box = shapes::box({.cells = {3, 2, 2}, .max = {3, 2, 2}});
    box.positions = shaken(box.positions, 5);
    const Order ofBox = orderOf("box", box, 4);
    EXPECT_NEAR(ofBox.ofLargest, 2, 0.05);
    EXPECT_NEAR(ofBox.ofMean, 2, 0.05);
    const Order ofFan = orderOf("five sectors", shapes::cylinder({.sectors = 5}), 5);
    EXPECT_GT(ofFan.ofLargest, -std::log2(0.62));
    EXPECT_NEAR(ofFan.ofMean, 2, 0.15);
}

// A box under boundary control is the spline with phantom layers 2P₀ − P₁: its corners stay, and
// along its edges, in its sides and inside, limits have the weights (1, 4, 1)/6 for each direction.
// A point at the end of an edge has the limit of the corner, and a point on the border of a side
// has the limit of the edge.
TEST(VertexLimits, BoxEqualsTheTensorSpline) {
    const std::array<Index, 3> n = {3, 2, 4};
    const auto lattice = shapes::box({.cells = n});
    const auto table = buildVertexLimits(TopologyRefiner(lattice.complex), 0);
    for (Index k = 0; k <= n[2]; ++k)
        for (Index j = 0; j <= n[1]; ++j)
            for (Index i = 0; i <= n[0]; ++i) {
                std::vector<double> expected(lattice.positions.size(), 0);
                const auto axis = [](Index at, Index count) {
                    return at == 0 || at == count ? std::array{0.0, 1.0, 0.0}
                                                  : std::array{1.0 / 6, 4.0 / 6, 1.0 / 6};
                };
                const auto x = axis(i, n[0]), y = axis(j, n[1]), z = axis(k, n[2]);
                for (Index c = -1; c <= 1; ++c)
                    for (Index b = -1; b <= 1; ++b)
                        for (Index a = -1; a <= 1; ++a) {
                            const double weight = x[std::size_t(a + 1)] * y[std::size_t(b + 1)] *
                                                  z[std::size_t(c + 1)];
                            if (weight != 0)
                                expected[std::size_t(gridVertex(n, i + a, j + b, k + c))] = weight;
                        }
                const Index row = gridVertex(n, i, j, k);
                for (std::size_t e = 0; e < table.columns(row).size(); ++e)
                    expected[std::size_t(table.columns(row)[e])] -= table.weights(row)[e];
                for (const double difference : expected) EXPECT_NEAR(difference, 0, 1e-15);
            }
}

TEST(VertexLimits, CurvesAndMeshesHaveLimits) {
    const auto mesh = gridMesh(2, 2);
    const auto table = buildVertexLimits(TopologyRefiner(mesh), 0);
    // (1, 4, 1)/6 ⊗ (1, 4, 1)/6 in the middle.
    ASSERT_EQ(table.weights(4).size(), 9U);
    for (std::size_t k = 0; k < 9; ++k)
        EXPECT_NEAR(table.weights(4)[k], (k == 4 ? 16.0 : k % 2 == 1 ? 4.0 : 1.0) / 36, 1e-15);
    EXPECT_EQ(table.weights(0).size(), 1U);
}

TEST(VertexLimits, OpenVerticesHaveNoLimit) {
    const std::array<Index, 3> n = {3, 3, 3};
    const TopologyRefiner refiner(grid(n), {.boundary = Boundary::Open});
    const auto table = buildVertexLimits(refiner, 0);
    for (Index vertex = 0; vertex < table.rowCount(); ++vertex)
        EXPECT_EQ(table.weights(vertex).size(),
                  refiner.level(0).strata.isOpen({0, vertex}) ? 0U : 27U);
    EXPECT_THROW(ringOf(refiner.level(0), refiner.options(), 0), Error);
}

TEST(VertexLimits, RefusesRatsAndUnknownVertices) {
    const TopologyRefiner mesh(gridMesh(2, 2));
    const TopologyRefiner rats = withRules(mesh, Rules::Rats);
    EXPECT_THROW(buildVertexLimits(rats, 0), Error);
    EXPECT_THROW(ringOf(rats.level(0), rats.options(), 4), Error);
    EXPECT_THROW(buildVertexLimits(mesh, 0, {{9}}), Error);
    EXPECT_THROW(ringOf(mesh.level(0), mesh.options(), 9), Error);
}

// The mask of a vertex with thousands of edges is computed at once. Its eigenvalues would take
// hours.
TEST(VertexLimits, WorkForVerticesWithThousandsOfEdges) {
    const Lattice lattice = shapes::bipyramid({.sides = 3000});
    const TopologyRefiner refiner(lattice.complex);
    Index apex = kMaxIndex;
    for (Index v = 0; v < lattice.complex.count(0); ++v)
        if (std::ssize(lattice.complex.relation(0, 1)[v]) == 3000) apex = v;
    ASSERT_NE(apex, kMaxIndex);
    const VertexRing ring = ringOf(refiner.level(0), refiner.options(), apex);
    const Eigen::VectorXd mask = limitMask(ring);
    EXPECT_NEAR(mask.sum(), 1, 1e-14);
    EXPECT_LT((ring.subdivision.transpose() * mask - mask).lpNorm<Eigen::Infinity>(), 1e-15);
    EXPECT_THROW(eigenvalues(ring), Error);
}

}  // namespace
}  // namespace espalier::limit
