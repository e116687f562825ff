// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/design_variables.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Core>
#include <complex>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::stencils {
namespace {

/// Returns a matrix times a vector of real or complex numbers.
template <class Number>
std::vector<Number> times(const StencilTable<double>& table, const std::vector<Number>& values) {
    std::vector<Number> result(table.rowCount(), Number{0});
    for (Index row = 0; row < table.rowCount(); ++row)
        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
            result[row] += table.weights(row)[k] * values[table.columns(row)[k]];
    return result;
}

TEST(DesignVariables, AreInitiallyAllCoordinates) {
    const auto matrix = solve::DesignVariables(2).matrix();
    EXPECT_EQ(matrix, StencilTable<double>(6, {0, 1, 2, 3, 4, 5, 6}, {0, 1, 2, 3, 4, 5},
                                           {1, 1, 1, 1, 1, 1}));
}

TEST(DesignVariables, FrozenCoordinatesHaveNoVariable) {
    solve::DesignVariables design(2);
    design.freeze(0);
    design.freeze(1, 1);
    EXPECT_EQ(design.matrix(), StencilTable<double>(2, {0, 0, 0, 0, 1, 1, 2}, {0, 1}, {1, 1}));
}

// x₁ = 2 x₀ and x₂ = 3 x₁ give x₂ = 6 x₀: one variable, whatever the order of the links.
TEST(DesignVariables, LinksMultiplyFactors) {
    for (const bool isReversed : {false, true}) {
        solve::DesignVariables design(3);
        if (!isReversed) design.link(1, 0, {2, 2, 2});
        design.link(2, 1, {3, 3, 3});
        if (isReversed) design.link(1, 0, {2, 2, 2});
        EXPECT_EQ(design.matrix(),
                  StencilTable<double>(3, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9},
                                       {0, 1, 2, 0, 1, 2, 0, 1, 2}, {1, 1, 1, 2, 2, 2, 6, 6, 6}));
        // Freezing one of them freezes all.
        design.freeze(1);
        EXPECT_EQ(design.matrix().entryCount(), 0);
    }
}

// With x₁ = 2 x₀, a variable that moves x₁ by 6 moves x₀ by 3.
TEST(DesignVariables, AreScaled) {
    solve::DesignVariables design(2);
    design.link(1, 0, {2, 2, 2});
    design.scale(0, 0.5);
    design.scale(1, 1, 6);
    EXPECT_EQ(design.matrix(), StencilTable<double>(3, {0, 1, 2, 3, 4, 5, 6}, {0, 1, 2, 0, 1, 2},
                                                    {0.5, 3, 0.5, 1, 6, 1}));
    for (const double unit : {0.0, kInfinity})
        EXPECT_REFUSED(Error, "unit: expected a finite number other than 0, got ",
                       design.scale(1, unit));
    EXPECT_REFUSED(Error, "no vertex 2", design.scale(2, 1));
}

TEST(DesignVariables, ContradictingLinksFreeze) {
    solve::DesignVariables design(2);
    design.link(0, 1);
    design.link(1, 0, {1, -1, 1});
    EXPECT_EQ(design.matrix(),
              StencilTable<double>(2, {0, 1, 1, 2, 3, 3, 4}, {0, 1, 0, 1}, {1, 1, 1, 1}));
}

// Each factor is valid but their product overflows, in either order.
TEST(DesignVariables, RefusesLinksWhoseProductsOverflow) {
    for (const double factor : {1e-200, 1e200}) {
        solve::DesignVariables design(3);
        design.link(1, 0, {factor, 1, 1});
        EXPECT_REFUSED(Error, "vertices 2 and 1 cannot be linked",
                       design.link(2, 1, {factor, 1, 1}));
        EXPECT_EQ(design.matrix().columnCount(), 6) << "nothing more is linked";
    }
}

