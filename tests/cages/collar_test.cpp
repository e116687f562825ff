// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/vector3.h>
#include <espalier/cages/collar.h>
#include <espalier/far/box_grid.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/shapes/transform.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <numbers>
#include <random>
#include <string>

#include "lattice_measures.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

using embed::Continuity;

Lattice boxLattice() {
    return shapes::box({{3, 2, 1}, {0, 0, 0}, {3, 2, 1}});
}

/// Three unit cells in the shape of an L: it has a concave edge.
Lattice lShape() {
    return shapes::merge(shapes::box({{2, 1, 1}, {0, 0, 0}, {2, 1, 1}}),
                         shapes::box({{1, 1, 1}, {0, 1, 0}, {1, 2, 1}}));
}

using Corners = std::array<Point3, 2>;
using Words = std::vector<std::string>;

void expectKeepsLattice(const Collar& collar, const Lattice& lattice) {
    for (std::size_t v = 0; v < lattice.positions.size(); ++v)
        EXPECT_EQ(collar.lattice.positions[v], lattice.positions[v]) << v;
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
        EXPECT_TRUE(std::ranges::equal(collar.lattice.complex.relation(3, 0)[cell],
                                       lattice.complex.relation(3, 0)[cell]));
    EXPECT_THAT(test::badCells(collar.lattice), IsEmpty());
}

TEST(Collar, OfABoxIsALargerBox) {
    const Lattice lattice = boxLattice();
    const Collar collar = cages::collar(lattice, {.layers = 2, .reach = 3});
    expectKeepsLattice(collar, lattice);
    EXPECT_TRUE(collar.isGrid);
    EXPECT_EQ(far::asBoxGrid(collar.lattice.complex).cells, (std::array<Index, 3>{7, 6, 5}));
    const BoundingBox bounds(collar.lattice.positions);
    EXPECT_EQ(bounds.min, (Point3{-3, -3, -3}));
    EXPECT_EQ(bounds.max, (Point3{6, 5, 4}));
    EXPECT_EQ(collar.reach[0], 3);
    EXPECT_EQ(collar.reach[1], 3);
    // The cells of the box are 1 thick: the layers are 1 and 2 thick. So each coordinate is one of
    // the planes.
    for (const Point3& position : collar.lattice.positions)
        for (std::size_t a = 0; a < 3; ++a) {
            const double size = 3.0 - double(a);
            const double planes[] = {-3, -1, size + 1, size + 3};
            const bool isOld =
                position[a] == std::round(position[a]) && position[a] >= 0 && position[a] <= size;
            EXPECT_TRUE(
                isOld ||
                std::ranges::any_of(
                    planes, [&](double plane) { return std::abs(plane - position[a]) < 1e-12; }))
                << position[a];
        }
}

TEST(Collar, HoldsTwoOuterLayersOfVertices) {
    const Lattice lattice = boxLattice();
    for (const int layers : {1, 2, 3, 4}) {
        const Collar collar = cages::collar(lattice, {.layers = layers, .reach = 2});
        // Vertices of a box of (3 + 2m) × (2 + 2m) × (1 + 2m) cells.
        const auto count = [](int m) { return (4 + 2 * m) * (3 + 2 * m) * (2 + 2 * m); };
        const int heldLayers = layers == 1 ? 1 : 2;
        EXPECT_EQ(std::ssize(collar.held), count(layers) - count(layers - heldLayers));
        EXPECT_EQ(shapes::heldVertices(collar.lattice), collar.held);
        EXPECT_EQ(collar.continuity, layers == 1 ? Continuity::C0 : Continuity::C2);
    }
    EXPECT_EQ(cages::collar(lattice, {.layers = 4, .reach = 2, .held = 3}).held.size(),
              std::size_t(12 * 11 * 10 - 6 * 5 * 4));
    EXPECT_EQ(cages::collar(lattice, {.layers = 4, .reach = 2, .held = 1}).continuity,
              Continuity::C0);
    // Vertices that the lattice held before are held still.
    Lattice withHeld = lattice;
    const Index some[] = {0};
    shapes::setHeldVertices(withHeld, some);
    const Collar collar = cages::collar(withHeld, {.layers = 2, .reach = 2});
    EXPECT_EQ(shapes::heldVertices(collar.lattice).size(), collar.held.size() + 1);
}

