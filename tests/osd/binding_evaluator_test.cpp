// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/stencils/composition.h>

#include "support/test.h"
#include "support/zoo.h"

namespace espalier::osd {
namespace {

bind::Binding bindTo(const Lattice& lattice, int level, const std::vector<Point3>& points) {
    return bind::bindPoints({TopologyRefiner(lattice.complex), lattice.positions}, points,
                            bind::Level{level});
}

// The pose shears a cube: points inside follow, and the point outside stays in place.
TEST(Binding, MovesPointsInsideAndKeepsPointsOutside) {
    const Lattice cube = shapes::box();
    const std::vector<Point3> points = {{0.5, 0.25, 0.75}, {3, 3, 3}, {1, 1, 1}};
    const auto binding = bindTo(cube, 2, points);
    EXPECT_EQ(binding.table.emptyRows(), std::vector<Index>{1});
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
    const StencilTable<double> along(2, {0, 2, 2}, {0, 1}, {-1, 1});
    const std::vector<Point3> rest = {{5, 0, 0}, {6, 0, 0}}, pose = {{5, 0, 0}, {7, 3, 0}};
    bind::Binding binding{{along}};
    binding.points.resize(2);
    binding.statuses.resize(2);
    binding.rest = rest;
    EXPECT_REFUSED(Error, "has no gradients", evaluateGradients(binding, pose));
    // Rows of the first point: the derivatives by y and z are 0.
    const StencilTable<double> rows(2, {0, 2, 2, 2}, {0, 1}, {-1, 1});
    const StencilTable<double> vertices(2, {0, 1, 2}, {0, 1}, {1, 1});
    binding.gradients = embed::Gradients{vertices, {0}, rows};
    const auto gradients = evaluateGradients(binding, pose);
    const std::vector<DeformationGradient> expected = {{2, 0, 0, 3, 1, 0, 0, 0, 1},
                                                       {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    EXPECT_EQ(gradients, expected);
    EXPECT_REFUSED(Error, "the pose has 1 vertices; the model is bound to a lattice of 2",
                   evaluateGradients(binding, std::span(pose).first(1)));
}

// At rest each point is exactly where it was: 0.348799 stays 0.348799. A pose that moves one corner
// leaves the points exactly where they were whose rows do not have this corner.
TEST(Binding, DisplacementsLeavePointsThatDoNotMoveExactlyWhereTheyAre) {
    const Lattice box = shapes::box({.cells = {6, 2, 2}, .max = {3.1, 1.2, 0.7}});
    std::vector<Point3> points = {{0.348799, 0.1, 0.2}, {9, 9, 9}};
    for (int i = 0; i < 100; ++i) points.push_back({0.031 * i, 0.011 * i, 0.3});
    const auto binding = bindTo(box, 2, points);
    EXPECT_EQ(evaluateBinding(binding, box.positions), points);
    auto pose = box.positions;
    pose[0] = {-1, -1, -1};
    const auto moved = evaluateBinding(binding, pose),
               whole = stencils::applyLevelTable(binding.table, pose);
    Index same = 0;
    for (Index i = 0; i < std::ssize(points); ++i) {
        const auto columns = binding.table.columns(i);
        if (std::ranges::find(columns, 0) == columns.end()) {
            EXPECT_EQ(moved[i], points[i]);
            ++same;
        }
        // The same points as by D · p', up to the placement error and roundings.
        for (std::size_t c = 0; c < 3 && i != 1; ++c) EXPECT_NEAR(moved[i][c], whole[i][c], 1e-13);
    }
    EXPECT_GT(same, 20);
    EXPECT_LT(same, 90);
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

TEST(Binding, RejectsAPoseOfAnotherSize) {
    const Lattice cube = shapes::box();
    const auto binding = bindTo(cube, 1, {{0.5, 0.5, 0.5}});
    EXPECT_THROW(evaluateBinding(binding, shapes::octahedron().positions), Error);
}

}  // namespace
}  // namespace espalier::osd