// Long chains of links lead to one variable, whichever end they are made from.
TEST(DesignVariables, LongChainsBecomeOneVariable) {
    constexpr Index kCount = 20'000;
    for (const bool isDescending : {false, true}) {
        solve::DesignVariables design(kCount);
        for (Index i = 0; i + 1 < kCount; ++i) {
            const Index v = isDescending ? kCount - 2 - i : i;
            design.link(v, v + 1);
        }
        EXPECT_EQ(design.matrix().columnCount(), 3);
    }
}

// 0.7 · (1 / 0.7) is not 1 in double precision, but this is no contradiction.
TEST(DesignVariables, LinksMayDifferByRounding) {
    for (const double factor : {0.7, 1.0 / 3, 49.0, 1e-3}) {
        solve::DesignVariables design(2);
        design.link(0, 1, {factor, factor, factor});
        design.link(1, 0, {1 / factor, 1 / factor, 1 / factor});
        EXPECT_EQ(design.matrix().columnCount(), 3) << factor;
    }
}

// Opposite corners of a box mirror each other across x = 1/2; vertices on the plane stay on it.
TEST(DesignVariables, MirroredVerticesMoveAsImages) {
    const Lattice box = shapes::box({.cells = {2, 1, 1}});
    solve::DesignVariables design(Index(box.positions.size()));
    design.mirror(box.positions, 0, 0.5, 1e-12);
    const auto matrix = design.matrix();
    // Four vertices on one side have three variables each, four on the plane have two.
    EXPECT_EQ(matrix.columnCount(), 4 * 3 + 4 * 2);
    std::vector<double> variables(matrix.columnCount());
    const auto random = randomValues(variables.size(), 3);
    std::copy(random.begin(), random.end(), variables.begin());
    const auto moved = times(matrix, variables);
    for (std::size_t v = 0; v < box.positions.size(); ++v)
        for (std::size_t w = 0; w < box.positions.size(); ++w) {
            const Point3 &p = box.positions[v], &q = box.positions[w];
            if (p[0] + q[0] != 1 || p[1] != q[1] || p[2] != q[2]) continue;
            EXPECT_EQ(moved[3 * v], -moved[3 * w]);
            EXPECT_EQ(moved[3 * v + 1], moved[3 * w + 1]);
            EXPECT_EQ(moved[3 * v + 2], moved[3 * w + 2]);
        }
}

TEST(DesignVariables, RefusesUnknownVerticesAndAxes) {
    solve::DesignVariables design(2);
    EXPECT_REFUSED(Error, "there is no vertex 2; the lattice has 2", design.freeze(2));
    EXPECT_REFUSED(Error, "axis: expected 0 to 2, got 3", design.freeze(0, 3));
    EXPECT_REFUSED(Error, "no vertex -1", design.link(0, -1));
    for (const double factor : {0.0, kNan})
        EXPECT_REFUSED(Error, "factors: expected a finite number other than 0, got ",
                       design.link(0, 1, {1, factor, 1}));
    const std::vector<Point3> apart = {{0, 0, 0}, {2, 0, 0}};
    EXPECT_REFUSED(Error, "vertex 0 has no mirror image within 0.1",
                   design.mirror(apart, 0, 0.5, 0.1));
    EXPECT_REFUSED(Error, "vertex 0 has several mirror images within 5",
                   design.mirror(apart, 0, 1, 5));
    EXPECT_EQ(design.matrix().columnCount(), 6) << "nothing is linked";
    const std::vector<Point3> nowhere = {{0, 0, 0}, {kNan, 0, 0}};
    EXPECT_REFUSED(Error, "positions[1] is (nan, 0, 0)", design.mirror(nowhere, 0, 0.5, 0.1));
    EXPECT_REFUSED(Error, "positions", design.mirror({}, 0, 1, 5));
    EXPECT_MESSAGE("at: expected a finite number, got nan", design.mirror(apart, 0, kNan, 5));
    for (const double tolerance : {-1.0, kInfinity})
        EXPECT_REFUSED(Error, "tolerance: expected a finite number of 0 or more, got ",
                       design.mirror(apart, 0, 1, tolerance));
    EXPECT_REFUSED(Error, "of 6 coordinates; expected three for each of 3",
                   solve::buildJacobian(StencilTable<double>(3, {0}, {}, {}), design.matrix()));
}

