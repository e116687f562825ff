// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/extrude.h>
#include <espalier/shapes/section.h>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

Lattice mesh(std::vector<Point3> positions, const std::vector<std::vector<Index>>& loops) {
    return {far::buildMesh(Index(positions.size()), loops), std::move(positions), {}, {}};
}

/// An L of area 3 as one hexagon (not convex), with a square and a triangle at its ends.
///
///     7---6
///     |   |
///     5---4             The L is 0 1 2 3 4 5, from (0, 0) to (2, 0), (2, 1), (1, 1), (1, 2) and
///     |   |             (0, 2).
///     |   3---2
///     |       | \ .
///     0-------1--8
Lattice lShape() {
    return mesh({{0, 0, 0},
                 {2, 0, 0},
                 {2, 1, 0},
                 {1, 1, 0},
                 {1, 2, 0},
                 {0, 2, 0},
                 {1, 3, 0},
                 {0, 3, 0},
                 {3, 0, 0}},
                {{0, 1, 2, 3, 4, 5}, {5, 4, 6, 7}, {1, 8, 2}});
}

/// A square ring of four trapezoids around a square hole.
Lattice frame() {
    return mesh({{-2, -2, 0},
                 {2, -2, 0},
                 {2, 2, 0},
                 {-2, 2, 0},
                 {-1, -1, 0},
                 {1, -1, 0},
                 {1, 1, 0},
                 {-1, 1, 0}},
                {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

TEST(Extrude, MakesPrismsOfPolygons) {
    for (const int layers : {1, 2, 5}) {
        const Lattice lattice = extrude(lShape(), {{0, 0, 2}, layers});
        // The mesh has 6 + 4 + 3 edges less the 2 that are shared.
        EXPECT_EQ(countsOf(lattice.complex), sweptCounts(9, 11, 3, layers, false));
        EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
        EXPECT_EQ(lattice.complex.relation(3, 2)[0].size(), 8U);
        EXPECT_EQ(lattice.complex.relation(3, 2)[1].size(), 6U);
        EXPECT_EQ(lattice.complex.relation(3, 2)[2].size(), 5U);
        EXPECT_NEAR(totalVolume(lattice), 2 * (3 + 1 + 0.5), kRounding);
        expectValid(lattice);
    }
}

TEST(Extrude, PutsLayersAtEqualDistances) {
    const Lattice lattice = extrude(lShape(), {{3, 6, -9}, 3});
    for (Index layer = 0; layer < 4; ++layer)
        EXPECT_NEAR(
            norm(minus(at(lattice, layer * 9 + 1), {2.0 + layer, 2.0 * layer, -3.0 * layer})), 0,
            kRounding);
    // The mesh faces against this direction, so its faces are reversed, and volumes stay positive.
    EXPECT_NEAR(totalVolume(lattice), 9 * 4.5, kRounding);
    expectValid(lattice);
}

// The area times the length of the direction would vanish or overflow.
TEST(Extrude, TakesDirectionsOfAnyLength) {
    const auto square = [](double side) {
        return mesh({{0, 0, 0}, {side, 0, 0}, {side, side, 0}, {0, side, 0}}, {{0, 1, 2, 3}});
    };
    EXPECT_EQ(extrude(square(1e-10), {{0, 0, 1e-310}}).positions[6],
              (Point3{1e-10, 1e-10, 1e-310}));
    EXPECT_EQ(extrude(square(10), {{0, 0, 1e308}}).positions[6], (Point3{10, 10, 1e308}));
}

TEST(Extrude, NumbersFacesOfACellFromBottomToTopToSides) {
    const CellComplex complex = extrude(lShape()).complex;
    const auto faces = complex.relation(3, 2)[2];
    const auto vertices = [&](std::size_t face) {
        const auto loop = complex.relation(2, 0)[faces[face]];
        std::vector<Index> sorted(loop.begin(), loop.end());
        std::sort(sorted.begin(), sorted.end());
        return sorted;
    };
    EXPECT_EQ(vertices(0), (std::vector<Index>{1, 2, 8}));
    EXPECT_EQ(vertices(1), (std::vector<Index>{10, 11, 17}));
    EXPECT_EQ(vertices(2), (std::vector<Index>{1, 8, 10, 17}));
    EXPECT_EQ(vertices(3), (std::vector<Index>{2, 8, 11, 17}));
    EXPECT_EQ(vertices(4), (std::vector<Index>{1, 2, 10, 11}));
}

TEST(Extrude, KeepsHolesAndSeparatePieces) {
    const Lattice ring = extrude(frame(), {{0, 0, 1}, 2});
    EXPECT_EQ(countsOf(ring.complex), sweptCounts(8, 12, 4, 2, false));
    EXPECT_EQ(ring.complex.eulerCharacteristic(), 0);
    expectValid(ring);

    const Lattice pieces =
        extrude(mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}},
                     {{0, 1, 2}, {3, 5, 4}}));
    EXPECT_EQ(pieces.complex.eulerCharacteristic(), 2);
    expectValid(pieces);
}

