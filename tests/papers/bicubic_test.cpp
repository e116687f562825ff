// SPDX-License-Identifier: Apache-2.0

#include <Eigen/LU>

#include "papers/refined_grid.h"
#include "support/test.h"

// Joy, "Bicubic uniform B-spline surface refinement", and CSE-96-1, section 3.
namespace espalier::stencils {
namespace {

using Eigen::Matrix4d;

/// Returns the matrix of the uniform cubic B-spline: P(t) = [1 t t² t³] M P.
Matrix4d splineMatrix() {
    Matrix4d m;
    m << 1, 4, 1, 0, -3, 0, 3, 0, 3, -6, 3, 0, -1, 3, -3, 1;
    return m / 6;
}

/// Returns the splitting matrix of the notes, for the half from 0 to 1/2.
Matrix4d firstHalf() {
    Matrix4d h;
    h << 4, 4, 0, 0, 1, 6, 1, 0, 0, 4, 4, 0, 0, 1, 6, 1;
    return h / 8;
}

/// Returns the matrix of the other half, the mirror image.
Matrix4d secondHalf() {
    return firstHalf().reverse();
}

Row matrixRow(const Matrix4d& matrix, Index row) {
    Row result;
    for (Index column = 0; column < 4; ++column)
        if (matrix(row, column) != 0) result.weights[column] = matrix(row, column);
    return result;
}

// S = M⁻¹ diag(1, 1/2, 1/4, 1/8) M follows from t → t/2. The other half has t → (1 + t)/2, which
// maps t^k to Σ C(k, i) t^i / 2^k.
TEST(Bicubic, SplittingMatrixIsTheReparametrisation) {
    const Matrix4d m = splineMatrix();
    Matrix4d first = Matrix4d::Zero(), second;
    first.diagonal() << 1, 0.5, 0.25, 0.125;
    second << 1, 1. / 2, 1. / 4, 1. / 8, 0, 1. / 2, 2. / 4, 3. / 8, 0, 0, 1. / 4, 3. / 8, 0, 0, 0,
        1. / 8;
    // M has a condition number of about 10.
    EXPECT_LT((m.inverse() * first * m - firstHalf()).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((m.inverse() * second * m - secondHalf()).cwiseAbs().maxCoeff(), 1e-14);
}

// "25 unique sub-control points": 9 face, 12 edge and 4 vertex points. The sub-patch 0 ≤ u, v ≤ 1/2
// has the 16 points P'_rs with r, s < 4: face points have both indices even, vertex points have
// both odd. (The notes' list of edge points omits P'_21.)
TEST(Bicubic, TwentyFivePointsByTheirKind) {
    const RefinedGrid net({3, 3}, 1);
    ASSERT_EQ(net.complex(1).count(0), 25);
    std::array<int, 3> all = {}, ofSubPatch = {};
    for (Index r = 0; r < 5; ++r)
        for (Index s = 0; s < 5; ++s) {
            const int dimension = net.parentAt(1, {r, s, 0}).dimension;
            EXPECT_EQ(dimension, (r % 2 == 0) + (s % 2 == 0));
            ++all[dimension];
            if (r < 4 && s < 4) ++ofSubPatch[dimension];
        }
    EXPECT_EQ(all, (std::array<int, 3>{4, 12, 9}));
    EXPECT_EQ(ofSubPatch, (std::array<int, 3>{4, 8, 4}));
}

// P' = H1 P H1ᵀ for the sub-patch, entry by entry, "the others by symmetry": each half of u and v
// has its own matrix, and its points are 4 × 4 of the 25. The nine inner points belong to all four.
// (In the notes, the last row of H1ᵀ is printed as 0 0 6 1; it is 0 0 0 1.)
TEST(Bicubic, SubPatchesAreProductsWithTheSplittingMatrices) {
    const RefinedGrid net({3, 3}, 1);
    const auto table = buildLevelTable(net.refiner(), 1);
    const Matrix4d halves[2] = {firstHalf(), secondHalf()};
    std::array<std::array<int, 5>, 5> uses = {};
    for (Index u = 0; u < 2; ++u)
        for (Index v = 0; v < 2; ++v)
            for (Index r = 0; r < 4; ++r)
                for (Index s = 0; s < 4; ++s) {
                    const Row expected =
                        tensorProduct(net, matrixRow(halves[u], r), matrixRow(halves[v], s));
                    const Row got = rowOf(table, net.vertexAt(1, {u + r, v + s, 0}));
                    // Multiples of 1/64 are exact.
                    EXPECT_EQ(difference(got, expected), 0) << u << v << r << s;
                    ++uses[u + r][v + s];
                }
    for (std::size_t r = 1; r <= 3; ++r)
        for (std::size_t s = 1; s <= 3; ++s) EXPECT_EQ(uses[r][s], 4);
}

/// The points of a net with the names of the notes, and the rules.
struct NetOfLevel {
    const RefinedGrid& grid;
    int level;

    Row p(Index i, Index j) const { return grid.at(level, {i, j, 0}); }
    Row f(Index i, Index j) const {
        return (p(i, j) + p(i + 1, j) + p(i, j + 1) + p(i + 1, j + 1)) / 4;
    }
    Row edgeAlongI(Index i, Index j) const {
        return (f(i, j - 1) + f(i, j) + p(i, j) + p(i + 1, j)) / 4;
    }
    Row edgeAlongJ(Index i, Index j) const {
        return (f(i - 1, j) + f(i, j) + p(i, j) + p(i, j + 1)) / 4;
    }
    Row q(Index i, Index j) const {
        return (f(i - 1, j - 1) + f(i - 1, j) + f(i, j - 1) + f(i, j)) / 4;
    }
    Row r(Index i, Index j) const {
        return ((p(i - 1, j) + p(i, j)) / 2 + (p(i, j - 1) + p(i, j)) / 2 +
                (p(i, j + 1) + p(i, j)) / 2 + (p(i + 1, j) + p(i, j)) / 2) /
               4;
    }
    Row vertex(Index i, Index j) const { return (q(i, j) + 2 * r(i, j) + p(i, j)) / 4; }
};

// The rules of the notes, and the patch-face, patch-edge and patch-vertex rules of CSE-96-1,
// section 3, for "arbitrary rectangular meshes", over several levels. All weights are dyadic, so
// they are exactly equal.
TEST(Bicubic, FaceEdgeAndVertexRulesOnNetsOfAnySize) {
    for (const std::vector<Index>& cells :
         std::vector<std::vector<Index>>{{3, 3}, {2, 5}, {6, 4}}) {
        const RefinedGrid grid(cells, 2);
        for (int level = 1; level <= 2; ++level) {
            const NetOfLevel net{grid, level - 1};
            const auto table = buildLevelTable(grid.refiner(), level);
            const Place size = grid.size(level);
            ASSERT_EQ(size[0], 2 * (grid.size(level - 1)[0] - 1));
            ASSERT_EQ(table.rowCount(), (size[0] + 1) * (size[1] + 1));
            for (Index r = 0; r <= size[0]; ++r)
                for (Index s = 0; s <= size[1]; ++s) {
                    const Index i = (r + 1) / 2, j = (s + 1) / 2;
                    const Row expected = r % 2 == 0
                                             ? s % 2 == 0 ? net.f(i, j) : net.edgeAlongI(i, j)
                                         : s % 2 == 0 ? net.edgeAlongJ(i, j)
                                                      : net.vertex(i, j);
                    const Row got = rowOf(table, grid.vertexAt(level, {r, s, 0}));
                    ASSERT_EQ(difference(got, expected), 0) << level << " " << r << " " << s;
                }
        }
    }
}

// Section 3.2.2, "the influence of the points on the vertex point": 1 for each face point, 2 for
// the midpoint of each edge and 4 for the vertex, in sixteenths. Over the old points this is the
// product of (1 6 1)/8 with itself: 1 6 1 / 6 36 6 / 1 6 1 in 64ths.
TEST(Bicubic, InfluenceOnAVertexPoint) {
    const RefinedGrid grid({2, 2}, 1);
    const NetOfLevel net{grid, 0};
    const auto m = [&](Index i, Index j) { return (net.p(i, j) + net.p(1, 1)) / 2; };
    const Row inSixteenths = (net.f(0, 0) + net.f(0, 1) + net.f(1, 0) + net.f(1, 1) + 2 * m(0, 1) +
                              2 * m(1, 0) + 2 * m(1, 2) + 2 * m(2, 1) + 4 * net.p(1, 1)) /
                             16;
    const double influence[3] = {1, 6, 1};
    Row in64ths;
    for (Index i = 0; i < 3; ++i)
        for (Index j = 0; j < 3; ++j)
            in64ths.weights[grid.vertexAt(0, {i, j, 0})] = influence[i] * influence[j] / 64;
    const auto table = buildLevelTable(grid.refiner(), 1);
    const Row got = rowOf(table, grid.vertexAt(1, {1, 1, 0}));
    EXPECT_EQ(difference(got, inSixteenths), 0);
    EXPECT_EQ(difference(got, in64ths), 0);
}

// Section 3: "utilize the univariate refinement to generate a refinement of all rows; take the
// resulting points and apply the univariate refinement to the columns".
TEST(Bicubic, NetsAreRefinedByRowsThenColumns) {
    const int levels = 3;
    const RefinedGrid net({4, 3}, levels), alongI({4}, levels), alongJ({3}, levels);
    for (int level = 1; level <= levels; ++level) {
        const auto table = buildStencils(net.refiner(), level);
        const auto rows = buildStencils(alongI.refiner(), level);
        const auto columns = buildStencils(alongJ.refiner(), level);
        for (const Place& place : net.places(level)) {
            const Row expected =
                tensorProduct(net, rowOf(rows, alongI.vertexAt(level, {place[0], 0, 0})),
                              rowOf(columns, alongJ.vertexAt(level, {place[1], 0, 0})));
            // Multiples of 64^-3 below 1 are exact.
            ASSERT_EQ(difference(rowOf(table, net.vertexAt(level, place)), expected), 0) << level;
        }
    }
}

// "If we keep refining, this limit mesh will converge to the original uniform B-spline surface":
// P(u, v) = [1 u u² u³] M P Mᵀ [1 v v² v³]ᵀ. In one direction, a point of the net after n levels
// differs from the curve by D/6 4^−n, where D is its second difference in the first net, with
// weights of at most 2 (see Curves.VertexPointsConvergeToTheSpline). So the difference is at most
// 4^−n/3, and in two directions at most twice that.
TEST(Bicubic, NetsConvergeToTheSurface) {
    const Matrix4d m = splineMatrix();
    const int levels = 5;
    const RefinedGrid net({3, 3}, levels);
    const auto along = [&](double t) {
        return Eigen::RowVector4d(Eigen::RowVector4d(1, t, t * t, t * t * t) * m);
    };
    for (int level = 1; level <= levels; ++level) {
        const auto table = buildStencils(net.refiner(), level);
        const double h = std::ldexp(1.0, -level);
        double largest = 0;
        for (const Place& place : net.places(level)) {
            const double u = h * (place[0] - 1), v = h * (place[1] - 1);
            if (u < 0 || u > 1 || v < 0 || v > 1) continue;
            Row onSurface;
            for (Index i = 0; i < 4; ++i)
                for (Index j = 0; j < 4; ++j)
                    onSurface.weights[net.vertexAt(0, {i, j, 0})] = along(u)[i] * along(v)[j];
            const Row got = rowOf(table, net.vertexAt(level, place));
            const double away = difference(got, onSurface);
            EXPECT_LE(away, 2 * h * h / 3) << level;
            largest = std::max(largest, away);
        }
        // The bound is of the right order: at a corner of the patch the weight of the corner's
        // vertex is (4/6 + e)² in place of (4/6)², with e = 4^−n/3.
        EXPECT_GE(largest, 4 * h * h / 9) << level;
    }
}

// The refined net defines the same surface: its points, weighted by (1 4 1)/6 in both directions,
// are on it.
TEST(Bicubic, RefinedNetsDefineTheSameSurface) {
    const int levels = 3;
    const RefinedGrid net({4, 3}, levels);
    const double weights[3] = {1. / 6, 4. / 6, 1. / 6};
    for (int level = 1; level <= levels; ++level) {
        const auto table = buildStencils(net.refiner(), level);
        for (const Place& place : net.places(level)) {
            const Place size = net.size(level);
            if (place[0] % size[0] == 0 || place[1] % size[1] == 0) continue;
            Row onSurface;
            for (Index i = -1; i <= 1; ++i)
                for (Index j = -1; j <= 1; ++j)
                    onSurface =
                        onSurface +
                        weights[i + 1] * weights[j + 1] *
                            rowOf(table, net.vertexAt(level, {place[0] + i, place[1] + j, 0}));
            const Row expected =
                tensorProduct(net, splineAt(1 + std::ldexp(place[0] - 1, -level), 4),
                              splineAt(1 + std::ldexp(place[1] - 1, -level), 3));
            // Nine products below 1, of exact rows.
            ASSERT_LE(difference(onSurface, expected), 2e-15) << level;
        }
    }
}

}  // namespace
}  // namespace espalier::stencils