/// Returns, for layers 0 to 2 of vertices of a level from the boundary inwards, the largest
/// displacement in the layer.
std::array<double, 3> displacementsByLayer(const Collar& collar, std::span<const Point3> pose,
                                           int level) {
    far::TopologyRefiner refiner(collar.lattice.complex, refinerOptions(collar.lattice));
    refiner.refineUniform(level);
    const far::CellComplex& complex = refiner.level(level).complex;
    const auto rest = stencils::refinePositions(refiner, level, collar.lattice.positions);
    const auto posed = stencils::refinePositions(refiner, level, pose);
    std::vector<int> layerOf(rest.size(), 3);
    for (Index face = 0; face < complex.count(2); ++face)
        if (complex.relation(2, 3)[face].size() == 1)
            for (const Index vertex : complex.relation(2, 0)[face]) layerOf[vertex] = 0;
    for (int layer = 1; layer < 3; ++layer)
        for (Index cell = 0; cell < complex.count(3); ++cell) {
            const auto vertices = complex.relation(3, 0)[cell];
            if (std::ranges::none_of(vertices, [&](Index v) { return layerOf[v] == layer - 1; }))
                continue;
            for (const Index v : vertices) layerOf[v] = std::min(layerOf[v], layer);
        }
    std::array<double, 3> largest = {};
    for (std::size_t v = 0; v < rest.size(); ++v)
        if (layerOf[v] < 3)
            largest[layerOf[v]] =
                std::max(largest[layerOf[v]], length(difference(posed[v], rest[v])));
    return largest;
}

std::vector<Point3> randomPose(const Collar& collar) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> number(-1, 1);
    auto pose = collar.lattice.positions;
    for (std::size_t v = 0; v < pose.size(); ++v)
        if (!std::ranges::binary_search(collar.held, static_cast<Index>(v)))
            for (double& x : pose[v]) x += number(random);
    return pose;
}

TEST(Collar, LetsMotionFadeOutC2) {
    // The displacement in the second layer of vertices of a level, whose distance from the boundary
    // halves, falls by 1/8 from level to level where the lattice is regular, and by at most 0.132
    // elsewhere (collar.h). By 1/4 or less slowly, second derivatives would not vanish.
    for (const Lattice& lattice : {boxLattice(), lShape()}) {
        const Collar collar = cages::collar(lattice, {.layers = 3, .reach = 3});
        const double most = collar.isGrid ? 0.125 : 0.132;
        const auto pose = randomPose(collar);
        double before = displacementsByLayer(collar, pose, 0)[2];
        ASSERT_GT(before, 0.5);
        for (const int level : {1, 2, 3}) {
            const auto [outer, next, second] = displacementsByLayer(collar, pose, level);
            EXPECT_EQ(outer, 0);
            EXPECT_EQ(next, 0);
            EXPECT_LE(second, (most + 1e-12) * before);
            EXPECT_GT(second, 0);
            before = second;
        }
    }
}

TEST(Collar, OfOneHeldLayerLeavesASlope) {
    // The displacement in the first layer only halves, as its distance from the boundary does.
    const Collar collar = cages::collar(boxLattice(), {.layers = 3, .reach = 3, .held = 1});
    const auto pose = randomPose(collar);
    double before = displacementsByLayer(collar, pose, 1)[1];
    for (const int level : {2, 3}) {
        const auto [outer, next, second] = displacementsByLayer(collar, pose, level);
        EXPECT_EQ(outer, 0);
        EXPECT_GT(next, 0.4 * before);
        before = next;
    }
}

TEST(Collar, ReachesToABoxExactly) {
    const CollarOptions options{.layers = 3, .until = Corners{{{-7.1, -0.3, -9}, {20.7, 30, 5}}}};
    const Collar collar = cages::collar(boxLattice(), options);
    expectKeepsLattice(collar, boxLattice());
    const BoundingBox bounds(collar.lattice.positions);
    EXPECT_EQ(bounds.min, (*options.until)[0]);
    EXPECT_EQ(bounds.max, (*options.until)[1]);
    EXPECT_REFUSED(ArgumentError, "its side +y has a vertex at 2",
                   cages::collar(boxLattice(), {.until = Corners{{{-1, -1, -1}, {9, 2, 9}}}}));
    EXPECT_REFUSED(ArgumentError, "until: expected a box lattice",
                   cages::collar(lShape(), {.until = Corners{{{-1, -1, -1}, {9, 9, 9}}}}));
}