TEST(Extrude, ReversesFacesThatAreWoundTheOtherWay) {
    const Lattice mixed = mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}},
                               {{0, 1, 4, 3}, {1, 4, 5, 2}});
    expectValid(extrude(mixed, {{0.5, 0, 1}, 2}));
}

TEST(Extrude, AcceptsSurfacesThatAreNotFlat) {
    // A roof whose faces all face upwards.
    const Lattice roof = mesh({{0, 0, 0}, {1, 0, 1}, {2, 0, 0}, {0, 1, 0}, {1, 1, 1}, {2, 1, 0}},
                              {{0, 1, 4, 3}, {1, 2, 5, 4}});
    const Lattice lattice = extrude(roof, {{0, 0, 3}, 1});
    EXPECT_NEAR(totalVolume(lattice), 3 * 2, kRounding);  // height times projected area
    expectValid(lattice);
}

TEST(Extrude, RefusesFacesWithoutVolume) {
    const Lattice wall = mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}},
                              {{0, 1, 2, 3}, {1, 4, 5, 2}});
    EXPECT_MESSAGE(
        "extrude: face 1 of the mesh lies along the direction (0, 0, 1) or has no area; its "
        "cells would have no volume",
        extrude(wall));
    // A hook: face 1 overhangs face 0.
    const Lattice fold = mesh(
        {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}, {0, 2, 0}, {2, 2, 0}},
        {{0, 1, 2, 3}, {1, 4, 5, 2}, {3, 2, 7, 6}});
    EXPECT_MESSAGE(
        "extrude: face 1 of the mesh faces away from the direction (1, 0, 3), unlike its "
        "neighbours; its cells would have a negative volume",
        extrude(fold, {{1, 0, 3}, 1}));
}

