// SPDX-License-Identifier: Apache-2.0
#include <espalier/bind/bind.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <Eigen/LU>
#include <limits>
#include <random>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

// Tests the deformation gradients of bindings to every target.
namespace espalier::bind {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const BindOptions kCarried = {.embedding = {.outside = embed::OutsidePolicy::Nearest},
                              .gradients = true};

Matrix3d matrixOf(const DeformationGradient& f) {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(f.data());
}

/// Returns points in and around a lattice.
std::vector<Point3> scattered(const Lattice& lattice, std::size_t count, double beyond) {
    Point3 low = lattice.positions[0], high = low;
    for (const Point3& p : lattice.positions)
        for (std::size_t c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], p[c]);
            high[c] = std::max(high[c], p[c]);
        }
    std::mt19937 random(5);
    std::uniform_real_distribution<double> along(-beyond, 1 + beyond);
    std::vector<Point3> points(count);
    for (Point3& p : points)
        for (std::size_t c = 0; c < 3; ++c) p[c] = low[c] + along(random) * (high[c] - low[c]);
    return points;
}

Binding withGradients(const Lattice& lattice, std::span<const Point3> points, const Target& target,
                      const BindOptions& options = kCarried) {
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    return bindPoints({base, lattice.positions}, points, target, options);
}

Lattice evenBox() {
    return shapes::box({.cells = {4, 5, 4}, .max = {2, 3, 2}});
}

struct Case {
    std::string name;
    Lattice lattice;
    Target target;
    double beyond = 0.1;  ///< how far points are outside the lattice, in its size
};

/// The zoo in some levels and in the limit; a box in deep levels and under each basis.
std::vector<Case> cases() {
    std::vector<Case> result;
    for (const auto& [name, lattice] : test::zoo()) {
        for (const int level : {1, 3})
            result.push_back({name + " level " + std::to_string(level), lattice, Level{level}});
        result.push_back({name + " limit", lattice, Limit{}});
    }
    for (const int level : {8, 12})
        result.push_back({"box level " + std::to_string(level), evenBox(), Level{level}, -0.26});
    result.push_back({"cylinder level 8", shapes::cylinder({.sectors = 5}), Level{8}});
    for (const embed::Basis basis : {embed::Basis::Bezier, embed::Basis::BSpline})
        result.push_back({"box basis", evenBox(), basis});
    return result;
}

// In an affine pose F is the matrix of the pose at each point that the lattice moves, and the
// identity at all others. At rest, and after a translation, F is the identity to the last bit of
// the sums: no term of them is more than the rounding of the translation.
TEST(Gradients, AffinePosesAreExactForEachTarget) {
    Matrix3d map;
    map << 1.2, 0.3, -0.1, 0.2, 0.8, 0.4, -0.3, 0.1, 1.1;
    for (const auto& [name, lattice, target, beyond] : cases()) {
        const auto points = scattered(lattice, 60, 0.1);
        const Binding binding = withGradients(lattice, points, target);
        auto pose = lattice.positions;
        for (Point3& p : pose) p = test::toPoint(map * test::vec(p) + Vector3d(0.3, -0.7, 0.2));
        const auto gradients = osd::evaluateGradients(binding, pose);
        const DeformationGradient identity = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        EXPECT_EQ(osd::evaluateGradients(binding, lattice.positions),
                  std::vector(points.size(), identity))
            << name;
        const auto tables = gradientTables(binding);
        int moved = 0;
        EXPECT_EQ(binding.gradients->identityCount(Index(points.size())),
                  std::ssize(tables[0].emptyRows()))
            << name;
        for (std::size_t i = 0; i < points.size(); ++i) {
            // A row is also empty where the lattice at rest has no volume.
            const bool isMoved = !tables[0].columns(Index(i)).empty();
            moved += isMoved;
            const Matrix3d expected = isMoved ? map : Matrix3d(Matrix3d::Identity());
            // 1e-12 as documented.
            EXPECT_LT((matrixOf(gradients[i]) - expected).norm(), 1e-12) << name << ' ' << i;
            if (binding.table.columns(Index(i)).empty()) {
                EXPECT_EQ(gradients[i], identity) << name << ' ' << i;
            }
        }
        EXPECT_GE(moved, 15) << name;
    }
}

