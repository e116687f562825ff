// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/rats.h>

#include "papers/rats_reference.h"
#include "papers/refined_grid.h"
#include "support/meshes.h"
#include "support/rows.h"
#include "support/test.h"

// Savva & Clapworthy (003) on meshes of any topology: the general form of inner points of section
// 3, and the rules of section 2 for the border. rats_grid_test.cpp has the equations for grids.
namespace espalier::stencils {
namespace {

/// Sums of about a dozen products near 1: a dozen roundings of 1.1e-16.
constexpr double kRatsRounding = 3e-15;

std::vector<Row> rowsOf(const StencilTable<double>& table) {
    std::vector<Row> rows;
    for (Index row = 0; row < table.rowCount(); ++row) rows.push_back(rowOf(table, row));
    return rows;
}

/// True if the rules of RATS refine a mesh; other meshes are refused.
bool isRefined(const TopologyRefiner& refiner) {
    return refiner.boundary() != Boundary::Open &&
           refiner.options().triangles != far::TriangleSubdivision::Smooth &&
           !refiner.level(0).strata.hasSemiSharp();
}

/// Calls check(refiner) for each mesh of the zoo that RATS refines, on level 2. Includes poles of
/// 64 edges. With poles of 360 edges these tests took 30 s; without them, less than one.
template <class Check>
void forEachMesh(Check check) {
    int count = 0;
    for (const NamedLattice& mesh : meshZoo()) {
        if (mesh.name.find("360") != std::string::npos) continue;
        const TopologyRefiner base(mesh.lattice.complex, refinerOptions(mesh.lattice));
        if (!isRefined(base)) {
            EXPECT_THROW(withRules(base, Rules::Rats), Error) << mesh.name;
            continue;
        }
        TopologyRefiner refiner = withRules(base, Rules::Rats);
        refiner.refineUniform(2);
        SCOPED_TRACE(mesh.name);
        check(refiner);
        ++count;
    }
    EXPECT_GT(count,
              shownBySome(60));  // There are 82, among them closed, open, creased, non-manifold and
                                 // degenerate ones.
}

// Compares the ten definitions of section 2, on meshes of any topology, with a reference that has
// one function for each.
TEST(Rats, TenTypesOnEveryMesh) {
    std::set<RatsPoint> seen;
    forEachMesh([&](const TopologyRefiner& refiner) {
        for (int level = 1; level <= 2; ++level) {
            const far::Level& parent = refiner.level(level - 1);
            const RatsReference reference(parent);
            const auto table = buildLevelTable(refiner, level);
            for (Index vertex = 0; vertex < table.rowCount(); ++vertex) {
                const Entity entity = parentOf(refiner, level, vertex);
                seen.insert(ratsPoint(parent, entity));
                ASSERT_LT(difference(rowOf(table, vertex), reference.newPoint(entity)),
                          // The longest sums are at a pole of 64 edges.
                          1e-14)
                    << "level " << level << " vertex " << vertex;
            }
        }
    });
    EXPECT_EQ(seen.size(), 10u);
}

// "The new face points F_γ are the average of all the new vertex points V_γ […] and the new edge
// points E_δ are the midpoints of the two" (section 3).
TEST(Rats, InnerFaceAndEdgePointsAreMeansOfNewVertexPoints) {
    forEachMesh([&](const TopologyRefiner& refiner) {
        const far::Level& base = refiner.level(0);
        const std::vector<Row> rows = rowsOf(buildLevelTable(refiner, 1));
        for (int dimension = 1; dimension <= 2; ++dimension)
            for (Index index = 0; index < base.complex.count(dimension); ++index) {
                const Entity entity{dimension, index};
                const RatsPoint type = ratsPoint(base, entity);
                if (type != RatsPoint::EDelta && type != RatsPoint::FGamma) continue;
                std::vector<Row> corners;
                for (const Index vertex : base.complex.relation(dimension, 0)[index])
                    corners.push_back(rows[pointOf(refiner, 1, {0, vertex})]);
                const Row& row = rows[pointOf(refiner, 1, entity)];
                ASSERT_LT(difference(row, average(corners)), kRatsRounding);
            }
    });
}

/// The mesh of the first step's inner vertex points, and the points of the second step.
class SecondStep {
public:
    explicit SecondStep(const TopologyRefiner& refiner)
        : refiner_(refiner),
          complex_(refiner.level(0).complex),
          first_(rowsOf(buildStencils(refiner, 1))),
          second_(rowsOf(buildStencils(refiner, 2))) {}

