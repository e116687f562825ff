// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/pose.h>
#include <espalier/solve/design_variables.h>
#include <espalier/solve/section_variables.h>

#include <cmath>
#include <complex>

#include "solve/section_formula.h"
#include "support/test.h"

namespace espalier::solve {
namespace {

/// A wing of 2 × 1 × 4 cells along z, with sections at 0, 2 and 4.
const Lattice& wing() {
    static const Lattice lattice =
        shapes::box({.cells = {2, 1, 4}, .min = {-1, -0.1, 0}, .max = {1, 0.1, 4}});
    return lattice;
}
const SectionOptions kThreeSections = {.stations = {0, 2, 4}};

/// Values with different twists, scales and translations in all sections.
std::vector<double> someValues() {
    return {0.3, 1.2, 0.1, -0.2, 0, -0.5, 0.8, 0, 0.3, 0.1, 1.1, 1, -0.2, 0.1, 0.4};
}

void expectNear(const std::vector<Point3>& points, const std::vector<Point3>& expected) {
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(points[i][c], expected[i][c], 1e-14);
}

TEST(SectionVariables, AtRestNothingMoves) {
    const SectionVariables sections(wing().positions, kThreeSections);
    EXPECT_EQ(sections.count(), 15);
    expectNear(sections.positions(sections.atRest()), wing().positions);
}

// One value for all sections is an operation of pose.h.
TEST(SectionVariables, EqualSectionsAreOneOperation) {
    const auto& rest = wing().positions;
    const SectionVariables sections(rest, kThreeSections);
    const shapes::pose::Options origin{.center = Point3{0, 0, 0}};
    const auto all = [&](const std::vector<double>& one) {
        std::vector<double> values;
        for (int i = 0; i < 3; ++i) values.insert(values.end(), one.begin(), one.end());
        return sections.positions(values);
    };
    expectNear(all({0.7, 1, 0, 0, 0}), shapes::pose::rotate(rest, {0, 0, 1}, 0.7, origin));
    expectNear(all({0, 1.5, 0, 0, 0}), shapes::pose::scale(rest, {1.5, 1, 1}, origin));
    expectNear(all({0, 1, 1, 2, 3}), shapes::pose::move(rest, {1, 2, 3}));
    // A twist that is linear along the axis is the operation `twist`.
    expectNear(
        sections.positions(std::vector<double>{0, 1, 0, 0, 0, 0.5, 1, 0, 0, 0, 1, 1, 0, 0, 0}),
        shapes::pose::twist(rest, {0, 0, 1}, 1, origin));
}

// Each section moves as a rigid body but for its scale: distances within it are kept, and a scale
// of the chord by 1.2 in one section changes no other section.
TEST(SectionVariables, SectionsAreIndependentAndRigid) {
    const auto& rest = wing().positions;
    const SectionVariables sections(rest, kThreeSections);
    auto values = someValues();
    for (const std::size_t section : {0u, 1u, 2u}) values[5 * section + 1] = 1;
    const auto posed = sections.positions(values);
    for (std::size_t a = 0; a < rest.size(); ++a)
        for (std::size_t b = 0; b < rest.size(); ++b) {
            if (rest[a][2] != rest[b][2]) continue;
            const auto distance = [](const Point3& p, const Point3& q) {
                return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
            };
            EXPECT_NEAR(distance(posed[a], posed[b]), distance(rest[a], rest[b]), 1e-14);
        }
    values[6] = 1.2;
    const auto scaled = sections.positions(values);
    for (std::size_t v = 0; v < rest.size(); ++v) {
        if (rest[v][2] == 0 || rest[v][2] == 4) {
            EXPECT_TRUE(scaled[v] == posed[v]);
        }
    }
}

// The derivatives by the complex step: f(x + ih) = f(x) + ih f'(x) + O(h²), without cancellation.
TEST(SectionVariables, DerivativesAreThoseOfTheComplexStep) {
    using Complex = std::complex<double>;
    const SectionFrame frame{{0.6, 0.8, 0}, {-0.8, 0.6, 0}};
    const Point3 foot = {0.1, 0.2, 0.3};
    const double a = 0.7, b = -0.4, h = 1e-200;
    const SectionValues<double> values = {0.9, 1.3, 0.1, 0.2, 0.3};
    const auto derivatives = sectionDerivatives(frame, a, b, values);
    for (std::size_t k = 0; k < 5; ++k) {
        SectionValues<Complex> step;
        for (std::size_t i = 0; i < 5; ++i) step[i] = {values[i], i == k ? h : 0};
        const auto moved = sectionPosition(frame, foot, a, b, step);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(derivatives[k][c], moved[c].imag() / h, 1e-15);
    }
}

// The columns against central differences of positions(), whose error is O(h²) + rounding / h.
TEST(SectionVariables, MatrixIsTheDerivativeOfPositions) {
    const SectionVariables sections(wing().positions, {.axis = {0.1, 0.2, 2},
                                                       .chord = {1, 1, 0},
                                                       .center = {0.2, 0, 0},
                                                       .stations = {0.5, 1, 3}});
    const auto values = someValues();
    const auto matrix = sections.matrix(values);
    ASSERT_EQ(matrix.rowCount(), 3 * std::ssize(wing().positions));
    ASSERT_EQ(matrix.columnCount(), 15);
    constexpr double h = 1e-5;
    for (Index variable = 0; variable < 15; ++variable) {
        auto low = values, high = values;
        low[variable] -= h;
        high[variable] += h;
        const auto from = sections.positions(low), to = sections.positions(high);
        for (Index row = 0; row < matrix.rowCount(); ++row) {
            double derivative = 0;
            for (std::size_t k = 0; k < matrix.columns(row).size(); ++k)
                if (matrix.columns(row)[k] == variable) derivative += matrix.weights(row)[k];
            const std::size_t v = row / 3, c = row % 3;
            EXPECT_NEAR(derivative, (to[v][c] - from[v][c]) / (2 * h), 1e-9);
        }
    }
}

// The Jacobian of the points is D times the matrix.
TEST(SectionVariables, JacobianMovesThePointsOfAModel) {
    const SectionVariables sections(wing().positions, kThreeSections);
    const std::vector<Point3> points = {{0.2, 0.05, 1.3}, {-0.7, -0.02, 3.1}};
    const far::TopologyRefiner base(wing().complex);
    const auto binding = embed::bindPoints({base, wing().positions}, points, {.level = 2});
    const auto jacobian = buildJacobian(binding.table, sections.matrix(sections.atRest()));
    constexpr double h = 1e-6;
    auto values = sections.atRest();
    values[5] += h;  // the twist of the second section
    const auto pose = sections.positions(values);
    for (Index row = 0; row < jacobian.rowCount(); ++row) {
        double derivative = 0;
        for (std::size_t k = 0; k < jacobian.columns(row).size(); ++k)
            if (jacobian.columns(row)[k] == 5) derivative += jacobian.weights(row)[k];
        double moved = -points[row / 3][row % 3];  // D · p' − x
        for (std::size_t k = 0; k < binding.table.columns(row / 3).size(); ++k)
            moved += binding.table.weights(row / 3)[k] *
                     pose[binding.table.columns(row / 3)[k]][row % 3];
        EXPECT_NEAR(derivative, moved / h, 1e-6);
    }
}

TEST(SectionVariables, RefuseOptionsAndValuesOutOfRange) {
    const auto& rest = wing().positions;
    const auto refusal = [&](const SectionOptions& options) {
        return test::messageOf<Error>([&] { SectionVariables(rest, options); });
    };
    EXPECT_THAT(refusal({}), testing::HasSubstr("stations: expected one or more, got none"));
    EXPECT_THAT(
        refusal({.stations = {1, 1}}),
        testing::HasSubstr("stations[1]: expected finite numbers in ascending order, got 1"));
    EXPECT_THAT(
        refusal({.stations = {kNan}}),
        testing::HasSubstr("stations[0]: expected finite numbers in ascending order, got nan"));
    EXPECT_THAT(refusal({.axis = {0, 0, 0}, .stations = {1}}),
                testing::HasSubstr("axis: expected a vector other than 0, got (0, 0, 0)"));
    EXPECT_THAT(refusal({.chord = {0, 0, 2}, .stations = {1}}),
                testing::HasSubstr(
                    "chord: expected a vector other than 0 that is not parallel to the axis, got"));
    EXPECT_THAT(refusal({.center = {kInfinity, 0, 0}, .stations = {1}}),
                testing::HasSubstr("center: expected finite numbers, got (inf, 0, 0)"));
    const SectionVariables sections(rest, kThreeSections);
    EXPECT_REFUSED(Error, "there are 3 values; expected 15",
                   sections.positions(std::vector<double>(3)));
    EXPECT_REFUSED(Error, "values[0] is nan; expected a finite number",
                   sections.matrix(std::vector<double>(15, kNan)));
}

}  // namespace
}  // namespace espalier::solve
