// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/strata.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/mlca.h>

#include "support/meshes.h"
#include "support/random_lattices.h"
#include "support/rows.h"
#include "support/sanitizers.h"
#include "support/test.h"

// MLCA: Bajaj, Schaefer, Warren & Xu 2002.
namespace espalier::stencils {
namespace {

using far::TriangleSubdivision;

/// MLCA as the paper describes it: splits points multilinearly; then each point becomes the mean of
/// the centroids of the sub-cells around it, which are the cells (faces, edges, vertices) of the
/// child.
class SplitAndAveraged {
public:
    SplitAndAveraged(const far::Level& level, std::span<const double> values)
        : level_(level), split_(level.complex) {  // all children, whatever the boundary control
        const CellComplex& parent = level.complex;
        for (Index vertex = 0; vertex < split_.child().count(0); ++vertex) {
            const Entity entity = split_.parentOf({0, vertex}).upper;
            values_.push_back(mean(parent.relation(entity.dimension, 0)[entity.index], values));
        }
    }

    /// Returns the value by the rule of the entity's stratum, or the blend of two rules if its
    /// sharpness runs out.
    double at(Entity entity, far::Creasing creasing) const {
        const auto fading = far::fadingOf(level_.complex, level_.strata, creasing, entity);
        const double now = averaged(entity, level_.strata.of(entity), {});
        if (!fading) return now;
        const double next = averaged(entity, fading->next, fading->staySharp);
        return fading->weight * now + (1 - fading->weight) * next;
    }

private:
    static double mean(std::span<const Index> vertices, std::span<const double> values) {
        double sum = 0;
        for (const Index vertex : vertices) sum += values[vertex];
        return sum / double(vertices.size());
    }

    /// \param crease the only edges to average over, if any
    double averaged(Entity entity, int stratum,
                    const std::optional<std::array<Index, 2>>& crease) const {
        const CellComplex& child = split_.child();
        const Index vertex = split_.childOf({entity, entity}).value().index;
        double sum = 0;
        int count = 0;
        for (const Index piece : child.relation(0, stratum)[vertex]) {
            const Entity whole = split_.parentOf({stratum, piece}).upper;
            if (!level_.strata.inSubcomplex(entity, stratum, whole)) continue;
            if (crease && !far::contains(*crease, whole.index)) continue;
            sum += mean(child.relation(stratum, 0)[piece], values_);
            ++count;
        }
        return sum / count;
    }