    /// The V_γ of the first step for an old vertex.
    const Row& vertex(Index vertex) const { return at(first_, pointOf(refiner_, 1, {0, vertex})); }

    /// The vertex point of the second step for the new point of an entity.
    const Row& point(Entity entity) const {
        return at(second_, pointOf(refiner_, 2, {0, pointOf(refiner_, 1, entity)}));
    }

    Row mean(Entity entity) const {
        std::vector<Row> rows;
        for (const Index v : complex_.relation(entity.dimension, 0)[entity.index])
            rows.push_back(vertex(v));
        return average(rows);
    }

    /// The mean of the centroids around an entity.
    Row around(Entity entity, int dimension) const {
        std::vector<Row> rows;
        for (const Index other : complex_.relation(entity.dimension, dimension)[entity.index])
            rows.push_back(mean({dimension, other}));
        return average(rows);
    }

    /// For each face of an edge, takes the ends of the edge and the vertices before and after them;
    /// returns the mean of all.
    Row meanBeside(Index edge) const {
        std::vector<Row> rows;
        for (const Index face : complex_.relation(1, 2)[edge]) {
            const auto edges = complex_.relation(2, 1)[face];
            const auto vertices = complex_.relation(2, 0)[face];
            const std::size_t n = edges.size();
            std::size_t i = 0;
            while (edges[i] != edge) ++i;
            for (std::size_t k = 0; k < 4; ++k)
                rows.push_back(vertex(vertices[(i + n - 1 + k) % n]));
        }
        return average(rows);
    }

    bool isBetweenQuads(Index edge) const {
        const auto faces = complex_.relation(1, 2)[edge];
        return std::all_of(faces.begin(), faces.end(),
                           [&](Index face) { return complex_.relation(2, 0)[face].size() == 4; });
    }

    /// True if all faces of the entity are inner: all their points are V_γ.
    bool isInner(Entity entity) const {
        for (const Index face : complex_.relation(entity.dimension, 2)[entity.index])
            for (const Index v : complex_.relation(2, 0)[face])
                if (refiner_.level(0).strata.of({0, v}) != 2) return false;
        return true;
    }

private:
    static const Row& at(const std::vector<Row>& rows, Index index) { return rows[index]; }

