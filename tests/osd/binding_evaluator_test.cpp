// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/tensor_product.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>

#include "support/test.h"
#include "support/zoo.h"

namespace espalier::osd {
namespace {

embed::TableBinding bindTo(const Lattice& lattice, int level, const std::vector<Point3>& points,
                           const embed::EmbeddingOptions& options = {}) {
    return embed::bindPoints({TopologyRefiner(lattice.complex), lattice.positions}, points,
                             {.level = level, .embedding = options})
        .binding;
}

// The pose shears a cube: points inside follow, and the point outside stays in place.
TEST(Binding, MovesPointsInsideAndKeepsPointsOutside) {
    const Lattice cube = shapes::box();
    const std::vector<Point3> points = {{0.5, 0.25, 0.75}, {3, 3, 3}, {1, 1, 1}};
    const auto binding = bindTo(cube, 2, points);
    EXPECT_EQ(binding.kept, std::vector<Index>{1});
    std::vector<Point3> pose = cube.positions;
    for (Point3& p : pose) p[0] += 2 * p[2];
    const auto moved = evaluateBinding(binding, pose);
    const std::vector<Point3> expected = {{0.5 + 1.5, 0.25, 0.75}, {3, 3, 3}, {3, 1, 1}};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(moved[i][c], expected[i][c], 1e-14);
}

// A point on an edge along x, whose end moves by (1, 3, 0): F = 1 + (1, 3, 0) ⊗ (1, 0, 0). A point
// without weights has the identity.
TEST(Binding, GradientsOfAnEdge) {
    using stencils::StencilTable;
    const StencilTable<double> along(2, {0, 2, 2}, {0, 1}, {-1, 1}), none(2, {0, 0, 0}, {}, {});
    const std::vector<Point3> rest = {{5, 0, 0}, {6, 0, 0}}, pose = {{5, 0, 0}, {7, 3, 0}};
    const auto gradients = evaluateGradients({along, none, none}, rest, pose);
    const std::vector<DeformationGradient> expected = {{2, 0, 0, 3, 1, 0, 0, 0, 1},
                                                       {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    EXPECT_EQ(gradients, expected);
    EXPECT_THROW(evaluateGradients({along, none, none}, rest, std::span(pose).first(1)), Error);
}

// At rest each point is exactly where it was: 0.348799 stays 0.348799. A pose that moves one corner
// leaves the points exactly where they were whose rows do not have this corner.
TEST(Binding, DisplacementsLeavePointsThatDoNotMoveExactlyWhereTheyAre) {
    const Lattice box = shapes::box({.cells = {6, 2, 2}, .max = {3.1, 1.2, 0.7}});
    std::vector<Point3> points = {{0.348799, 0.1, 0.2}, {9, 9, 9}};
    for (int i = 0; i < 100; ++i) points.push_back({0.031 * i, 0.011 * i, 0.3});
    const auto binding = bindTo(box, 2, points);
    const RestPositions rest{points, box.positions};
    EXPECT_EQ(evaluateBinding(binding, rest, box.positions), points);
    EXPECT_EQ(evaluateBinding(embed::convertBinding<float>(binding), rest, box.positions), points);
    auto pose = box.positions;
    pose[0] = {-1, -1, -1};
    const auto moved = evaluateBinding(binding, rest, pose), whole = evaluateBinding(binding, pose);
    Index same = 0;
    for (Index i = 0; i < std::ssize(points); ++i) {
        const auto columns = binding.table.columns(i);
        if (std::ranges::find(columns, 0) == columns.end()) {
            EXPECT_EQ(moved[i], points[i]);
            ++same;
        }
        // The same points as by D · p', up to the placement error and roundings.
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(moved[i][c], whole[i][c], 1e-13);
    }
    EXPECT_GT(same, 20);
    EXPECT_LT(same, 90);
}

// In single precision, the error is relative to the displacement, not to the distance from the
// origin: here 1000 times as small.
TEST(Binding, DisplacementsKeepDigitsFarFromTheOrigin) {
    Lattice box = shapes::box({.cells = {3, 3, 3}});
    std::vector<Point3> points;
    for (int i = 0; i < 50; ++i) points.push_back({0.02 * i, 0.5, 1 - 0.02 * i});
    for (auto* positions : {&box.positions, &points})
        for (Point3& p : *positions) p[0] += 1000;
    const auto exact = bindTo(box, 2, points);
    const auto single = embed::convertBinding<float>(exact);
    auto pose = box.positions;
    for (Point3& p : pose) p[0] += 0.1 * p[1] * p[2];
    const auto expected = evaluateBinding(exact, pose);
    const auto moved = evaluateBinding(single, {points, box.positions}, pose);
    const auto whole = evaluateBinding(single, pose);
    double error = 0, errorOfWhole = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        error = std::max(error, std::abs(moved[i][0] - expected[i][0]));
        errorOfWhole = std::max(errorOfWhole, std::abs(whole[i][0] - expected[i][0]));
    }
    EXPECT_LT(error, 64 * 6e-8 * 0.1);  // roundings of up to 64 products of size 0.1
    EXPECT_GT(errorOfWhole, 1e-5);      // roundings of numbers of size 1000
}

// A compiled table in float, with the points at rest as its addend, rounds at the size of the
// coordinates once: the error is half a unit in the last place, 3.1e-5 at 1000 units from the
// origin. By D · p' it is 2e-4.
TEST(Binding, AnAddendKeepsDigitsInFloat) {
    Lattice box = shapes::box({.cells = {3, 3, 3}});
    std::vector<Point3> points;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> part(0, 1);
    for (int i = 0; i < 2000; ++i) points.push_back({part(random), part(random), part(random)});
    for (auto* positions : {&box.positions, &points})
        for (Point3& p : *positions) p[0] += 1000;
    const auto exact = bindTo(box, 2, points);
    const CompiledTable<float> compiled(stencils::convertTable<float>(exact.table));
    auto pose = box.positions;
    for (Point3& p : pose) p[0] += 0.1 * p[1] * p[2];
    const auto expected = evaluateBinding(exact, {points, box.positions}, pose);
    const auto inFloat = [](const std::vector<Point3>& positions) {
        std::vector<float> numbers;
        for (const Point3& p : positions)
            for (const double x : p) numbers.push_back(static_cast<float>(x));
        return numbers;
    };
    std::vector<Point3> displacements = pose;
    for (std::size_t v = 0; v < pose.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) displacements[v][c] -= box.positions[v][c];
    const std::vector<float> rest = inFloat(points);
    std::vector<float> moved(rest.size()), whole(rest.size());
    const auto xyz = BufferDescriptor::packed(3);
    const RowRange all{0, compiled.rowCount()};
    compiled.evaluate(inFloat(displacements), xyz, moved, xyz, all, Addend<float>::packed(rest, 3));
    compiled.evaluate(inFloat(pose), xyz, whole, xyz, all);
    double error = 0, errorOfWhole = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        // Relative to the point at rest as float holds it, which no evaluation can improve.
        const double target = expected[i][0] - points[i][0] + double(rest[3 * i]);
        error = std::max(error, std::abs(double(moved[3 * i]) - target));
        errorOfWhole = std::max(errorOfWhole, std::abs(double(whole[3 * i]) - expected[i][0]));
    }
    constexpr double kUnit = 6.1e-5;  // of floats from 512 to 1024
    EXPECT_LT(error, 0.51 * kUnit);
    EXPECT_GT(errorOfWhole, kUnit);
}

TEST(Binding, DisplacementsNeedOnePositionForEachPointAndVertex) {
    const Lattice cube = shapes::box();
    const std::vector<Point3> points = {{0.5, 0.5, 0.5}}, none;
    const auto binding = bindTo(cube, 1, points);
    EXPECT_REFUSED(Error, "there are 0 points at rest; the bound model has 1",
                   evaluateBinding(binding, {none, cube.positions}, cube.positions));
    EXPECT_REFUSED(Error, "the pose has 1 vertices",
                   evaluateBinding(binding, {points, cube.positions}, points));
    EXPECT_REFUSED(Error, "there are 1 vertices at rest; the model is bound to a lattice of 8",
                   evaluateBinding(binding, {points, points}, cube.positions));
}

// In the factored D, the lattice moves the vertices of the level, and these move the points.
TEST(Binding, FactoredBindingMovesAndKeepsTheSamePoints) {
    const Lattice lattice = shapes::cylinder({.sectors = 5});
    const std::vector<Point3> points = {{0.1, 0.2, 0.3}, {5, 5, 5}, {-0.3, 0.1, 0.9}, {0, 0, 0.5}};
    const TopologyRefiner base(lattice.complex);
    const auto bound = embed::bindPoints({base, lattice.positions}, points, {.level = 3});
    const auto factored = embed::bindFactored({base, lattice.positions}, points, {.level = 3});
    EXPECT_EQ(factored.binding.kept, std::vector<Index>{1});
    auto pose = lattice.positions;
    for (Point3& p : pose) p[2] += p[0] * p[1];
    const auto expected = evaluateBinding(bound.binding, pose);
    const auto moved = evaluateBinding(factored.binding, pose);
    EXPECT_EQ(moved[1], points[1]);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(moved[i][c], expected[i][c], 1e-14);
    EXPECT_THROW(evaluateBinding(factored.binding, shapes::octahedron().positions), Error);
}

TEST(Binding, SinglePrecisionAgreesWithDouble) {
    const Lattice torus = shapes::torus();
    std::vector<Point3> points;
    for (const double angle : {0.1, 1.0, 2.0, 4.0, 5.5})
        points.push_back({std::cos(angle), std::sin(angle), 0.1});
    const auto exact = bindTo(torus, 2, points);
    const auto single = embed::convertBinding<float>(exact);
    auto pose = torus.positions;
    for (Point3& p : pose) p[2] += p[0] * p[1];
    const auto a = evaluateBinding(single, pose), b = evaluateBinding(exact, pose);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            // Rounding of up to 64 products of size 1 in single precision.
            EXPECT_NEAR(a[i][c], b[i][c], 64 * 6e-8);
}

// Section 8 of the paper: "as the lattice is deformed, the texture would be deformed along with the
// object". A solid texture on the lattice vertices is evaluated with the same table as positions.
TEST(Binding, TableAppliesToAnyVertexAttribute) {
    const Lattice cube = shapes::box({.cells = {2, 2, 2}});
    const std::vector<Point3> points = {{0.5, 0.25, 0.75}, {0.1, 0.9, 0.3}};
    const auto binding = bindTo(cube, 2, points);
    // The texture is affine in space, so its values are known everywhere: s = x + 2y, t = 1 − z.
    std::vector<double> texture, values(4);
    for (const Point3& p : cube.positions) {
        texture.push_back(p[0] + 2 * p[1]);
        texture.push_back(1 - p[2]);
    }
    ReferenceEvaluator::evaluate(binding.table, texture, BufferDescriptor::packed(2), values,
                                 BufferDescriptor::packed(2), {0, 2});
    const std::vector<double> expected = {1, 0.25, 1.9, 0.7};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(values[i], expected[i], 1e-14);
}

TEST(Binding, RejectsADifferentNumberOfPointsThanEmbedded) {
    const Lattice cube = shapes::box();
    const embed::TensorLattice tensor(cube.complex, cube.positions, embed::Basis::Bezier);
    const std::vector<Point3> points(3, Point3{0.5, 0.5, 0.5});
    const auto embedding = embed::embedPoints(tensor, points);
    for (const std::size_t count : {2u, 4u}) {
        const std::vector<Point3> others(count);
        EXPECT_THROW(embed::makeBinding(tensor, embedding, others), Error);
    }
}

TEST(Binding, RejectsAPoseOfAnotherSize) {
    const Lattice cube = shapes::box();
    const auto binding = bindTo(cube, 1, {{0.5, 0.5, 0.5}});
    EXPECT_THROW(evaluateBinding(binding, shapes::octahedron().positions), Error);
}

}  // namespace
}  // namespace espalier::osd