TEST(Collar, LeavesOpenSidesInTheirPlanes) {
    for (const Lattice& lattice : {boxLattice(), lShape()}) {
        CollarOptions options{.layers = 2, .reach = 1};
        options.open = sidesOf(Words{"z"});
        // The step of the L is below its end +y, and grows beyond it.
        options.open[3] = lattice.complex.count(3) == 6;
        const Collar collar = cages::collar(lattice, options);
        expectKeepsLattice(collar, lattice);
        const BoundingBox bounds(collar.lattice.positions);
        EXPECT_EQ(bounds.min[2], 0);
        EXPECT_EQ(bounds.max[2], 1);
        if (options.open[3]) {
            EXPECT_EQ(bounds.max[1], 2);
        }
        EXPECT_LT(bounds.min[1], -0.9);
        for (const Point3& position : collar.lattice.positions)
            EXPECT_TRUE(position[2] == 0 || position[2] == 1);
    }
    EXPECT_REFUSED(Error, "all six sides of the lattice are open",
                   cages::collar(boxLattice(), {.reach = 1, .open = {1, 1, 1, 1, 1, 1}}));
    for (const char* word : {"up", "", "x "})
        EXPECT_REFUSED(ArgumentError, "an axis x, y or z", sidesOf(Words{word}));
    EXPECT_EQ(sidesOf(Words{"-y", "z"}), (std::array<bool, 6>{0, 0, 1, 0, 1, 1}));
}

TEST(Collar, LeavesAPlaneOfSymmetryOpen) {
    const auto boundsOf = [](const CollarOptions& options) {
        return BoundingBox(cages::collar(boxLattice(), options).lattice.positions);
    };
    const BoundingBox at2 = boundsOf({.reach = 1, .symmetry = {{1, 2.0}}});
    EXPECT_EQ(at2.max, (Point3{4, 2, 2}));
    EXPECT_EQ(at2.min, (Point3{-1, -1, -1}));
    EXPECT_EQ(boundsOf({.reach = 1, .symmetry = {{0, {}}}}).min, (Point3{0, -1, -1}));
    // The plane in the middle has no side in it.
    EXPECT_EQ(boundsOf({.reach = 1, .symmetry = {{1, 1.0}}}).max, (Point3{4, 3, 2}));
    EXPECT_REFUSED(ArgumentError, "symmetry: expected axis 0, 1 or 2, got 3",
                   boundsOf({.reach = 1, .symmetry = {{3, {}}}}));
}

TEST(Collar, KeepsVerticesInTwoOpenPlanes) {
    // Both lattices have vertices in the planes x = 0 and y = 0, and in both at once. The L with a
    // thin collar is one whose cells fold at first, so that vertices are moved.
    for (const Lattice& lattice : {boxLattice(), lShape()})
        for (const double reach : {0.5, 2.0}) {
            const Collar collar = cages::collar(
                lattice, {.layers = 2, .reach = reach, .open = sidesOf(Words{"-x", "-y"})});
            expectKeepsLattice(collar, lattice);
            const BoundingBox bounds(collar.lattice.positions);
            EXPECT_EQ(bounds.min[0], 0);
            EXPECT_EQ(bounds.min[1], 0);
            // Around the L, each of the 6 vertices in a plane has one in each of 2 layers, and 2 of
            // the 6 are in both planes. The box has 4 × 3 × 2 vertices, and grows to 6 × 5 × 6.
            std::array<int, 3> count = {};
            for (std::size_t v = lattice.positions.size(); v < collar.lattice.positions.size();
                 ++v) {
                const Point3& p = collar.lattice.positions[v];
                count[0] += p[0] == 0;
                count[1] += p[1] == 0;
                count[2] += p[0] == 0 && p[1] == 0;
            }
            EXPECT_EQ(count, collar.isGrid
                                 ? (std::array<int, 3>{5 * 6 - 3 * 2, 6 * 6 - 4 * 2, 6 - 2})
                                 : (std::array<int, 3>{6 * 2, 6 * 2, 2 * 2}));
        }
}

