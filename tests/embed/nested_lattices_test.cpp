// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/embed/nested_lattices.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Geometry>

#include "support/refined_lattice.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

// A lattice inside another lattice moves with it, and carries its own model.
namespace espalier::embed {
namespace {

constexpr int kLevel = 2;

stencils::StencilTable<double> bindTo(const Lattice& lattice, const std::vector<Point3>& points) {
    return bindPoints({TopologyRefiner(lattice.complex), lattice.positions}, points,
                      {.level = kLevel, .embedding = {.outside = OutsidePolicy::Error}})
        .table;
}

/// A box in a cylinder, and points in the box.
struct Nest {
    Lattice parent = shapes::cylinder({.sectors = 5});
    TopologyRefiner parentBase{parent.complex};
    Lattice child =
        shapes::box({.cells = {2, 1, 1}, .min = {-0.3, -0.2, 0.3}, .max = {0.3, 0.2, 0.7}});
    std::vector<Point3> points = pointsIn(Refined(child, kLevel), 200, 3);
    StencilTable<double> ofChild = bindTo(child, points);

    stencils::StencilTable<double> nest(const std::vector<Point3>& childPose,
                                        const EmbeddingOptions& options = {}) const {
        return nestTables(ofChild, childPose, {parentBase, parent.positions},
                          {.level = kLevel, .embedding = options});
    }
};

// Sums of about a hundred products of weights and coordinates near 1.
constexpr double kRounding = 1e-14;

void expectNear(const std::vector<Point3>& got, const std::vector<Point3>& expected) {
    ASSERT_EQ(got.size(), expected.size());
    for (std::size_t i = 0; i < got.size(); ++i)
        EXPECT_LT((vec(got[i]) - vec(expected[i])).cwiseAbs().maxCoeff(), kRounding) << i;
}

TEST(NestedLattices, AreOneTable) {
    const Nest nest;
    const auto table = nest.nest(nest.child.positions);
    EXPECT_EQ(table.rowCount(), 200);
    EXPECT_EQ(table.columnCount(), nest.parent.complex.count(0));
    expectNear(stencils::applyLevelTable(table, nest.parent.positions), nest.points);
    const auto pose = shaken(nest.parent.positions, 4, 0.2);
    const auto carried = stencils::applyLevelTable(bindTo(nest.parent, nest.child.positions), pose);
    expectNear(stencils::applyLevelTable(table, pose),
               stencils::applyLevelTable(nest.ofChild, carried));
}

// A posed child in a parent that rotates, stretches and shears. The map of the parent is affine, so
// it must map the points as the child deforms them. Adding the displacements of the child to the
// parent's would be wrong, since the frame has rotated.
TEST(NestedLattices, PoseTheChildInTheFrameOfTheParent) {
    const Nest nest;
    const auto childPose = shaken(nest.child.positions, 5, 0.1);
    Eigen::Affine3d map = Eigen::Affine3d::Identity();
    map.translate(Eigen::Vector3d(1, -2, 3));
    map.rotate(Eigen::AngleAxisd(1.5, Eigen::Vector3d(1, 2, 3).normalized()));
    map.scale(Eigen::Vector3d(2, 0.5, 1));
    const auto mapped = [&](std::vector<Point3> points) {
        for (Point3& p : points) {
            const Eigen::Vector3d q = map * vec(p);
            p = {q[0], q[1], q[2]};
        }
        return points;
    };
    expectNear(stencils::applyLevelTable(nest.nest(childPose), mapped(nest.parent.positions)),
               mapped(stencils::applyLevelTable(nest.ofChild, childPose)));
}

// In a parent that bends, each vertex of the posed child moves like a point of the parent.
TEST(NestedLattices, PosedVerticesMoveLikePointsOfTheParent) {
    const Nest nest;
    const auto childPose = shaken(nest.child.positions, 6, 0.1);
    const auto pose = shaken(nest.parent.positions, 7, 0.2);
    expectNear(stencils::applyLevelTable(nest.nest(childPose), pose),
               stencils::applyLevelTable(
                   nest.ofChild, stencils::applyLevelTable(bindTo(nest.parent, childPose), pose)));
}

TEST(NestedLattices, NestToAnyDepth) {
    const Nest nest;
    const Lattice outermost =
        shapes::box({.cells = {2, 2, 2}, .min = {-2, -2, -1}, .max = {2, 2, 2}});
    const TopologyRefiner base(outermost.complex);
    const auto table = nestTables(nest.nest(nest.child.positions), nest.parent.positions,
                                  {base, outermost.positions}, {.level = kLevel});
    const auto pose = test::shaken(outermost.positions, 8, 0.2);
    const auto parentPose =
        stencils::applyLevelTable(bindTo(outermost, nest.parent.positions), pose);
    expectNear(stencils::applyLevelTable(table, pose),
               stencils::applyLevelTable(nest.nest(nest.child.positions), parentPose));
}

TEST(NestedLattices, RefuseInvalidInput) {
    const Nest nest;
    auto outside = nest.child.positions;
    outside[3] = {5, 0, 0};
    for (const auto policy : {OutsidePolicy::Keep, OutsidePolicy::Error})
        EXPECT_REFUSED(Error, "vertex 3 of the child lies outside the parent lattice",
                       nest.nest(outside, {.outside = policy}));
    const std::string cannotCarry =
        "vertex 3 of the child lies outside the parent lattice, and the "
        "nearest cell cannot carry it: it is too far away";
    EXPECT_REFUSED(Error, cannotCarry, nest.nest(outside, {.outside = OutsidePolicy::Nearest}));
    outside[3] = {2, 0, 0};
    EXPECT_EQ(nest.nest(outside, {.outside = OutsidePolicy::Nearest}).rowCount(), 200);
    auto fewer = nest.child.positions;
    fewer.pop_back();
    EXPECT_REFUSED(Error, "got 11 positions for 12 vertices of the child", nest.nest(fewer));
    auto nowhere = nest.child.positions;
    nowhere[2][1] = kNan;
    nowhere[0] = {5, 0, 0};
    for (const auto policy : {OutsidePolicy::Keep, OutsidePolicy::Nearest})
        EXPECT_REFUSED(Error, "the position of vertex 2 of the child is not finite",
                       nest.nest(nowhere, {.outside = policy}));
    // A parent without a volume has no places.
    auto flat = nest.parent;
    for (Point3& p : flat.positions) p[2] = 0;
    EXPECT_THAT(
        [&] {
            nestTables(nest.ofChild, nest.child.positions, {nest.parentBase, flat.positions},
                       {.level = kLevel, .embedding = {.outside = OutsidePolicy::Nearest}});
        },
        ThrowsMessage<Error>(
            HasSubstr("vertex 0 of the child lies outside the parent lattice, and the nearest cell "
                      "cannot carry it: it is too far away, or the cell is flat")));
}

}  // namespace
}  // namespace espalier::embed