/// A model in a cylinder, and a design with some vertices linked and some frozen.
struct Designed {
    Lattice lattice = shapes::cylinder({.sectors = 5});
    StencilTable<double> deformation;
    StencilTable<double> design;

    Designed() {
        const Refined refined(lattice, 2);
        deformation = embed::bindPoints({TopologyRefiner(lattice.complex), lattice.positions},
                                        pointsIn(refined, 200, 4), {.level = 2})
                          .table;
        solve::DesignVariables variables(lattice.complex.count(0));
        variables.link(3, 1, {0.5, -1, 2});
        variables.freeze(2);
        variables.freeze(5, 1);
        design = variables.matrix();
    }

    /// Returns the coordinates of the points for given variables, in two steps: first the lattice,
    /// then the model.
    template <class Number>
    std::vector<Number> points(const std::vector<Number>& variables) const {
        const std::vector<Number> moved = times(design, variables);
        std::vector<Number> result(3 * std::size_t(deformation.rowCount()));
        for (std::size_t c = 0; c < 3; ++c) {
            std::vector<Number> coordinates;
            for (std::size_t v = 0; v < lattice.positions.size(); ++v)
                coordinates.push_back(lattice.positions[v][c] + moved[3 * v + c]);
            const auto values = times(deformation, coordinates);
            for (std::size_t i = 0; i < values.size(); ++i) result[3 * i + c] = values[i];
        }
        return result;
    }
};

// A complex step has no cancellation: the derivative is exact to rounding. A finite difference
// loses half of the step's digits, but the points are linear in the variables, so the step may be
// 1.
TEST(Jacobian, IsTheDerivativeByDifferencesAndByAComplexStep) {
    const Designed model;
    const auto jacobian = solve::buildJacobian(model.deformation, model.design);
    ASSERT_EQ(jacobian.rowCount(), 3 * model.deformation.rowCount());
    ASSERT_EQ(jacobian.columnCount(), model.design.columnCount());
    const auto count = std::size_t(jacobian.columnCount());
    const auto rest = model.points(std::vector<double>(count, 0));
    constexpr double kStep = 1e-200;
    for (std::size_t variable = 0; variable < count; ++variable) {
        std::vector<double> unit(count, 0);
        unit[variable] = 1;
        std::vector<std::complex<double>> step(count, 0);
        step[variable] = {0, kStep};
        const auto column = times(jacobian, unit);
        const auto moved = model.points(unit);
        const auto complex = model.points(step);
        for (std::size_t i = 0; i < column.size(); ++i) {
            ASSERT_NEAR(column[i], moved[i] - rest[i], 1e-14);
            ASSERT_NEAR(column[i], complex[i].imag() / kStep, 1e-15);
        }
    }
}

// ⟨J v, g⟩ = ⟨v, Jᵀ g⟩.
TEST(Jacobian, TransposeCarriesGradientsBack) {
    const Designed model;
    const auto jacobian = solve::buildJacobian(model.deformation, model.design);
    const auto v = randomValues(jacobian.columnCount(), 1);
    const auto g = randomValues(jacobian.rowCount(), 2);
    const auto forward = times<double>(jacobian, {v.begin(), v.end()});
    const auto back = times<double>(transposeTable(jacobian), {g.begin(), g.end()});
    double left = 0, right = 0;
    for (std::size_t i = 0; i < g.size(); ++i) left += forward[i] * g[i];
    for (std::size_t i = 0; i < v.size(); ++i) right += back[i] * v[i];
    // Sums of 600 products of size 1.
    EXPECT_NEAR(left, right, 600 * std::numeric_limits<double>::epsilon());
}

}  // namespace
}  // namespace espalier::stencils