    const far::Level& level_;
    far::Refinement split_;
    std::vector<double> values_;
};

/// Returns lattices, meshes and curves with every feature that has a rule.
std::vector<NamedLattice> everything() {
    std::vector<NamedLattice> all;
    for (const auto& shapes : {zoo(), featureLattices(), meshZoo()})
        for (const NamedLattice& shape : shapes)
            if (shape.lattice.tags.triangles != TriangleSubdivision::Smooth) all.push_back(shape);
    for (unsigned seed = 0; seed < (kIsSlow ? 10 : 60); ++seed)
        all.push_back({"seed " + std::to_string(seed), randomLattice(seed)});
    for (const bool closed : {false, true})
        all.push_back({closed ? "closed curve" : "open curve",
                       {far::buildCurve(6, closed),
                        std::vector<Point3>(6),
                        {.edges = {}, .vertices = {{2, 0.5}, {3, far::kInfinitelySharp}}},
                        {}}});
    // A closed surface with a hexagon that passes a smooth vertex twice, between two triangles.
    all.push_back({"a vertex twice, smooth",
                   {far::buildMesh(5, Loops{{0, 1, 2, 0, 3, 4}, {1, 0, 2}, {3, 0, 4}}),
                    std::vector<Point3>(5),
                    {},
                    {}}});
    return all;
}

/// Calls check(refiner) for each shape, with its own boundary control and without any.
template <class Check>
void forEachRefinedShape(int levels, Check check) {
    for (const auto& [name, lattice] : everything())
        for (const bool isOpen : {false, true}) {
            far::RefinerOptions options = refinerOptions(lattice);
            options.rules = Rules::Mlca;
            if (isOpen) options.boundary = Boundary::Open;
            TopologyRefiner refiner(lattice.complex, options);
            try {
                refiner.refineUniform(levels);
            } catch (const far::TopologyError& error) {
                ASSERT_EQ(error.cause(), far::TopologyCause::EmptyComplex) << name;
                continue;
            }
            SCOPED_TRACE(name + (isOpen ? ", open" : ""));
            check(refiner);
        }
}

TEST(Mlca, SplitsAndAverages) {
    std::map<std::array<int, 3>, int> seen;  // by dimension of the complex and of the entity, and
                                             // stratum
    int fading = 0;
    forEachRefinedShape(2, [&](const TopologyRefiner& refiner) {
        for (int k = 1; k <= 2; ++k) {
            const far::Level& parent = refiner.level(k - 1);
            const auto values = randomValues(parent.complex.count(0), 3);
            const SplitAndAveraged reference(parent, values);
            const auto table = buildLevelTable(refiner, k);
            for (Index row = 0; row < table.rowCount(); ++row) {
                const Entity entity = test::parentOf(refiner, k, row);
                double value = 0;
                for (std::size_t i = 0; i < table.columns(row).size(); ++i)
                    value += table.weights(row)[i] * values[table.columns(row)[i]];
                // Values are below 1. At a pole of 360 faces, up to four thousand terms are each
                // rounded in proportion to their size: 2⁻⁵³ times a sum of 1, a few times.
                ASSERT_NEAR(value, reference.at(entity, refiner.options().creasing), 1e-13)
                    << "level " << k << " row " << row;
                ++seen[{refiner.dimension(), entity.dimension, parent.strata.of(entity)}];
                fading +=
                    far::fadingOf(parent.complex, parent.strata, refiner.options().creasing, entity)
                        .has_value();
            }
        }
    });
    for (int complex = 1; complex <= 3; ++complex)
        for (int stratum = 0; stratum <= complex; ++stratum)
            for (int entity = 0; entity <= stratum; ++entity) {
                const std::array<int, 3> kind = {complex, entity, stratum};
                EXPECT_GT(seen[kind], 0) << complex << entity << stratum;
            }
    EXPECT_GT(fading, shownBySome(1000));
}

// Weights are positive, so refinement stays in the convex hull. The exception is Chaikin's rule for
// sharpness, which extrapolates under all rules.
TEST(Mlca, RowsArePositiveAndSumToOne) {
    forEachRefinedShape(2, [](const TopologyRefiner& refiner) {
        const bool extrapolates = refiner.options().creasing == far::Creasing::Chaikin &&
                                  refiner.level(0).strata.hasSemiSharp();
        const auto table = buildStencils(refiner, 2);
        for (Index row = 0; row < table.rowCount(); ++row) {
            double sum = 0;
            for (const double weight : table.weights(row)) {
                if (!extrapolates) {
                    ASSERT_GT(weight, 0) << "row " << row;
                }
                sum += weight;
            }
            ASSERT_NEAR(sum, 1, 1e-13) << "row " << row;  // as above
        }
    });
}

// On grids, all rules are the cubic B-spline's. All weights are sums of powers of two, so there is
// no rounding.
TEST(Mlca, EqualsCatmullClarkOnGrids) {
    const std::vector<CellComplex> grids = {
        test::grid({4, 3, 5}), test::grid({1, 1, 1}),     test::grid({3, 1, 2}),   gridMesh(5, 4),
        gridMesh(1, 3),        far::buildCurve(7, false), far::buildCurve(5, true)};
    for (const CellComplex& grid : grids)
        for (const Boundary boundary : {Boundary::Sharp, Boundary::Open}) {
            TopologyRefiner refiner(grid, {.boundary = boundary});
            try {
                refiner.refineUniform(2);
            } catch (const far::TopologyError&) {
                EXPECT_EQ(boundary, Boundary::Open);
                continue;
            }
            const TopologyRefiner mlca = withRules(refiner, Rules::Mlca);
            for (const Rules rules : {Rules::Siggraph96, Rules::Cse96}) {
                const TopologyRefiner other = withRules(refiner, rules);
                for (const int level : {1, 2})
                    EXPECT_EQ(buildLevelTable(mlca, level), buildLevelTable(other, level));
                EXPECT_EQ(buildStencils(mlca, 2), buildStencils(other, 2));
            }
        }
}

/// Builds a lattice from a polyhedron: each cell joins a face of the polyhedron with a vertex in
/// the middle. The edge from the middle to a vertex where n faces meet is in n cells.
CellComplex coneOver(const Lattice& polyhedron) {
    far::ComplexBuilder builder(3, polyhedron.complex.count(0));
    const Index middle = builder.addVertex();
    for (const std::vector<Index>& loop : loopsOf(polyhedron)) {
        Loops cell = {loop};
        for (std::size_t i = 0; i < loop.size(); ++i)
            cell.push_back({loop[i], loop[(i + 1) % loop.size()], middle});
        builder.addCell(cell);
    }
    return builder.build();
}

/// Returns lattices that one split cuts into hexahedra: three edges of each cell meet in each
/// vertex.
std::vector<std::pair<std::string, CellComplex>> simpleCells() {
    std::vector<std::pair<std::string, CellComplex>> all = {
        {"star of a tetrahedron", coneOver(shapes::tetrahedron())},
        {"star of an octahedron", coneOver(shapes::octahedron())},
        {"star of an icosahedron", coneOver(shapes::icosahedron())},
        {"star of a bipyramid", coneOver(shapes::bipyramid({.sides = 5}))},
        {"box", test::grid({3, 3, 3})}};
    for (const int sectors : {3, 5, 7})
        all.push_back({std::to_string(sectors) + " wedges, thrice",
                       shapes::cylinder({.sectors = sectors, .layers = 3}).complex});
    return all;
}

// Inside hexahedra, the edge rule is equal to the edge rule of CSE-96-1. The vertex rule differs in
// M only, which counts an edge once for each of its cells. A needs no such weights, since each
// inner face has two cells.
TEST(Mlca, EqualsCse96WithWeightedEdgesInHexahedra) {
    std::set<std::size_t> cellsAtEdges;
    int weighted = 0;
    for (const auto& [name, base] : simpleCells()) {
        const TopologyRefiner refiner = test::refined(base, 3, {.rules = Rules::Mlca});
        const TopologyRefiner cseRefiner = withRules(refiner, Rules::Cse96);
        for (int level = 2; level <= 3; ++level) {
            const CellComplex& complex = refiner.level(level - 1).complex;
            const auto table = buildLevelTable(refiner, level);
            const auto cse = buildLevelTable(cseRefiner, level);
            for (Index cell = 0; cell < complex.count(3); ++cell)
                ASSERT_EQ(complex.relation(3, 0)[cell].size(), 8u) << name;
            for (Index row = 0; row < table.rowCount(); ++row) {
                const Entity entity = test::parentOf(refiner, level, row);
                if (refiner.level(level - 1).strata.of(entity) != 3) continue;
                const auto around = [&](int dimension) {
                    return complex.relation(entity.dimension, dimension)[entity.index];
                };
                Row expected = rowOf(cse, row);
                if (entity.dimension == 1) cellsAtEdges.insert(around(3).size());
                if (entity.dimension == 0) {
                    std::vector<Row> edges, faces, cells;
                    for (const Index edge : around(1))
                        for (std::size_t n = complex.relation(1, 3)[edge].size(); n > 0; --n)
                            edges.push_back(centroid(complex, {1, edge}));
                    for (const Index face : around(2))
                        faces.push_back(centroid(complex, {2, face}));
                    for (const Index cell : around(3))
                        cells.push_back(centroid(complex, {3, cell}));
                    expected = (average(cells) + 3 * average(faces) + 3 * average(edges) +
                                test::point(entity.index)) /
                               8;
                    weighted += difference(expected, rowOf(cse, row)) > 1e-3;
                }
                // The two sums have about fifty terms together, and are 1.
                ASSERT_LE(difference(rowOf(table, row), expected), 4e-15)
                    << name << " level " << level << " row " << row;
            }
        }
    }
    EXPECT_THAT(cellsAtEdges, ::testing::IsSupersetOf({3u, 4u, 5u, 7u}));
    EXPECT_GT(weighted, 10);  // vertices whose edges differ in their number of cells
}

Row mlcaRow(const CellComplex& complex, Entity entity) {
    const TopologyRefiner refiner = test::refined(complex, 1, {.rules = Rules::Mlca});
    return rowOf(buildLevelTable(refiner, 1), pointOf(refiner, 1, entity));
}

// The point of a pyramid is nearer to its apex than the centroid is. The sub-cell at a corner of
// the base is a hexahedron. In its centroid, the apex has the weight (0 + M 1/2 + A 2/3 + C 1/5)/8
// = 41/240, since one of three edges and two of three faces contain the apex. The sub-cell at the
// apex has ten vertices; there, the weight is (1 + 4/2 + 4/3 + 1/5)/10 = 34/75. So the apex has (4
// · 41/240 + 34/75)/5 = 341/1500, and each corner a fourth of the rest.
TEST(Mlca, GoldenPointOfAPyramid) {
    const double apex = 341. / 1500, corner = (1 - apex) / 4;
    expectRow(mlcaRow(singleCell(far::StandardCell::Pyramid), {3, 0}),
              {{0, corner}, {1, corner}, {2, corner}, {3, corner}, {4, apex}});
}

// On the surface of a tetrahedron. A vertex is (Ā + 2M̄ + P)/4: its own weight is (1/3 + 1 + 1)/4 =
// 7/12, and the other vertices have equal weights. An edge is (Ā + M̄' + 2M)/4: each end has 1/3 in
// both centroids, 1/2 in two of the four edges beside the edge, and 1/2 in M: (1/3 + 1/4 + 1)/4 =
// 19/48; the other two vertices have (1/6 + 1/4)/4 = 5/48. Catmull-Clark gives 4/9 to the vertex,
// and 5/12 to each end.
TEST(Mlca, GoldenPointsOfATetrahedralSurface) {
    const CellComplex mesh = far::buildMesh(4, far::faceLoops(far::StandardCell::Tetrahedron));
    const double other = 5. / 36;
    expectRow(mlcaRow(mesh, {0, 2}), {{0, other}, {1, other}, {2, 7. / 12}, {3, other}});
    const auto ends = mesh.relation(1, 0)[0];
    std::map<Index, double> expected = {{0, 5. / 48}, {1, 5. / 48}, {2, 5. / 48}, {3, 5. / 48}};
    for (const Index end : ends) expected[end] = 19. / 48;
    expectRow(mlcaRow(mesh, {1, 0}), expected);
}

// If the loop of a face passes a vertex twice, the vertex has two sub-cells, with two edges each.
TEST(Mlca, SubCellsAreAtPositionsOfALoop) {
    const CellComplex mesh = far::buildMesh(5, Loops{{0, 1, 2, 0, 3, 4}});
    const auto edges = mesh.relation(2, 1)[0];
    EXPECT_EQ(mlcaSubCell(mesh, {2, 0}, 0),
              (std::vector<Entity>{{0, 0}, {1, edges[0]}, {1, edges[5]}, {2, 0}}));
    EXPECT_EQ(mlcaSubCell(mesh, {2, 0}, 3),
              (std::vector<Entity>{{0, 0}, {1, edges[3]}, {1, edges[2]}, {2, 0}}));
}

/// Returns the faces of a prism of two storeys on the triangle a b c, as one cell. Its far storey
/// has either three faces of four corners or, with the same vertices and the same number of faces,
/// one of three corners and one of five: with the edge f–i, or with the edge d–i.
Loops twoStoreys(std::array<Index, 9> v, bool isTurned) {
    const auto [a, b, c, d, e, f, g, h, i] = v;
    Loops loops = {{a, b, c}, {a, b, e, d}, {b, c, f, e}, {c, a, d, f}, {d, e, h, g}, {g, h, i}};
    if (isTurned)
        loops.insert(loops.end(), {{e, f, d, i, h}, {d, g, i}});
    else
        loops.insert(loops.end(), {{e, f, i, h}, {f, d, g, i}});
    return loops;
}

// The point of a cell depends on all edges and faces of the cell, so rows inside an entity depend
// on faces that do not touch the entity. Around the shared triangle, the two pieces look the same
// to Surroundings.
TEST(Mlca, RowsOfLatticesAreNotCopiedByShape) {
    far::ComplexBuilder builder(3, 30);
    for (const Index first : {0, 15})
        for (const Index storey : {3, 9}) {
            std::array<Index, 9> vertices;
            for (Index k = 0; k < 9; ++k) vertices[k] = first + (k < 3 ? k : storey + k - 3);
            builder.addCell(twoStoreys(vertices, first == 15 && storey == 9));
        }
    TopologyRefiner refiner = test::refined(builder.build(), 2, {.rules = Rules::Mlca});
    const auto whole = buildStencils(refiner, 2);
    EXPECT_EQ(whole, multiply(buildLevelTable(refiner, 2), buildLevelTable(refiner, 1)));
    // The two pieces differ on both levels in the point of the shared triangle.
    std::set<std::vector<double>> rows;
    const CellComplex& base = refiner.level(0).complex;
    for (Index face = 0; face < base.count(2); ++face)
        if (base.relation(2, 3)[face].size() == 2) {
            const Index point = pointOf(refiner, 2, {0, pointOf(refiner, 1, {2, face})});
            rows.emplace(whole.weights(point).begin(), whole.weights(point).end());
        }
    EXPECT_EQ(rows.size(), 2u);
}

TEST(Mlca, HasNoSmoothTriangles) {
    for (const CellComplex& complex :
         {test::grid({1, 1, 1}), gridMesh(2, 2), far::buildCurve(3, false)})
        EXPECT_REFUSED(Error, "MLCA do not have smooth triangles",
                       TopologyRefiner(complex, {.rules = Rules::Mlca,
                                                 .triangles = TriangleSubdivision::Smooth}));
}

}  // namespace
}  // namespace espalier::stencils
