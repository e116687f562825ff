// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/level_lattice.h>
#include <espalier/shapes/refiner_options.h>

#include "support/mesh_shapes.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier {
namespace {

std::vector<Point3> anyPositions(const TopologyRefiner& refiner, int level) {
    return std::vector<Point3>(refiner.level(level).complex.count(0));
}

/// Expects that level 1 as a lattice, refined with its own options, has the same levels as the
/// refiner after level 1.
void expectSameLevelsAsRefiner(const Lattice& base, far::RefinerOptions options) {
    options.marks = base.marks;
    TopologyRefiner whole = test::refined(base.complex, 3, options);
    const Lattice level = levelLattice(whole, 1, anyPositions(whole, 1));
    RefinementTags chosen;
    if (base.complex.dimension() == 3 && options.boundary == Boundary::Open)
        chosen.boundary = Boundary::Open;
    TopologyRefiner rest = test::refined(level.complex, 2, refinerOptions(level, chosen));
    for (int k = 0; k <= 2; ++k) {
        const auto& expected = whole.level(1 + k);
        const auto& actual = rest.level(k);
        EXPECT_EQ(actual.holes, expected.holes);
        for (int d = 0; d <= base.complex.dimension(); ++d) {
            ASSERT_EQ(actual.complex.count(d), expected.complex.count(d));
            for (Index i = 0; i < actual.complex.count(d); ++i) {
                if (expected.strata.isOpen({d, i})) continue;  // has no stratum
                ASSERT_EQ(actual.strata.of({d, i}), expected.strata.of({d, i}))
                    << "level " << k << ", entity " << i << " of dimension " << d;
            }
        }
    }
}

TEST(LevelLattice, RefinesToTheSameLevelsAsTheRefiner) {
    for (const auto& [name, lattice] : test::zoo())
        for (const Boundary boundary : {Boundary::Sharp, Boundary::EdgeOnly}) {
            SCOPED_TRACE(name);
            expectSameLevelsAsRefiner(lattice, {.boundary = boundary});
        }
    expectSameLevelsAsRefiner(shapes::box({.cells = {4, 4, 4}}), {.boundary = Boundary::Open});
    expectSameLevelsAsRefiner(shapes::cylinder(), {.sharpEdges = far::SharpEdges::Literal});
}

TEST(LevelLattice, KeepsMarksAndTags) {
    Lattice cube = shapes::box({.cells = {2, 2, 2}});
    cube.marks.vertices = {{0, far::kSmooth}, {13, far::kInfinitelySharp}, {4, 2.5F}};
    cube.marks.edges = {{{13, 14}, far::kInfinitelySharp}, {{1, 4}, 1.5F}};
    expectSameLevelsAsRefiner(cube, {});
    expectSameLevelsAsRefiner(cube, {.boundary = Boundary::EdgeOnly});

    Lattice mesh = test::surfaceOf(shapes::box({.cells = {2, 2, 2}}));
    mesh.marks.vertices = {{3, 2.5F}};
    mesh.marks.holes = {1, 5};
    for (const Boundary boundary : {Boundary::Sharp, Boundary::EdgeOnly, Boundary::Open}) {
        const far::RefinerOptions options{.boundary = boundary,
                                          .creasing = far::Creasing::Chaikin,
                                          .triangles = far::TriangleSubdivision::Smooth};
        expectSameLevelsAsRefiner(mesh, options);
        TopologyRefiner refiner = test::refined(mesh.complex, 1, options);
        EXPECT_EQ(levelLattice(refiner, 1, anyPositions(refiner, 1)).tags,
                  (RefinementTags{boundary, options.creasing, options.triangles}));
    }
}

// A marked corner that the mode would make a corner anyway stays a corner under another mode.
TEST(LevelLattice, MarkedCornersStayMarked) {
    Lattice cube = shapes::box();
    cube.marks.vertices = {{0, far::kInfinitelySharp}};
    for (Index edge = 0; edge < cube.complex.count(1); ++edge) {
        const auto ends = cube.complex.relation(1, 0)[edge];
        cube.marks.edges.push_back({{ends[0], ends[1]}, far::kSmooth});
    }
    TopologyRefiner refiner = test::refined(cube.complex, 1, refinerOptions(cube));
    const Lattice level = levelLattice(refiner, 1, anyPositions(refiner, 1));
    const TopologyRefiner again(level.complex,
                                refinerOptions(level, {.boundary = Boundary::EdgeOnly}));
    EXPECT_EQ(again.level(0).strata.of({0, 0}), 0);
    EXPECT_EQ(again.level(0).strata.of({0, 1}), 2);  // another corner of the cube
}

TEST(LevelLattice, UsesTheGivenPositions) {
    const Lattice cube = shapes::box();
    const TopologyRefiner refiner(cube.complex);
    EXPECT_EQ(levelLattice(refiner, 0, cube.positions).positions, cube.positions);
    EXPECT_THROW(levelLattice(refiner, 1, cube.positions), Error);
    EXPECT_THROW(levelLattice(refiner, 0, {}), Error);
}

}  // namespace
}  // namespace espalier