// The size of the lattice and its distance from the origin do not matter: 2^±600 is about 1e±181.
TEST(Gradients, DoNotDependOnTheUnit) {
    const auto points = scattered(evenBox(), 50, 0.1);
    for (const Target& target : {Target(Level{2}), Target(Limit{}), Target(embed::Basis::Bezier)}) {
        const auto gradientsAt = [&](int exponent) {
            const auto scaled = [&](std::vector<Point3> positions) {
                for (Point3& p : positions)
                    for (double& coordinate : p) coordinate = std::ldexp(coordinate, exponent);
                return positions;
            };
            Lattice lattice = evenBox();
            const auto pose = scaled(test::bent(lattice));
            lattice.positions = scaled(lattice.positions);
            return osd::evaluateGradients(withGradients(lattice, scaled(points), target), pose);
        };
        const auto expected = gradientsAt(0);
        for (const int exponent : {-600, 600}) {
            const auto gradients = gradientsAt(exponent);
            for (std::size_t i = 0; i < points.size(); ++i)
                // The rounding of 64 products of weights up to 10 and positions up to 3.
                EXPECT_LT((matrixOf(gradients[i]) - matrixOf(expected[i])).norm(), 1e-12) << i;
        }
    }
}

// The reference refines the whole level, and takes F as the product of two Jacobians: the one of
// the posed cell, and the inverse of the one of the cell at rest.
TEST(Gradients, EqualTheJacobiansOfTheCellsOfALevel) {
    constexpr int kLevel = 2;
    for (const auto& [name, lattice] : test::zoo()) {
        const auto points = scattered(lattice, 200, 0);
        const Binding binding = withGradients(lattice, points, Level{kLevel});
        const auto pose = test::bent(lattice);
        const auto gradients = osd::evaluateGradients(binding, pose);

        TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
        refiner.refineUniform(kLevel);
        const CellComplex& complex = refiner.level(kLevel).complex;
        const auto rest = stencils::refinePositions(refiner, kLevel, lattice.positions);
        const auto posed = stencils::refinePositions(refiner, kLevel, pose);
        const auto embedding = embed::embedPoints(complex, rest, points);
        int count = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto& place = embedding.points[i].place;
            if (!place || binding.table.columns(Index(i)).empty()) continue;
            const auto jacobian = [&](const std::vector<Point3>& positions) {
                const auto at = [&](Index vertex) { return test::vec(positions[vertex]); };
                Matrix3d result;
                if (const auto corners = far::hexahedronVertices(complex, place->cell)) {
                    embed::Trilinear::Corners ends;
                    for (std::size_t k = 0; k < 8; ++k) ends[k] = at((*corners)[k]);
                    return embed::Trilinear(ends).jacobian(Vector3d(place->uvw.data()));
                }
                Vector3d middle = Vector3d::Zero();
                const auto vertices = complex.relation(3, 0)[place->cell.value];
                for (const Index vertex : vertices) middle += at(vertex) / double(vertices.size());
                const auto base = embed::tetrahedronBase(complex, place->cell, place->tetrahedron);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    result.col(Eigen::Index(axis)) = at(base[axis]) - middle;
                return result;
            };
            const Matrix3d atRest = jacobian(rest);
            const Matrix3d expected = jacobian(posed) * atRest.inverse();
            // Both places are rounded to 1e-12 of the lattice, and F changes by the curvature of
            // the pose within the cell, about 10 for a unit of length, times the thinness of it.
            EXPECT_LT((matrixOf(gradients[i]) - expected).norm(), 1e-9 * (1 + expected.norm()))
                << name << ' ' << i;
            ++count;
        }
        EXPECT_GE(count, 30) << name;
    }
}