TEST(Extrude, RefusesComplexesThatAreNotMeshes) {
    const Lattice solid = extrude(frame());
    EXPECT_MESSAGE("extrude: the mesh is a lattice; expected a mesh", extrude(solid));
    const Lattice fins = mesh({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}},
                              {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
    EXPECT_MESSAGE("extrude: edge (0, 1) of the mesh lies in 3 faces; expected 1 or 2",
                   extrude(fins));
    Lattice broken = frame();
    broken.positions.pop_back();
    EXPECT_MESSAGE("extrude: the mesh has 7 positions; expected 8, one for each vertex",
                   extrude(broken));
    broken = frame();
    broken.positions[3][1] = kInfinity;
    EXPECT_MESSAGE("extrude: vertex 3 of the mesh is at (-2, inf, 0); expected finite numbers",
                   extrude(broken));
    broken = frame();
    broken.attributes.push_back({"u", 2, std::vector<double>(8)});
    EXPECT_MESSAGE("extrude: attribute 'u' of the mesh has 8 values; expected 16", extrude(broken));
    broken = frame();
    broken.marks.vertices.push_back({8});
    EXPECT_MESSAGE("extrude: a mark of the mesh names vertex 8; there are 8", extrude(broken));
}

TEST(Extrude, CopiesAttributesToEachLayer) {
    Lattice flat = mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    flat.attributes.push_back({"uv", 2, {1, 2, 3, 4, 5, 6}});
    flat.integers.push_back({"material", 1, IntegerType::Int8, {1, 2, 3}});
    const Lattice lattice = extrude(flat, {{0, 0, 1}, 2});
    ASSERT_EQ(lattice.integers.size(), 1U);
    EXPECT_EQ(lattice.integers[0].type, IntegerType::Int8);
    EXPECT_EQ(lattice.integers[0].values, (std::vector<std::int64_t>{1, 2, 3, 1, 2, 3, 1, 2, 3}));
    ASSERT_EQ(lattice.attributes.size(), 1U);
    EXPECT_EQ(lattice.attributes[0].name, "uv");
    EXPECT_EQ(lattice.attributes[0].components, 2);
    EXPECT_EQ(lattice.attributes[0].values,
              (std::vector<double>{1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6}));
}

TEST(Extrude, CarriesMarksToTheEndsAndAlongTheSweep) {
    Lattice flat = frame();
    flat.marks.edges.push_back({{1, 5}, far::kInfinitelySharp});
    flat.marks.vertices.push_back({2, far::kInfinitelySharp});
    const Lattice lattice = extrude(flat, {{0, 0, 1}, 2});
    const far::Marks expected = {{{{1, 5}, far::kInfinitelySharp},
                                  {{17, 21}, far::kInfinitelySharp},
                                  {{2, 10}, far::kInfinitelySharp},
                                  {{10, 18}, far::kInfinitelySharp}},
                                 {{2, far::kInfinitelySharp}, {18, far::kInfinitelySharp}}};
    EXPECT_EQ(lattice.marks, expected);
    expectValid(lattice);
    // The corner of the mesh is now the end of a sharp edge of the lattice.
    const far::Strata strata =
        far::classify(lattice.complex, Boundary::Sharp, far::SharpEdges::SingleCell, lattice.marks);
    EXPECT_EQ(strata.of({1, edgeBetween(lattice.complex, 2, 10)}), 1);
    EXPECT_EQ(strata.of({1, edgeBetween(lattice.complex, 1, 9)}), 2);
}

TEST(Sweep, ClosesIntoARing) {
    const Lattice triangle = mesh({{2, 0, 0}, {2, 0, 1}, {1, 0, 0}}, {{0, 1, 2}});
    const std::vector<Affine> stations = {rotation({0, 0, 1}, 0), rotation({0, 0, 1}, 2),
                                          rotation({0, 0, 1}, 4)};
    const Lattice ring = sweep(triangle, stations, SweepEnds::Closed);
    EXPECT_EQ(countsOf(ring.complex), sweptCounts(3, 3, 1, 3, true));
    EXPECT_EQ(ring.complex.eulerCharacteristic(), 0);
    // The triangle faces −y, away from the next station, so volumes are negative, as documented.
    EXPECT_LT(totalVolume(ring), 0);
}

TEST(Sweep, AcceptsLayersOfAnyShape) {
    const Lattice flat = gridMesh({{2, 1}});
    std::vector<std::vector<Point3>> layers(3, flat.positions);
    for (Point3& position : layers[1]) position = {2 * position[0], position[1], 1};
    for (Point3& position : layers[2]) position = {position[0], position[1] + position[0], 2};
    const Lattice lattice = sweep(flat, layers);
    EXPECT_EQ(lattice.positions[6 + 2], (Point3{4.0 / 2, 0, 1}));
    EXPECT_EQ(countsOf(lattice.complex), sweptCounts(6, 7, 2, 2, false));
    expectValid(lattice);
}

TEST(Sweep, WrapsAClosedSurfaceInAShell) {
    // The surface of an octahedron, swept outwards through two layers: a ball with a cavity.
    const Lattice octahedron = mesh(
        {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}});
    const std::vector<Affine> stations = {Affine{}, scaling({1.5, 1.5, 1.5}), scaling({2, 2, 2})};
    const Lattice shell = sweep(octahedron, stations);
    EXPECT_EQ(shell.complex.eulerCharacteristic(), 2);
    EXPECT_NEAR(totalVolume(shell), (8 - 1) * 4.0 / 3, kRounding);
    expectValid(shell);
}

TEST(Sweep, RefusesLayersThatDoNotFit) {
    const Lattice flat = gridMesh();
    std::vector<std::vector<Point3>> layers(2, flat.positions);
    EXPECT_MESSAGE("sweep: layers: expected 3 or more, got 2",
                   sweep(flat, layers, SweepEnds::Closed));
    EXPECT_MESSAGE("sweep: layers: expected 2 or more, got 1",
                   sweep(flat, std::span(layers).first(1)));
    layers[1].pop_back();
    EXPECT_MESSAGE("sweep: layer 1 has 3 positions; expected 4, one for each vertex of the mesh",
                   sweep(flat, layers));
    layers[1].push_back({0, kNan, 0});
    EXPECT_MESSAGE("layers[1][3] is (0, nan, 0); expected finite numbers", sweep(flat, layers));
}

TEST(Sweep, RefusesAMoebiusBand) {
    // Five quadrilaterals in a ring, with a half twist between the last and the first. Positions do
    // not matter for the topology.
    std::vector<std::vector<Index>> loops;
    for (Index i = 0; i < 4; ++i) loops.push_back({2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1});
    loops.push_back({8, 1, 0, 9});
    const Lattice band = mesh(std::vector<Point3>(10, Point3{0, 0, 0}), loops);
    const std::vector<Affine> stations = {Affine{}, translation({0, 0, 1})};
    EXPECT_EQ(causeOf([&] { sweep(band, stations); }), far::TopologyCause::NotOrientable);
}

}  // namespace
}  // namespace espalier::shapes
