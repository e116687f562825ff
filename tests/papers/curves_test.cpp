// SPDX-License-Identifier: Apache-2.0

#include "papers/refined_grid.h"
#include "support/complexes.h"
#include "support/test.h"

// Joy & MacCracken CSE-96-1, section 2: uniform cubic B-spline curves.
namespace espalier::stencils {
namespace {

/// Returns the rows of a table in the order of a refined polygon.
std::vector<Row> rowsOf(const RefinedGrid& polygon, int level, const StencilTable<double>& table) {
    std::vector<Row> rows;
    for (Index i = 0; i <= polygon.size(level)[0]; ++i)
        rows.push_back(rowOf(table, polygon.vertexAt(level, {i, 0, 0})));
    return rows;
}

std::vector<Row> levelRows(const RefinedGrid& polygon, int level) {
    return rowsOf(polygon, level, buildLevelTable(polygon.refiner(), level));
}

std::vector<Row> composedRows(const RefinedGrid& polygon, int level) {
    return rowsOf(polygon, level, buildStencils(polygon.refiner(), level));
}

// Section 2.1: the 5 × 4 matrix with rows E0 V0 E1 V1 E2. The first four rows are S^L, the points
// of the first half of the curve, and the last four are S^R. (The printed S^L has a fifth row, 1 6
// 1 0, which belongs to S^R. H1 of the notes is the correct S^L.)
TEST(Curves, FivePointsFromFourEqualTheSplittingMatrix) {
    const double matrix[5][4] = {
        {4, 4, 0, 0}, {1, 6, 1, 0}, {0, 4, 4, 0}, {0, 1, 6, 1}, {0, 0, 4, 4}};
    const RefinedGrid polygon({3}, 1);
    const std::vector<Row> rows = levelRows(polygon, 1);
    ASSERT_EQ(rows.size(), 5u);
    for (Index r = 0; r < 5; ++r) {
        // E0 V0 E1 V1 E2: edge points and vertex points alternate.
        EXPECT_EQ(polygon.parentAt(1, {r, 0, 0}).dimension, r % 2 == 0 ? 1 : 0);
        Row expected;
        double sum = 0;
        for (Index c = 0; c < 4; ++c) {
            expected.weights[c] = matrix[r][c] / 8;
            sum += matrix[r][c] / 8;
        }
        // Eighths are exact.
        EXPECT_EQ(difference(rows[r], expected), 0) << r;
        EXPECT_EQ(sum, 1) << "an affine operation";
    }
}

// The first four points are the control points of the curve from 0 to 1/2, the last four those from
// 1/2 to 1. A half at t is the whole curve at t/2, or (1 + t)/2.
TEST(Curves, HalvesOfTheSplitDefineTheHalvesOfTheCurve) {
    const std::vector<Row> rows = levelRows(RefinedGrid({3}, 1), 1);
    for (int half = 0; half < 2; ++half)
        for (const double t : {0.0, 0.125, 0.5, 0.75, 1.0}) {
            const std::vector<Row> points(rows.begin() + half, rows.begin() + half + 4);
            const Row onHalf = substituted(splineAt(1 + t, 3), points);
            // Sixteen products below 1.
            EXPECT_LE(difference(onHalf, splineAt(1 + (half + t) / 2, 3)), 1e-15) << t;
        }
}

// Section 2.2: refinement makes 2n − 1 points from n + 1.
TEST(Curves, NPlusOnePointsBecomeTwoNMinusOne) {
    for (Index n = 2; n <= 12; ++n) {
        const RefinedGrid polygon({n}, 4);
        Index points = n + 1;
        for (int level = 1; level <= 4; ++level) {
            points = 2 * (points - 1) - 1;
            EXPECT_EQ(polygon.complex(level).count(0), points) << n << " level " << level;
            EXPECT_EQ(polygon.complex(level).count(1), points - 1);
        }
    }
}

// The curve-edge rule E_i = (P_i + P_(i+1))/2, and the curve-vertex rule (E_i + 2P_(i+1) +
// E_(i+1))/4. (Section 2.2 prints 2P_i. By section 2.1, V_0 = (E_0 + 2P_1 + E_1)/4, it is the point
// between the edges i and i + 1.) The vertex point is also the midpoint of the midpoints between
// the vertex and both edge points.
TEST(Curves, EdgeAndVertexRules) {
    for (const Index n : {2, 3, 4, 7, 12}) {
        const RefinedGrid polygon({n}, 3);
        for (int level = 1; level <= 3; ++level) {
            const std::vector<Row> rows = levelRows(polygon, level);
            const auto p = [&](Index i) { return polygon.at(level - 1, {i, 0, 0}); };
            const auto e = [&](Index i) { return (p(i) + p(i + 1)) / 2; };
            const Index edges = polygon.size(level - 1)[0];
            // In the order E0 V0 E1 V1 … of the refined polygon.
            for (Index i = 0; i < edges; ++i) EXPECT_EQ(difference(rows[2 * i], e(i)), 0) << i;
            for (Index i = 0; i + 1 < edges; ++i) {
                const Row& vertex = rows[2 * i + 1];
                EXPECT_EQ(difference(vertex, (e(i) + 2 * p(i + 1) + e(i + 1)) / 4), 0) << i;
                const Row midpoint = ((e(i) + p(i + 1)) / 2 + (p(i + 1) + e(i + 1)) / 2) / 2;
                EXPECT_EQ(difference(vertex, midpoint), 0) << i;
            }
        }
    }
}

// A closed polygon loses no ends: n points become 2n, and every vertex point is (1 6 1)/8.
TEST(Curves, ClosedPolygonsDouble) {
    for (const Index n : {3, 4, 5, 8}) {
        TopologyRefiner refiner =
            test::refined(far::buildCurve(n, true), 3, {.boundary = Boundary::Open});
        for (int level = 1; level <= 3; ++level) {
            const auto table = buildLevelTable(refiner, level);
            ASSERT_EQ(table.rowCount(), n << level);
            const CellComplex& parent = refiner.level(level - 1).complex;
            for (Index vertex = 0; vertex < parent.count(0); ++vertex) {
                Row expected = 4. / 8 * point(vertex);
                for (const Index edge : parent.relation(0, 1)[vertex])
                    for (const Index end : parent.relation(1, 0)[edge])
                        expected = expected + 1. / 8 * point(end);
                const Index row = pointOf(refiner, level, {0, vertex});
                EXPECT_EQ(difference(rowOf(table, row), expected), 0);
                EXPECT_EQ(table.weights(row).size(), 3u);
            }
        }
    }
}

// Under boundary control the ends stay. The polygon is then equal to one without boundary control
// that has a phantom point 2P0 − P1 before its first point, and likewise at its end.
TEST(Curves, FixedEndsEqualAPhantomPoint) {
    const int levels = 4;
    for (const Index n : {1, 2, 3, 6}) {
        const RefinedGrid sharp({n}, levels, Boundary::Sharp), open({n + 2}, levels);
        // Each point of the longer polygon over the points of the shorter one.
        std::vector<Row> extended = {2 * point(0) - point(1)};
        for (Index i = 0; i <= n; ++i) extended.push_back(point(i));
        extended.push_back(2 * point(n) - point(n - 1));
        for (int level = 1; level <= levels; ++level) {
            const std::vector<Row> rows = composedRows(sharp, level);
            const std::vector<Row> openRows = composedRows(open, level);
            ASSERT_EQ(rows.size(), std::size_t(n << level) + 1);
            ASSERT_EQ(openRows.size(), rows.size() + 2);
            EXPECT_EQ(difference(rows.front(), point(0)), 0);
            EXPECT_EQ(difference(rows.back(), point(n)), 0);
            for (std::size_t i = 0; i < rows.size(); ++i)
                // Multiples of 8^-4 below 2 are exact.
                EXPECT_EQ(difference(rows[i], substituted(openRows[i + 1], extended)), 0) << i;
        }
    }
}

// "The successive control polygons will converge to the curve." With the second difference D = P_−
// − 2P + P_+, a vertex point is P + D/8, and its second difference is D/4. So after k levels it is
// P + D (1 + 1/4 + … + 4^(1−k))/8 = P + (1 − 4^−k) D/6. The limit has the weights (1 4 1)/6 of the
// B-spline.
TEST(Curves, VertexPointsConvergeToTheSpline) {
    const int levels = 10;
    const RefinedGrid polygon({4}, levels);
    for (int level = 1; level <= levels; ++level) {
        const double rest = std::ldexp(1.0, -2 * level);
        const std::vector<Row> rows = composedRows(polygon, level);
        for (Index i = 1; i <= 3; ++i) {
            const Row& row = rows[((i - 1) << level) + 1];
            const Row second = point(i - 1) + -2 * point(i) + point(i + 1);
            // Ten sums of three products below 1.
            EXPECT_LE(difference(row, point(i) + (1 - rest) / 6 * second), 4e-15) << level;
            EXPECT_LE(difference(row, splineAt(i, 4)), rest / 3 + 4e-15) << level;
        }
    }
}

// The refined polygon defines the same curve: (P_− + 4P + P_+)/6 is on the curve, for every point
// on every level.
TEST(Curves, RefinedPolygonsDefineTheSameCurve) {
    const Index n = 5;
    const int levels = 5;
    const RefinedGrid polygon({n}, levels);
    for (int level = 0; level <= levels; ++level) {
        const std::vector<Row> rows = composedRows(polygon, level);
        for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
            const double place = 1 + std::ldexp(double(i) - 1, -level);
            const Row onCurve = (rows[i - 1] + 4 * rows[i] + rows[i + 1]) / 6;
            // About twenty products below 1.
            EXPECT_LE(difference(onCurve, splineAt(place, n)), 2e-15) << place;
        }
    }
}

// A cubic a + bx + cx² + dx³ has the coefficient a + bx + c(x² − h²/3) + d(x³ − h²x) at x, for
// knots of spacing h (its polar form at x − h, x, x + h). Refinement does not change the cubic.
TEST(Curves, CubicsStayExact) {
    const Index n = 6;
    const int levels = 3;
    const RefinedGrid polygon({n}, levels);
    const auto coefficient = [](double x, double h) {
        return 0.7 - 1.3 * x + 0.4 * (x * x - h * h / 3) + 0.2 * (x * x * x - h * h * x);
    };
    for (int level = 0; level <= levels; ++level) {
        const std::vector<Row> rows = composedRows(polygon, level);
        const double h = std::ldexp(1.0, -level);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            double value = 0;
            for (const auto& [vertex, weight] : rows[i].weights)
                value += weight * coefficient(vertex, 1);
            // Four products of size up to 50.
            EXPECT_NEAR(value, coefficient(1 + h * (double(i) - 1), h), 5e-14);
        }
    }
}

}  // namespace
}  // namespace espalier::stencils