TEST(Collar, WorksAroundLatticesThatAreInsideOut) {
    // Mirrored positions, without the faces reversed.
    for (Lattice lattice : {boxLattice(), lShape()}) {
        const Collar right = cages::collar(lattice, {.layers = 2, .reach = 1});
        for (Point3& position : lattice.positions) position[0] = -position[0];
        const Collar left = cages::collar(lattice, {.layers = 2, .reach = 1});
        EXPECT_EQ(left.isGrid, right.isGrid);
        EXPECT_EQ(left.held, right.held);
        for (std::size_t v = 0; v < lattice.positions.size(); ++v)
            EXPECT_EQ(left.lattice.positions[v], lattice.positions[v]);
        const BoundingBox bounds(left.lattice.positions), mirrored(right.lattice.positions);
        EXPECT_NEAR(bounds.min[0], -mirrored.max[0], 1e-9);
        EXPECT_NEAR(bounds.max[1], mirrored.max[1], 1e-9);
        // All cells are inside out, as the lattice is.
        EXPECT_THAT(test::badCells(left.lattice), IsEmpty());
        EXPECT_LT(test::limitVolume(left.lattice), 0);
    }
}

TEST(Collar, KeepsTheReachAroundLatticesThatAreNotBoxes) {
    // In the thin collar all cells fold at first.
    for (const auto& [layers, reach] : {std::pair(3, 0.5), {2, 1.0}, {3, 2.0}, {3, 4.0}}) {
        const Collar collar = cages::collar(lShape(), {.layers = layers, .reach = reach});
        // The L is two boxes.
        const auto distanceFrom = [](const Point3& p, const Point3& high) {
            Point3 way = {};
            for (std::size_t a = 0; a < 3; ++a) way[a] = p[a] - std::clamp(p[a], 0.0, high[a]);
            return length(way);
        };
        std::vector<double> distances;
        // The 16 vertices of the last layer.
        for (std::size_t v = collar.lattice.positions.size() - 16;
             v < collar.lattice.positions.size(); ++v) {
            const Point3& p = collar.lattice.positions[v];
            distances.push_back(std::min(distanceFrom(p, {2, 1, 1}), distanceFrom(p, {1, 2, 1})));
        }
        const auto [least, most] = std::ranges::minmax(distances);
        EXPECT_GE(least, reach);
        EXPECT_LE(most, 2 * reach);
        EXPECT_NEAR(collar.reach[0], least, 1e-9);
        EXPECT_NEAR(collar.reach[1], most, 1e-9);
    }
}

