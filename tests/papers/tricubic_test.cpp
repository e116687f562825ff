// SPDX-License-Identifier: Apache-2.0

#include <functional>

#include "papers/refined_grid.h"
#include "support/test.h"

// Joy & MacCracken CSE-96-1, section 5: the trivariate cubic uniform B-spline solid.
namespace espalier::stencils {
namespace {

// Each rule is an average of averages of up to 8, 12 and 6 points: about thirty terms below 1/8.
constexpr double kTricubicRounding = 1e-15;

/// The rules of section 5.4, in steps of half an edge. An odd coordinate is in the middle of an
/// edge, so the number of odd coordinates is the dimension of the entity whose middle is at a
/// place.
struct Lattice {
    const RefinedGrid& grid;
    int level;

    static int dimensionAt(const Place& half) {
        return int(half[0] % 2 + half[1] % 2 + half[2] % 2);
    }

    /// Returns the places one step up or down along `steps` of the axes for which isFree() is true.
    static std::vector<Place> around(const Place& half, int steps,
                                     const std::function<bool(std::size_t)>& isFree) {
        std::vector<Place> all;
        for (int mask = 0; mask < 27; ++mask) {
            const Place step = {mask % 3 - 1, mask / 3 % 3 - 1, mask / 9 - 1};
            Place place = half;
            int taken = 0;
            bool isAllowed = true;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                place[axis] += step[axis];
                taken += step[axis] != 0;
                isAllowed = isAllowed && (step[axis] == 0 || isFree(axis));
            }
            if (isAllowed && taken == steps) all.push_back(place);
        }
        return all;
    }

    /// Returns the average of the corners of the entity at a place: the patch-face and the
    /// solid-solid rule, and the midpoint of an edge.
    Row centroid(const Place& half) const {
        std::vector<Row> points;
        for (const Place& p :
             around(half, dimensionAt(half), [&](std::size_t a) { return half[a] % 2 == 1; }))
            points.push_back(grid.at(level, {p[0] / 2, p[1] / 2, p[2] / 2}));
        return average(points);
    }

    /// Returns the average of the centroids of the entities of a higher dimension that contain a
    /// place, and checks their number.
    Row averageAround(const Place& half, int dimension, std::size_t count) const {
        std::vector<Row> rows;
        for (const Place& p : around(half, dimension - dimensionAt(half),
                                     [&](std::size_t a) { return half[a] % 2 == 0; }))
            rows.push_back(centroid(p));
        EXPECT_EQ(rows.size(), count);
        return average(rows);
    }