// F is the derivative of the deformation, by central differences of bound points.
TEST(Gradients, AreTheDerivativeOfTheDeformation) {
    constexpr double kStep = 1e-6;
    for (const Target& target : {Target(Level{3}), Target(Limit{}), Target(embed::Basis::Bezier),
                                 Target(embed::Basis::BSpline)}) {
        const Lattice lattice = evenBox();
        std::vector<Point3> points;
        for (const Point3& centre : scattered(lattice, 40, -0.3))
            for (int k = 0; k < 7; ++k) {
                points.push_back(centre);
                if (k > 0) points.back()[std::size_t(k - 1) / 2] += k % 2 == 0 ? kStep : -kStep;
            }
        const Binding binding = withGradients(lattice, points, target);
        const auto pose = test::bent(lattice);
        const auto moved = osd::evaluateBinding(binding, pose);
        const auto gradients = osd::evaluateGradients(binding, pose);
        for (std::size_t i = 0; i < points.size(); i += 7)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::size_t k = i + 1 + 2 * axis;
                const Vector3d difference =
                    (test::vec(moved[k + 1]) - test::vec(moved[k])) / (2 * kStep);
                // The rounding of the points, 1e-15, divided by the step.
                EXPECT_LT((matrixOf(gradients[i]).col(Eigen::Index(axis)) - difference).norm(),
                          1e-8);
            }
    }
}

// Points that share regular cells of levels have places in patches; each point alone has rows.
TEST(Gradients, PatchesOfLevelsEqualRows) {
    const Lattice lattice = shapes::cylinder({.sectors = 5, .layers = 2});  // no cell is regular
    const auto points = scattered(lattice, 4000, 0);
    BindOptions options = kCarried;
    for (std::size_t i = 0; i < points.size(); ++i)
        options.weights.values.push_back(i % 3 == 0 ? 0 : i % 3 == 1 ? 0.5 : 1);
    const Binding binding = withGradients(lattice, points, Limit{}, options);
    EXPECT_GE(binding.gradients->splines.places.size(), 1000u);
    EXPECT_FALSE(binding.gradients->points.empty());
    const auto pose = test::bent(lattice);
    const auto gradients = osd::evaluateGradients(binding, pose);
    for (std::size_t i = 0; i < points.size(); i += 101) {
        options.weights.values = {binding.weights[i].value};
        const Binding alone = withGradients(lattice, {&points[i], 1}, Limit{}, options);
        EXPECT_TRUE(alone.gradients->splines.places.empty());
        // Both places are rounded to 1e-12 of the lattice, and F changes by about 10 for a unit of
        // length.
        EXPECT_LT(
            (matrixOf(gradients[i]) - matrixOf(osd::evaluateGradients(alone, pose)[0])).norm(),
            1e-10)
            << i;
    }
}

// The tables for solvers hold the same gradients as the formula in regular cells.
TEST(Gradients, TablesEqualTheFormula) {
    const Lattice prism = shapes::cylinder({.sectors = 5});
    for (const auto& [lattice, target, count] :
         {std::tuple(prism, Target(Level{2}), 4000),
          std::tuple(evenBox(), Target(embed::Basis::Bezier), 300),
          std::tuple(evenBox(), Target(Level{2}), 300), std::tuple(evenBox(), Target(Limit{}), 300),
          std::tuple(prism, Target(Limit{}), 4000)}) {
        const auto points = scattered(lattice, std::size_t(count), 0.1);
        const Binding binding = withGradients(lattice, points, target);
        const embed::Gradients& gradients = *binding.gradients;
        // Most points have a place of some kind.
        EXPECT_GE(gradients.splines.places.size() + gradients.cells.places.size() +
                      gradients.basis.places.size(),
                  100u);
        const auto pose = test::bent(lattice);
        const auto tables = gradientTables(binding);
        const auto expected = osd::evaluateGradients(binding, pose);
        std::array<std::vector<Point3>, 3> columns;
        for (std::size_t axis = 0; axis < 3; ++axis)
            columns[axis] = stencils::applyLevelTable(tables[axis], pose);
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (std::size_t c = 0; c < 3; ++c)
                    if (!tables[0].columns(Index(i)).empty()) {
                        // The rounding of 64 products of weights up to 10 and positions up to 3.
                        EXPECT_NEAR(columns[axis][i][c], expected[i][3 * c + axis], 1e-12);
                    }
    }
}