    const TopologyRefiner& refiner_;
    const CellComplex& complex_;
    std::vector<Row> first_, second_;
};

// Section 3, Eq 20 to 25: the inner vertex points of a second step are the Catmull-Clark points of
// the mesh of the first step's inner vertex points. The paper shows this for grids. On other meshes
// it holds for
//
//     faces      all of them: their centroids
//     edges      between quadrilaterals. Otherwise the point is E/2 + (F + H)/4, where H is the
//                mean of the four vertices of a face next to the edge (F in a quadrilateral)
//     vertices   of four edges. Otherwise the point is (Q + 2R + S)/4 for any number n of edges,
//                where Catmull-Clark has (Q + 2R + (n − 3)S)/n
TEST(Rats, SecondStepIsCatmullClarkOfTheFirst) {
    int faces = 0, quadEdges = 0, otherEdges = 0, regular = 0, extraordinary = 0;
    forEachMesh([&](const TopologyRefiner& refiner) {
        const CellComplex& complex = refiner.level(0).complex;
        const SecondStep step(refiner);
        for (Index face = 0; face < complex.count(2); ++face) {
            if (!step.isInner({2, face})) continue;
            ASSERT_LT(difference(step.point({2, face}), step.mean({2, face})), kRatsRounding);
            ++faces;
        }
        for (Index edge = 0; edge < complex.count(1); ++edge) {
            const Entity entity{1, edge};
            if (refiner.level(0).strata.of(entity) != 2 || !step.isInner(entity)) continue;
            const Row catmullClark = (step.around(entity, 2) + step.mean(entity)) / 2;
            const Row expected =
                (step.around(entity, 2) + step.meanBeside(edge)) / 4 + step.mean(entity) / 2;
            ASSERT_LT(difference(step.point(entity), expected), kRatsRounding);
            const bool isBetweenQuads = step.isBetweenQuads(edge);
            if (isBetweenQuads) {
                ASSERT_LT(difference(step.point(entity), catmullClark), kRatsRounding);
            }
            // If faces are back to back, the two may be equal by symmetry.
            otherEdges += difference(step.point(entity), catmullClark) > 1e-3;
            quadEdges += isBetweenQuads;
        }
        for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
            const Entity entity{0, vertex};
            const auto n = complex.relation(0, 1)[vertex].size();
            if (n < 3 || complex.relation(0, 2)[vertex].size() != n || !step.isInner(entity))
                continue;
            const Row Q = step.around(entity, 2), R = step.around(entity, 1),
                      S = step.vertex(vertex);
            // Poles of 64 edges have longer sums.
            ASSERT_LT(difference(step.point(entity), (Q + 2 * R + S) / 4), 1e-14);
            const auto edgeCount = double(n);
            const Row catmullClark = (Q + 2 * R + (edgeCount - 3) * S) / edgeCount;
            if (n == 4) {
                ASSERT_LT(difference(step.point(entity), catmullClark), kRatsRounding);
            } else {
                ASSERT_GT(difference(step.point(entity), catmullClark), 1e-3) << n;
            }
            ++(n == 4 ? regular : extraordinary);
        }
    });
    EXPECT_GT(std::min({faces, quadEdges, otherEdges, regular, extraordinary}), 40)
        << faces << " " << quadEdges << " " << otherEdges << " " << regular << " " << extraordinary;
}

// Later steps: step k + 1 of RATS gives the vertices of level k the points that k steps of
// Catmull-Clark give to the first step's vertex points. On a torus all vertices are inner, with 4
// edges.
TEST(Rats, LaterStepsAreCatmullClarkOfTheFirst) {
    const Lattice torus = surfaceOf(shapes::torus());
    const TopologyRefiner refiner = test::refined(torus.complex, 4);
    const TopologyRefiner ratsRefiner = withRules(refiner, Rules::Rats);
    for (Index vertex = 0; vertex < torus.complex.count(0); ++vertex)
        ASSERT_EQ(torus.complex.relation(0, 1)[vertex].size(), 4u);
    std::vector<Row> first = rowsOf(buildStencils(ratsRefiner, 1));
    first.resize(torus.complex.count(0));  // V_γ come first.
    for (int k = 1; k <= 3; ++k) {
        const auto catmullClark = buildStencils(refiner, k);
        const auto rats = buildStencils(ratsRefiner, k + 1);
        for (Index vertex = 0; vertex < catmullClark.rowCount(); ++vertex) {
            const Row expected = substituted(rowOf(catmullClark, vertex), first);
            const Row got = rowOf(rats, pointOf(refiner, k + 1, {0, vertex}));
            ASSERT_LT(difference(got, expected), kRatsRounding) << "k " << k << " " << vertex;
        }
    }
}

// The inner surface is the Catmull-Clark surface of the new vertex points, not of the original
// control points, although the paper's conclusion could be read that way. Consider a spike of
// height 1 in the middle of a net. Its Catmull-Clark surface has the height (4/6)² = 4/9 there. The
// new vertex points have the heights 1/4, 1/2 and 1/4 along each axis, and their surface ((1/4 +
// 4/2 + 1/4)/6)² = 25/144.
TEST(Rats, InnerSurfaceIsDefinedByTheNewVertexPoints) {
    const auto height = [](Rules rules, Boundary boundary) {
        const int level = 5;
        const RefinedGrid net({6, 6}, level, boundary, rules);
        const Place size = net.size(level);
        std::vector<double> values(49, 0.0);
        values[net.vertexAt(0, {3, 3, 0})] = 1;
        const auto refined = refineValues(net.refiner(), level, values, 1);
        return refined[net.vertexAt(level, {size[0] / 2, size[1] / 2, 0})];
    };
    // The points of level 5 are O(4⁻⁵) = 1e-3 away from the surface.
    EXPECT_NEAR(height(Rules::Siggraph96, Boundary::Open), 4.0 / 9, 1e-3);
    EXPECT_NEAR(height(Rules::Rats, Boundary::Sharp), 25.0 / 144, 1e-3);
}

// "The RATS surface […] interpolates the corner control points" (section 1), on every level.
TEST(Rats, InterpolatesTheCorners) {
    forEachMesh([&](const TopologyRefiner& refiner) {
        const auto table = buildStencils(refiner, 2);
        for (Index vertex = 0; vertex < refiner.level(0).complex.count(0); ++vertex) {
            if (refiner.level(0).strata.of({0, vertex}) != 0) continue;
            const Index child = pointOf(refiner, 2, {0, pointOf(refiner, 1, {0, vertex})});
            ASSERT_EQ(rowOf(table, child).weights, test::point(vertex).weights);
        }
    });
}

// "It generates an additional set of patches at the border of the surface" (section 1). Over an
// even net, the RATS surface is the whole net, while Catmull-Clark without boundary control omits
// everything within one step of the border. On level k it has (n − 1)(m − 1)4ᵏ faces.
TEST(Rats, FillsTheBorderPatches) {
    const int level = 4;
    const double scale = std::ldexp(1, -level);
    const RefinedGrid rats({5, 4}, level, Boundary::Sharp, Rules::Rats);
    EXPECT_EQ(rats.complex(level).count(2), 5 * 4 << 2 * level);
    const auto table = buildStencils(rats.refiner(), level);
    for (Index vertex = 0; vertex < table.rowCount(); ++vertex)
        for (std::size_t axis = 0; axis < 2; ++axis) {
            double coordinate = 0;
            for (const auto& [column, weight] : rowOf(table, vertex).weights)
                coordinate += weight * rats.places(0)[column][axis];
            const Place place = rats.places(level)[vertex];
            // Coordinates up to 5: a dozen roundings of 1e-15.
            ASSERT_NEAR(coordinate, scale * place[axis], 1e-14) << vertex;
        }
    // The open net keeps 3 × 2 squares of the original size, and at most half a step around them.
    const RefinedGrid open({5, 4}, level);
    const Place size = open.size(level);
    EXPECT_LE(size[0] * scale, 3 + 2 * scale);
    EXPECT_LE(size[1] * scale, 2 + 2 * scale);
}

// The border of the surface is the RATS curve of the net's border.
TEST(Rats, BorderIsTheCurveOfTheBorder) {
    const int level = 3;
    const RefinedGrid net({5, 4}, level, Boundary::Sharp, Rules::Rats),
        side({5}, level, Boundary::Sharp, Rules::Rats);
    const auto surface = buildStencils(net.refiner(), level);
    const auto curve = buildStencils(side.refiner(), level);
    for (Index i = 0; i <= net.size(level)[0]; ++i)
        for (const Index j : {Index{0}, net.size(level)[1]}) {
            const Row row = rowOf(surface, net.vertexAt(level, {i, j, 0}));
            Row expected;
            for (const auto& [place, weight] :
                 rowOf(curve, side.vertexAt(level, {i, 0, 0})).weights)
                expected = expected + weight * net.at(0, {place, j == 0 ? 0 : 4, 0});
            EXPECT_LT(difference(row, expected), kRatsRounding) << i << ", " << j;
        }
}

/// Returns the midpoint subdivision of a cubic Bézier curve by de Casteljau's algorithm: 7 points
/// from 4.
std::vector<Row> splitBezier() {
    const Row a = test::point(0), b = test::point(1), c = test::point(2), d = test::point(3);
    const Row ab = (a + b) / 2, bc = (b + c) / 2, cd = (c + d) / 2;
    const Row abc = (ab + bc) / 2, bcd = (bc + cd) / 2;
    return {a, ab, abc, (abc + bcd) / 2, bcd, cd, d};
}

// "Derived from a standard bicubic Bézier patch and […] based on a recursive patch midpoint
// subdivision" (section 1): the first step on four points, or on 4 × 4, is this subdivision.
TEST(Rats, FirstStepSplitsABezierPatch) {
    const std::vector<Row> split = splitBezier();
    const RefinedGrid curve({3}, 1, Boundary::Sharp, Rules::Rats),
        patch({3, 3}, 1, Boundary::Sharp, Rules::Rats);
    const auto points = buildLevelTable(curve.refiner(), 1);
    const auto net = buildLevelTable(patch.refiner(), 1);
    for (Index i = 0; i < 7; ++i) {
        const Row& x = split[i];
        // Weights in eighths are exact.
        EXPECT_EQ(difference(rowOf(points, curve.vertexAt(1, {i, 0, 0})), x), 0);
        for (Index j = 0; j < 7; ++j) {
            const Row expected = tensorProduct(patch, x, split[j]);
            const Row got = rowOf(net, patch.vertexAt(1, {i, j, 0}));
            EXPECT_LT(difference(got, expected), kRatsRounding) << i << ", " << j;
        }
    }
}

// A closed polygon has neither corners nor ends: V_β is (1 2 1)/4 and E_β is (1 3 3 1)/8.
TEST(Rats, ClosedPolygon) {
    const Index n = 5;
    const TopologyRefiner refiner =
        test::refined(far::buildCurve(n, true), 1, {.rules = Rules::Rats});
    const auto table = buildLevelTable(refiner, 1);
    const auto P = [&](Index i) { return test::point((i + n) % n); };
    for (Index i = 0; i < n; ++i) {
        const Row vertex = (P(i - 1) + 2 * P(i) + P(i + 1)) / 4;
        EXPECT_EQ(difference(rowOf(table, i), vertex), 0);
        const auto ends = refiner.level(0).complex.relation(1, 0)[i];
        const Index a = (ends[0] + 1) % n == ends[1] ? ends[0] : ends[1];
        const Row edge = (P(a - 1) + 3 * P(a) + 3 * P(a + 1) + P(a + 2)) / 8;
        EXPECT_EQ(difference(rowOf(table, pointOf(refiner, 1, {1, i})), edge), 0);
    }
}

TEST(Rats, RowsSumToOne) {
    forEachMesh([&](const TopologyRefiner& refiner) {
        const auto table = buildStencils(refiner, 2);
        for (Index row = 0; row < table.rowCount(); ++row) {
            const auto weights = table.weights(row);
            // The bound that the project promises.
            ASSERT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-14);
        }
    });
}