    Row solid(const Place& half) const { return centroid(half); }
    Row face(const Place& half) const {
        // (S1 + S2 + 2F)/4
        return (2 * averageAround(half, 3, 2) + 2 * centroid(half)) / 4;
    }
    Row edge(const Place& half) const {
        return (averageAround(half, 3, 4) + 2 * averageAround(half, 2, 4) + centroid(half)) / 4;
    }
    Row vertex(const Place& half) const {
        return 1. / 8 * averageAround(half, 3, 8) + 3. / 8 * averageAround(half, 2, 12) +
               3. / 8 * averageAround(half, 1, 6) + 1. / 8 * centroid(half);
    }
};

// Section 5: 4 × 4 × 4 points become 125: 27 solid, 54 face, 36 edge and 8 vertex points.
TEST(Tricubic, PointsByTheirKind) {
    const RefinedGrid grid({3, 3, 3}, 1);
    std::array<int, 4> kinds = {};
    for (const Place& place : grid.places(1)) ++kinds[grid.parentAt(1, place).dimension];
    EXPECT_EQ(kinds, (std::array<int, 4>{8, 36, 54, 27}));
    EXPECT_EQ(grid.places(1).size(), 125u);
}

// Section 5.4: the solid-solid, solid-face, solid-edge and solid-vertex rules by their definitions,
// also on the second level, and for lattices that are not cubes.
TEST(Tricubic, SolidFaceEdgeAndVertexRules) {
    for (const std::vector<Index>& cells :
         std::vector<std::vector<Index>>{{3, 3, 3}, {2, 4, 3}, {5, 2, 2}}) {
        const RefinedGrid grid(cells, 2);
        for (int level = 1; level <= 2; ++level) {
            const Lattice lattice{grid, level - 1};
            const auto table = buildLevelTable(grid.refiner(), level);
            std::array<int, 4> checked = {};
            for (const Place& place : grid.places(level)) {
                const Place half = {place[0] + 1, place[1] + 1, place[2] + 1};
                const int dimension = Lattice::dimensionAt(half);
                const Row expected = dimension == 3   ? lattice.solid(half)
                                     : dimension == 2 ? lattice.face(half)
                                     : dimension == 1 ? lattice.edge(half)
                                                      : lattice.vertex(half);
                const Row got = rowOf(table, grid.vertexAt(level, place));
                ASSERT_LE(difference(got, expected), kTricubicRounding) << dimension;
                ++checked[dimension];
            }
            for (const int count : checked) EXPECT_GT(count, 0);
        }
    }
}

// Sections 5.1 to 5.3: "utilizing the bivariate refinement rules on each plane of the lattice,
// coupled with the univariate rules in the other dimension". So the two derivations of a face point
// (5.1.2 and 5.2.1) agree, and the two derivations of an edge point (5.2.2 and 5.3.1) agree.
TEST(Tricubic, LatticesAreRefinedByPlanesThenAcross) {
    const RefinedGrid grid({3, 4, 3}, 1), plane({3, 4}, 1), line({3}, 1);
    const auto table = buildLevelTable(grid.refiner(), 1);
    const auto planes = buildLevelTable(plane.refiner(), 1);
    const auto across = buildLevelTable(line.refiner(), 1);
    for (const Place& place : grid.places(1)) {
        const Row inPlane = rowOf(planes, plane.vertexAt(1, {place[0], place[1], 0}));
        const Row onLine = rowOf(across, line.vertexAt(1, {place[2], 0, 0}));
        Row expected;
        for (const auto& [vertex, weight] : inPlane.weights) {
            const Place at = plane.places(0)[vertex];
            for (const auto& [k, onAxis] : onLine.weights)
                expected.weights[grid.vertexAt(0, {at[0], at[1], k})] = weight * onAxis;
        }
        EXPECT_LE(difference(rowOf(table, grid.vertexAt(1, place)), expected), kTricubicRounding);
    }
}

// The eight sub-solids: P' is P multiplied by a splitting matrix in each of three directions, H1
// for the first half and its mirror image for the second.
TEST(Tricubic, SubSolidsAreProductsWithTheSplittingMatrices) {
    const double matrix[5][4] = {
        {4, 4, 0, 0}, {1, 6, 1, 0}, {0, 4, 4, 0}, {0, 1, 6, 1}, {0, 0, 4, 4}};
    const auto half = [&](Index which, Index r) {
        Row row;
        for (Index c = 0; c < 4; ++c)
            if (matrix[which + r][c] != 0) row.weights[c] = matrix[which + r][c] / 8;
        return row;
    };
    const RefinedGrid grid({3, 3, 3}, 1);
    const auto table = buildLevelTable(grid.refiner(), 1);
    for (Index solid = 0; solid < 8; ++solid) {
        const Place which = {solid % 2, solid / 2 % 2, solid / 4};
        for (Index point = 0; point < 64; ++point) {
            const Place at = {point % 4, point / 4 % 4, point / 16};
            const Row expected = tensorProduct(grid, half(which[0], at[0]), half(which[1], at[1]),
                                               half(which[2], at[2]));
            const Place place = {which[0] + at[0], which[1] + at[1], which[2] + at[2]};
            EXPECT_LE(difference(rowOf(table, grid.vertexAt(1, place)), expected),
                      kTricubicRounding)
                << solid << " " << point;
        }
    }
}

// The vertex point over the old points is (1 6 1)/8 three times: 216 for the vertex itself, 36 for
// each of 6 neighbours, 6 for each of 12 and 1 for each of 8 diagonals, in 512ths.
TEST(Tricubic, InfluenceOnAVertexPoint) {
    const RefinedGrid grid({2, 2, 2}, 1);
    const auto table = buildLevelTable(grid.refiner(), 1);
    Row expected;
    const double influence[4] = {216, 36, 6, 1};
    for (const Place& place : grid.places(0)) {
        const int away = (place[0] != 1) + (place[1] != 1) + (place[2] != 1);
        expected.weights[grid.vertexAt(0, place)] = influence[away] / 512;
    }
    EXPECT_LE(difference(rowOf(table, grid.vertexAt(1, {1, 1, 1})), expected), kTricubicRounding);
}

}  // namespace
}  // namespace espalier::stencils
