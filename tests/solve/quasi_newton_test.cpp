// SPDX-License-Identifier: Apache-2.0
#include "solve/quasi_newton.h"

#include "support/test.h"

namespace espalier::solve {
namespace {

using Columns = Eigen::MatrixX3d;

Columns sameOf(const Columns& gradient) {
    return gradient;
}

// The valley of Rosenbrock, in the first two coordinates, and a parabola in the third.
double valley(const Columns& x, Columns& gradient) {
    const double a = 1 - x(0, 0), b = x(0, 1) - x(0, 0) * x(0, 0), c = x(0, 2) - 3;
    gradient << -2 * a - 400 * x(0, 0) * b, 200 * b, 2 * c;
    return a * a + 100 * b * b + c * c;
}

TEST(QuasiNewton, FindsTheMinimumOfAValley) {
    Columns x(1, 3);
    x << -1.2, 1, 0;
    const int iterations = minimise(x, valley, sameOf, {1e-12, 10, 200});
    EXPECT_LT(iterations, 100);
    EXPECT_LT((x - Eigen::RowVector3d(1, 1, 3)).norm(), 1e-8);
    x << -1.2, 1, 0;
    EXPECT_EQ(minimise(x, valley, sameOf, {1e-12, 10, 4}), 4);
}

TEST(QuasiNewton, LimitsTheStep) {
    Columns x(1, 3);
    x << -1.2, 1, 0;
    Columns before = x;
    for (int i = 0; i < 20; ++i, before = x) {
        EXPECT_EQ(minimise(x, valley, sameOf, {1e-12, 0.01, 1}), 1);
        EXPECT_LT((x - before).norm(), 0.01 * (1 + 1e-12));
    }
}

// With the Hessian itself as the model, one step finds the minimum of a parabola.
TEST(QuasiNewton, UsesTheModelOfTheHessian) {
    const Eigen::RowVector3d scales(1, 100, 1e4), minimum(1, 2, 3);
    const auto value = [&](const Columns& x, Columns& gradient) {
        gradient = ((x.row(0) - minimum).array() * scales.array()).matrix();
        return 0.5 * gradient.row(0).dot(x.row(0) - minimum);
    };
    const auto inverse = [&](const Columns& g) {
        return Columns((g.row(0).array() / scales.array()).matrix());
    };
    Columns x = Columns::Zero(1, 3);
    EXPECT_EQ(minimise(x, value, inverse, {0, 10, 1}), 1);
    EXPECT_LT((x.row(0) - minimum).norm(), 1e-12);
}

// (x + 5)² has its minimum behind the wall of 1/x, which is infinite at x ≤ 0.
TEST(QuasiNewton, StaysBeforeAWall) {
    const auto value = [](const Columns& x, Columns& gradient) {
        const double t = x(0, 0);
        if (!(t > 0)) return kInfinity;
        gradient << 2 * (t + 5) - 1 / (t * t), 2 * x(0, 1), 2 * x(0, 2);
        return (t + 5) * (t + 5) + 1 / t + x(0, 1) * x(0, 1) + x(0, 2) * x(0, 2);
    };
    Columns x(1, 3);
    x << 10, 4, -3;
    minimise(x, value, sameOf, {1e-12, 10, 200});
    EXPECT_NEAR(2 * (x(0, 0) + 5) * x(0, 0) * x(0, 0), 1, 1e-9);
    EXPECT_NEAR(x(0, 1), 0, 1e-9);
}

}  // namespace
}  // namespace espalier::solve
