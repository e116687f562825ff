// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>

#include "support/rows.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::stencils {
namespace {

using far::kInfinitelySharp;
using far::Marks;

/// The plane of 4 × 4 quadrilaterals; 12 is its middle, 11, 13, 7 and 17 are around it, and 6, 8,
/// 16 and 18 the corners.
StencilTable<double> levelTable(const Marks& marks) {
    TopologyRefiner refiner = refined(gridMesh(4, 4), 1, {.marks = marks});
    return buildLevelTable(refiner, 1);
}

/// The row of the point of the edge from 11 to 12.
Row westRow(const Marks& marks) {
    TopologyRefiner refiner = refined(gridMesh(4, 4), 1, {.marks = marks});
    const CellComplex& base = refiner.level(0).complex;
    for (const Index edge : base.relation(0, 1)[12])
        if (far::contains(base.relation(1, 0)[edge], 11))
            return rowOf(buildLevelTable(refiner, 1),
                         refiner.refinement(1).childOf({{1, edge}, {1, edge}})->index);
    return {};
}

// Smooth, an edge point of a regular mesh is 3/8 of its ends and 1/16 of the four across; sharp,
// the midpoint. A sharpness s between 0 and 1 blends the two.
TEST(SemiSharp, GoldenEdgePoint) {
    const auto blend = [](double s) {
        const double end = s / 2 + (1 - s) * 3 / 8, across = (1 - s) / 16;
        return std::map<Index, double>{{11, end},   {12, end},    {6, across},
                                       {7, across}, {16, across}, {17, across}};
    };
    expectRow(westRow({}), blend(0));
    expectRow(westRow({.edges = {{{11, 12}, 0.75}}}), blend(0.75));
    expectRow(westRow({.edges = {{{11, 12}, 1}}}), {{11, 0.5}, {12, 0.5}});
    expectRow(westRow({.edges = {{{11, 12}, 3.5}}}), {{11, 0.5}, {12, 0.5}});
}

// Smooth, a vertex point of a regular mesh is 9/16 of the old one, 3/32 of each neighbour and 1/64
// of each corner across; on a crease, 3/4 and twice 1/8; on a corner, the old one.
TEST(SemiSharp, GoldenVertexPoint) {
    const double w = 0.5;  // the mean of 0.75 and 0.25
    const double alongCrease = w / 8 + (1 - w) * 3 / 32, across = (1 - w) * 3 / 32;
    const double corner = (1 - w) / 64;
    expectRow(rowOf(levelTable({.edges = {{{11, 12}, 0.75}, {{12, 13}, 0.25}}}), 12),
              {{12, w * 3 / 4 + (1 - w) * 9 / 16},
               {11, alongCrease},
               {13, alongCrease},
               {7, across},
               {17, across},
               {6, corner},
               {8, corner},
               {16, corner},
               {18, corner}});
    // A corner by three edges, of which one fades: 1/4 corner, 3/4 crease along the other two.
    expectRow(
        rowOf(levelTable({.edges = {{{11, 12}, kInfinitelySharp}, {{12, 17}, 5}, {{7, 12}, 0.25}}}),
              12),
        {{12, 0.25 + 0.75 * 3 / 4}, {11, 0.75 / 8}, {17, 0.75 / 8}});
    // A vertex of its own sharpness.
    expectRow(rowOf(levelTable({.vertices = {{12, 2}}}), 12), {{12, 1}});
}

// On a curve, (P₋ + 6P + P₊)/8 smooth, and the vertex itself sharp.
TEST(SemiSharp, GoldenVertexPointOfACurve) {
    for (const bool closed : {false, true}) {
        TopologyRefiner refiner =
            refined(far::buildCurve(6, closed), 1, {.marks = {.vertices = {{2, 0.5}}}});
        expectRow(rowOf(buildLevelTable(refiner, 1), 2), {{1, 1. / 16}, {2, 7. / 8}, {3, 1. / 16}});
    }
}

// TriangleSubdivision::Smooth: of an edge between triangles, each centroid has 0.47, and each end
// 0.03 besides; between a triangle and a square, each centroid has (0.47 + 0.25)/2 = 0.36.
TEST(SemiSharp, GoldenSmoothTriangles) {
    const CellComplex mesh = far::buildMesh(6, Loops{{0, 1, 2}, {1, 0, 3}, {0, 2, 4, 5}});
    TopologyRefiner refiner = refined(mesh, 1, {.triangles = far::TriangleSubdivision::Smooth});
    const auto table = buildLevelTable(refiner, 1);
    const auto edgeRow = [&](Index a, Index b) {
        for (Index edge = 0; edge < mesh.count(1); ++edge) {
            const auto ends = mesh.relation(1, 0)[edge];
            if (std::minmax(ends[0], ends[1]) == std::minmax(a, b))
                return rowOf(table, refiner.refinement(1).childOf({{1, edge}, {1, edge}})->index);
        }
        return Row();
    };
    expectRow(edgeRow(0, 1),
              {{0, 0.03 + 2 * 0.47 / 3}, {1, 0.03 + 2 * 0.47 / 3}, {2, 0.47 / 3}, {3, 0.47 / 3}});
    const double end = (1 - 2 * 0.36) / 2 + 0.36 / 3 + 0.36 / 4;
    expectRow(edgeRow(0, 2), {{0, end}, {2, end}, {1, 0.12}, {4, 0.09}, {5, 0.09}});
    // A sharp edge stays the midpoint.
    expectRow(edgeRow(1, 2), {{1, 0.5}, {2, 0.5}});
}

// Sharpness of exactly k means k levels of the sharp rules, and the smooth ones from then on: on
// the surface of a lattice as on a mesh.
TEST(SemiSharp, WholeSharpnessIsSomeSharpLevelsThenSmoothOnes) {
    const CellComplex box = grid({2, 1, 1});
    Marks sharp, once;
    for (Index edge = 0; edge < box.count(1); ++edge) {
        const auto ends = box.relation(1, 0)[edge];
        once.edges.push_back({{ends[0], ends[1]}, 1});
        sharp.edges.push_back({{ends[0], ends[1]}, kInfinitelySharp});
    }
    for (Index vertex = 0; vertex < box.count(0); ++vertex) once.vertices.push_back({vertex, 1});
    TopologyRefiner fading(box, {.marks = once}), always(box, {.marks = sharp});
    fading.refineUniform(2);
    always.refineUniform(1);
    EXPECT_EQ(buildLevelTable(fading, 1), buildLevelTable(always, 1));

    const auto& [middle, strata, holes] = fading.level(1);
    Marks smooth;
    for (Index edge = 0; edge < middle.count(1); ++edge) {
        const auto ends = middle.relation(1, 0)[edge];
        smooth.edges.push_back({{ends[0], ends[1]}, far::kSmooth});
    }
    for (Index vertex = 0; vertex < middle.count(0); ++vertex)
        smooth.vertices.push_back({vertex, far::kSmooth});
    TopologyRefiner never = refined(middle, 1, {.marks = smooth});
    EXPECT_EQ(buildLevelTable(fading, 2), buildLevelTable(never, 1));
}

// Rows near a vertex of 360 edges keep double precision: P has the weight 358/360 + 360/(3·360²) in
// the cone of triangles, and 721 shares add up to it.
TEST(Stencils, PoleOf360EdgesKeepsItsPrecision) {
    const Index n = 360;
    Loops loops;
    for (Index i = 0; i < n; ++i) {
        loops.push_back({0, 2 + i, 2 + (i + 1) % n});
        loops.push_back({1, 2 + (i + 1) % n, 2 + i});
    }
    TopologyRefiner refiner = refined(far::buildMesh(n + 2, loops), 2);
    const double exact = 358. / 360 + 1. / (3 * 360);
    EXPECT_NEAR(rowOf(buildLevelTable(refiner, 1), 0).weights.at(0), exact, 2e-16);
    // Two levels: R₂ R₁ by its definition, in long double.
    const auto first = buildLevelTable(refiner, 1), second = buildLevelTable(refiner, 2);
    long double expected = 0;
    for (const auto& [middle, factor] : rowOf(second, 0).weights) {
        const auto row = rowOf(first, middle).weights;
        if (row.count(0)) expected += static_cast<long double>(factor) * row.at(0);
    }
    EXPECT_NEAR(rowOf(buildStencils(refiner, 2), 0).weights.at(0), double(expected), 4e-16);
}

}  // namespace
}  // namespace espalier::stencils