// Composition, row selection and evaluators accept the tables of RATS.
TEST(Rats, TablesComposeAndEvaluate) {
    const int level = 3;
    const TopologyRefiner refiner =
        test::refined(polygonDisk({3, 4, 5, 6, 7}).complex, level, {.rules = Rules::Rats});
    const auto table = buildStencils(refiner, level);
    const auto values = randomValues(3 * std::size_t(table.columnCount()), 7);
    const auto stepByStep = refineValues(refiner, level, values, 3);
    const auto layout = osd::BufferDescriptor::packed(3);
    std::vector<double> slow(stepByStep.size()), fast(stepByStep.size());
    osd::ReferenceEvaluator::evaluate(table, std::span<const double>(values), layout,
                                      std::span<double>(slow), layout, {0, table.rowCount()});
    osd::CpuEvaluator::evaluate(table, std::span<const double>(values), layout,
                                std::span<double>(fast), layout, {0, table.rowCount()});
    for (std::size_t i = 0; i < stepByStep.size(); ++i) {
        // Values up to 1, three steps of about a dozen roundings.
        EXPECT_NEAR(slow[i], stepByStep[i], 1e-14);
        EXPECT_NEAR(fast[i], slow[i], 1e-14);
    }
    const std::vector<Index> some = {table.rowCount() - 1, 0, 5};
    const auto demanded = buildStencils(refiner, level, some);
    for (std::size_t i = 0; i < some.size(); ++i)
        EXPECT_EQ(rowOf(demanded, Index(i)).weights, rowOf(table, some[i]).weights);
}

void expectRefused(const TopologyRefiner& refiner, const std::string& why) {
    EXPECT_REFUSED(Error, why, withRules(refiner, Rules::Rats));
}

TEST(Rats, RefusesMeshesWithoutRules) {
    expectRefused(TopologyRefiner(grid({1, 1, 1})), "not for lattices");
    const CellComplex net = gridMesh(3, 3);
    expectRefused(TopologyRefiner(net, {.boundary = Boundary::Open}),
                  "do not have the boundary mode 'open'");
    expectRefused(TopologyRefiner(net, {.triangles = far::TriangleSubdivision::Smooth}),
                  "do not have smooth triangles");
    expectRefused(TopologyRefiner(net, {.marks = {.edges = {{{5, 6}, 2.5}}}}),
                  "edge (5, 6) is semi-sharp");
    expectRefused(TopologyRefiner(net, {.marks = {.vertices = {{5, 0.5}}}}),
                  "vertex 5 is semi-sharp");
}

}  // namespace
}  // namespace espalier::stencils