// Gradients change neither D nor the statuses of a level, and no number of threads changes them.
TEST(Gradients, ChangeNothingElse) {
    for (const auto& [name, lattice] : test::zoo()) {
        const auto points = scattered(lattice, 40, 0.2);
        BindOptions without = kCarried;
        without.gradients = false;
        Binding binding = withGradients(lattice, points, Level{2});
        EXPECT_TRUE(test::withThreads(
                        5, [&] { return withGradients(lattice, points, Level{2}); }) == binding)
            << name;
        binding.gradients.reset();
        EXPECT_TRUE(binding == withGradients(lattice, points, Level{2}, without)) << name;
    }
}

TEST(Gradients, OnlyOnRequest) {
    const Lattice lattice = evenBox();
    const auto points = scattered(lattice, 10, 0);
    for (const Target& target : {Target(Level{2}), Target(Limit{}), Target(embed::Basis::Bezier)})
        EXPECT_REFUSED(
            Error, "the binding has no gradients",
            osd::evaluateGradients(withGradients(lattice, points, target, {}), lattice.positions));
}

TEST(Gradients, ThatDoNotFitAreRefused) {
    const Lattice lattice = evenBox();
    const Binding binding = withGradients(lattice, scattered(lattice, 10, -0.1), Level{2});
    binding.checkParts();
    const auto refuse = [&](const std::string& message, auto change) {
        Binding other = binding;
        change(*other.gradients);
        EXPECT_REFUSED(Error, message, other.checkParts());
    };
    using embed::Gradients;
    refuse("has gradients of 0 vertices", [](Gradients& g) { g = {}; });
    refuse("gradients of 1 points have 0 rows", [](Gradients& g) { g.points = {3}; });
    refuse("gradients of the point -1; there are 10",
           [](Gradients& g) { g.splines.places[2].point = -1; });
    refuse("point 3 is in patch", [](Gradients& g) { g.splines.places[3].patch = 1000; });
    refuse("point 3 is in patch -1", [](Gradients& g) { g.splines.places[3].patch = -1; });
    refuse("point 4 in its cell is not finite",
           [](Gradients& g) { g.splines.places[4].uvw[1] = kNan; });
    refuse("a spacing of 2", [](Gradients& g) { g.splines.spacing = 2; });
    refuse("gradients of the point 10; there are 10", [](Gradients& g) {
        g.cells.places.push_back({10, 0, {}});
    });
    refuse("the point 3 has gradients twice", [](Gradients& g) {
        g.cells.places = {{3, 0, {}}}, g.cells.cells = {{}};
    });
    refuse("a patch has vertex 180 at its control point 21",
           [](Gradients& g) { g.splines.patches[0][21] = 180; });
    // The box has 5 × 6 × 5 vertices.
    refuse("in a lattice of 4 × 4 × 4 cells have 150 vertices", [](Gradients& g) {
        g = {g.vertices};
        g.basis = {embed::Basis::Bezier, {4, 4, 4}, {{0, {}}}};
    });
    refuse("in the lattice is 0.5 along axis 2; expected 1 to 3", [](Gradients& g) {
        g = {g.vertices};
        g.basis = {embed::Basis::BSpline, {4, 5, 4}, {{0, {1, 4, 0.5}}}};
    });
    refuse("gradients of the point 10; there are 10", [](Gradients& g) {
        g = {g.vertices};
        g.basis = {embed::Basis::Bezier, {4, 5, 4}, {{10, {}}}};
    });
}

}  // namespace
}  // namespace espalier::bind