TEST(Collar, RefusalsNameAVertexAndOptionsThatWork) {
    const auto messageOf = [](const CollarOptions& options) {
        try {
            cages::collar(lShape(), options);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const std::string message = messageOf({.layers = 3, .reach = 0.25});
    EXPECT_THAT(message, HasSubstr("cells would be thicker than twice the reach near vertex"));
    EXPECT_THAT(message, HasSubstr("a collar of 1 layer works"));
    EXPECT_EQ(messageOf({.layers = 1, .reach = 0.25}), "");
}

TEST(Collar, OpenSidesMustFaceOneDirectionEach) {
    // Turned by 45°, two sides face each of these directions equally well.
    const Lattice turned =
        shapes::transformed(shapes::box({{2, 2, 2}, {-1, -1, -1}, {1, 1, 1}}),
                            shapes::rotation({0, 0, 1}, 0.25 * std::numbers::pi));
    for (std::size_t side = 0; side < 4; ++side) {
        CollarOptions options{.layers = 2, .reach = 1};
        options.open[side] = true;
        EXPECT_REFUSED(ArgumentError,
                       "open: expected a direction that one side of the lattice faces",
                       cages::collar(turned, options));
    }
    const CollarOptions options{.layers = 2, .reach = 1, .open = sidesOf(Words{"z"})};
    EXPECT_EQ(BoundingBox(cages::collar(turned, options).lattice.positions).max[2], 1);
    // The side that faced x faces between x and z, at 45°; the others are at 60° from both.
    const Lattice between =
        shapes::transformed(boxLattice(), shapes::rotation({0, 1, 0}, -0.25 * std::numbers::pi) *
                                              shapes::rotation({1, 0, 0}, 0.25 * std::numbers::pi));
    EXPECT_REFUSED(ArgumentError, "two directions, each of a side of its own",
                   cages::collar(between, {.reach = 1, .open = sidesOf(Words{"+x", "+z"})}));
    EXPECT_TRUE(cages::collar(between, {.reach = 1, .open = sidesOf(Words{"+x"})}).isGrid);
}

TEST(Collar, KeepsOtherDataNamedHeld) {
    Lattice lattice = boxLattice();
    lattice.attributes = {{"held", 1, std::vector<double>(lattice.positions.size(), 0.5)}};
    EXPECT_REFUSED(Error, "point data with the name \"held\"",
                   cages::collar(lattice, {.layers = 1, .reach = 1}));
}

TEST(Collar, CellsThatFoldedBeforeMayFold) {
    // The vertex in the middle of 8 cells is beyond a corner.
    Lattice lattice = shapes::box({{2, 2, 2}, {0, 0, 0}, {2, 2, 2}});
    lattice.positions[13] = {5, 5, 5};
    const auto bad = test::badCells(lattice);
    ASSERT_THAT(bad, Not(IsEmpty()));
    const Collar collar = cages::collar(lattice, {.layers = 2, .reach = 8});
    const auto badWithCollar = test::badCells(collar.lattice);
    EXPECT_TRUE(std::ranges::includes(bad, badWithCollar));
}

TEST(Collar, WorksInLeftHandedAndSkewBoxes) {
    // Mirroring keeps the numbers of vertices, so that the axes of the grid become left-handed.
    const Lattice mirrored = shapes::transformed(boxLattice(), shapes::scaling({-1, 1, 1}));
    const Collar collar = cages::collar(mirrored, {.layers = 2, .reach = 1});
    expectKeepsLattice(collar, mirrored);
    EXPECT_EQ(BoundingBox(collar.lattice.positions).min, (Point3{-4, -1, -1}));
    // A swept and tapered wing.
    Lattice wing = shapes::box({{4, 2, 5}, {0, 0, 0}, {4, 0.4, 8}});
    for (Point3& p : wing.positions) p = {p[0] * (1 - p[2] / 12) + p[2] / 2, p[1], p[2]};
    const Collar around = cages::collar(wing, {.layers = 3, .reach = 2});
    expectKeepsLattice(around, wing);
    EXPECT_TRUE(around.isGrid);
}

TEST(Collar, SurroundsConcaveLattices) {
    for (const double reach : {0.5, 2.0, 4.0}) {
        const Collar collar = cages::collar(lShape(), {.layers = 3, .reach = reach});
        expectKeepsLattice(collar, lShape());
        EXPECT_FALSE(collar.isGrid);
        // 14 boundary faces.
        EXPECT_EQ(collar.lattice.complex.count(3), 3 + 3 * 14);
        EXPECT_EQ(collar.held.size(), 2u * 16);
        EXPECT_GT(collar.reach[0], 0.3 * reach);
    }
}

TEST(Collar, NewVerticesHaveTheAttributesBelow) {
    Lattice lattice = boxLattice();
    lattice.attributes = {{"x", 1, {}}};
    for (const Point3& position : lattice.positions)
        lattice.attributes[0].values.push_back(position[0]);
    const Collar collar = cages::collar(lattice, {.layers = 1, .reach = 0.5});
    for (std::size_t v = 0; v < collar.lattice.positions.size(); ++v)
        EXPECT_EQ(collar.lattice.attributes[0].values[v],
                  std::clamp(collar.lattice.positions[v][0], 0.0, 3.0));
}

TEST(Collar, RefusesWrongOptions) {
    const auto refuses = [](const CollarOptions& options, const char* message) {
        EXPECT_REFUSED(ArgumentError, message, cages::collar(boxLattice(), options));
    };
    refuses({.layers = 0, .reach = 1}, "layers: expected 1 to 100, got 0");
    refuses({.layers = 2}, "a length above 0, or a box to reach until");
    refuses({.layers = 2, .reach = -1}, "reach: expected a length above 0, got -1");
    refuses({.layers = 2, .reach = 1, .until = Corners{{{-9, -9, -9}, {9, 9, 9}}}}, "not both");
    refuses({.layers = 2, .reach = 1, .held = 3}, "held: expected 1 to the number of layers (2)");
    // Two cells that share an edge only have no single outer side there.
    const Lattice touching = shapes::merge(
        shapes::box({{1, 1, 1}}),
        shapes::transformed(shapes::box({{1, 1, 1}}), shapes::translation({1, 1, 0})));
    EXPECT_REFUSED(Error, "without sharing a face there",
                   cages::collar(touching, {.layers = 2, .reach = 1}));
}

}  // namespace
}  // namespace espalier::cages
