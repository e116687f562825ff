// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>

#include "support/rows.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::stencils {
namespace {

using far::kInfinitelySharp;
using far::Marks;

/// Returns R_1 of a plane of 4 × 4 quadrilaterals. Vertex 12 is its middle; 11, 13, 7 and 17 are
/// its neighbours, and 6, 8, 16 and 18 are diagonal to it.
StencilTable<double> levelTable(const Marks& marks) {
    TopologyRefiner refiner = refined(gridMesh(4, 4), 1, {.marks = marks});
    return buildLevelTable(refiner, 1);
}

/// Returns the row of the point of the edge from 11 to 12.
Row westRow(const Marks& marks) {
    TopologyRefiner refiner = refined(gridMesh(4, 4), 1, {.marks = marks});
    const CellComplex& base = refiner.level(0).complex;
    for (const Index edge : base.relation(0, 1)[12])
        if (far::contains(base.relation(1, 0)[edge], 11))
            return rowOf(buildLevelTable(refiner, 1),
                         refiner.refinement(1).childOf({{1, edge}, {1, edge}})->index);
    return {};
}

// The smooth edge point of a regular mesh is 3/8 of each end and 1/16 of each of the four vertices
// across; the sharp one is the midpoint. A sharpness s between 0 and 1 blends the two.
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

// The smooth vertex point of a regular mesh is 9/16 of the old point, 3/32 of each neighbour and
// 1/64 of each diagonal vertex; on a crease, 3/4 of the old point and 1/8 of each of two
// neighbours; at a corner, the old point.
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
    // A corner by three edges, one of which fades: 1/4 corner, and 3/4 crease along the other two.
    expectRow(
        rowOf(levelTable({.edges = {{{11, 12}, kInfinitelySharp}, {{12, 17}, 5}, {{7, 12}, 0.25}}}),
              12),
        {{12, 0.25 + 0.75 * 3 / 4}, {11, 0.75 / 8}, {17, 0.75 / 8}});
    // A vertex that is sharp itself.
    expectRow(rowOf(levelTable({.vertices = {{12, 2}}}), 12), {{12, 1}});
}

// On a curve, the smooth rule is (P₋ + 6P + P₊)/8, and the sharp rule the vertex itself.
TEST(SemiSharp, GoldenVertexPointOfACurve) {
    for (const bool closed : {false, true}) {
        TopologyRefiner refiner =
            refined(far::buildCurve(6, closed), 1, {.marks = {.vertices = {{2, 0.5}}}});
        expectRow(rowOf(buildLevelTable(refiner, 1), 2), {{1, 1. / 16}, {2, 7. / 8}, {3, 1. / 16}});
    }
}

// TriangleSubdivision::Smooth: in an edge between two triangles, each centroid has the weight 0.47,
// and each end 0.03 in addition; between a triangle and a square, each centroid has (0.47 + 0.25)/2
// = 0.36.
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
    // A sharp edge still gives the midpoint.
    expectRow(edgeRow(1, 2), {{1, 0.5}, {2, 0.5}});
}

// A sharpness of exactly k means k levels of the sharp rules, followed by the smooth rules, on the
// surface of a lattice as on a mesh.
TEST(SemiSharp, IntegerSharpnessGivesSharpLevelsThenSmoothOnes) {
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

// Rows near a vertex of 360 edges keep double precision. In the cone of triangles, P has the weight
// 358/360 + 360/(3·360²), which is the sum of 721 terms.
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
    // Two levels: R₂ R₁ by definition, in long double.
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
