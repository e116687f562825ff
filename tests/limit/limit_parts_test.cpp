// SPDX-License-Identifier: Apache-2.0
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/limit_parts.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Core>

#include "support/random_lattices.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::limit {
namespace {

using Eigen::Vector3d;

Vector3d valueAt(const BezierPatch& patch, const Vector3d& uvw) {
    const auto bernstein = [](std::size_t i, double t) {
        const double s = 1 - t;
        return std::array{s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t}[i];
    };
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 0; i < 64; ++i)
        sum += bernstein(i % 4, uvw[0]) * bernstein(i / 4 % 4, uvw[1]) * bernstein(i / 16, uvw[2]) *
               Vector3d(patch.points[i].data());
    return sum;
}

// A binding moves a point in a patch at rest to the same (u, v, w) of the patch in the pose.
TEST(LimitParts, PatchesAgreeWithBindings) {
    for (const auto& [name, lattice] : zoo()) {
        if (name == "tripod") continue;  // Its limit is folded: a point may have two places.
        for (const Boundary boundary : {Boundary::Sharp, Boundary::EdgeOnly}) {
            const TopologyRefiner base(lattice.complex,
                                       refinerOptions(lattice, {.boundary = boundary}));
            const LimitParts parts(base, 2);
            const auto pose = shaken(lattice.positions, 7, 0.2);
            const LimitPositions atRest = parts.place(lattice.positions), posed = parts.place(pose);
            std::vector<Point3> points, expected;
            const auto places = randomValues(3 * parts.patchCount(), 11);
            for (std::size_t i = 0; i < parts.patchCount(); i += 1 + parts.patchCount() / 40) {
                Vector3d uvw(&places[3 * i]);
                uvw = (uvw + Vector3d::Ones()) / 2;
                const Vector3d from = valueAt(parts.bezierPatch(i, atRest), uvw),
                               to = valueAt(parts.bezierPatch(i, posed), uvw);
                points.push_back({from[0], from[1], from[2]});
                expected.push_back({to[0], to[1], to[2]});
            }
            const auto bound = bindLimit({base, lattice.positions}, points);
            const auto got = stencils::applyLevelTable(bound.table, pose);
            for (std::size_t i = 0; i < points.size(); ++i)
                for (std::size_t c = 0; c < 3; ++c)
                    // A solve has a residual of 1e-12, and thin cells may stretch it a thousand
                    // times.
                    ASSERT_NEAR(got[i][c], expected[i][c], 1e-9) << name << " point " << i;
        }
    }
}

// No part occurs twice, and none is missing.
TEST(LimitParts, PartsCoverEachCellOnce) {
    for (const auto& [name, lattice] : zoo()) {
        const TopologyRefiner base(lattice.complex, {.marks = lattice.marks});
        for (const int level : {1, 3}) {
            const LimitParts parts(base, level);
            std::set<std::pair<int, Index>> seen;
            // The number of cells of the last level that each base cell descends into. A patch is a
            // hexahedron, which has 8 children on each level; a blended cell is on the last level
            // already.
            std::vector<std::size_t> count(base.level(0).complex.count(3));
            for (std::size_t i = 0; i < parts.parts().size(); ++i) {
                const LimitPart& part = parts.parts()[i];
                EXPECT_TRUE(seen.insert({part.level, part.cell}).second) << name;
                EXPECT_LE(part.level, level);
                if (i >= parts.patchCount()) {
                    EXPECT_EQ(part.level, level);
                }
                count[part.baseCell] += std::size_t{1} << 3 * (level - part.level);
            }
            TopologyRefiner whole = refined(lattice.complex, level, {.marks = lattice.marks});
            std::vector<std::size_t> expected(count.size());
            for (Index cell = 0; cell < whole.level(level).complex.count(3); ++cell) {
                Index ancestor = cell;
                for (int k = level; k > 0; --k)
                    ancestor = whole.refinement(k).parentOf({3, ancestor}).upper.index;
                ++expected[ancestor];
            }
            EXPECT_EQ(count, expected) << name;
        }
    }
}

// In regular lattices each cell is a patch. The number of blended cells around an edge doubles with
// each level.
TEST(LimitParts, OnlyFeaturesAreRefined) {
    const TopologyRefiner box(shapes::box({.cells = {3, 2, 1}}).complex);
    for (const int level : {1, 4}) {
        const LimitParts parts(box, level);
        EXPECT_EQ(parts.patchCount(), 6);
        EXPECT_EQ(parts.parts().size(), 6);
    }
    // Five triangular prisms: the axis has 5 cells at each of its 2^level pieces, and the middle of
    // each prism has 3.
    const TopologyRefiner fan(shapes::cylinder({.sectors = 5, .layers = 1}).complex);
    for (const int level : {2, 3, 4}) {
        const LimitParts parts(fan, level);
        EXPECT_EQ(parts.parts().size() - parts.patchCount(), std::size_t{20} << level);
    }
}

// Without boundary control, three cells along each axis shrink to the one in the middle.
TEST(LimitParts, CellsThatShrinkAwayAreNotParts) {
    const Lattice lattice = shapes::box({.cells = {3, 3, 3}, .max = {3, 3, 3}});
    const TopologyRefiner base(lattice.complex, {.boundary = Boundary::Open});
    const LimitParts parts(base, 3);
    ASSERT_GE(parts.patchCount(), 1);
    EXPECT_EQ(parts.parts()[0].baseCell, 13);
    const BezierPatch middle = parts.bezierPatch(0, parts.place(lattice.positions));
    for (const double t : {0.0, 0.4, 1.0})
        // Linear precision, for sums of 64 numbers of size 1.
        EXPECT_LE((valueAt(middle, {t, t / 2, 0}) - Vector3d(1 + t, 1 + t / 2, 1)).norm(), 1e-14);
    const TopologyRefiner single(shapes::box().complex, {.boundary = Boundary::Open});
    EXPECT_THROW(LimitParts(single, 3), far::TopologyError);
}

TEST(LimitParts, RefusesInvalidArguments) {
    const TopologyRefiner box(shapes::box().complex);
    for (const int level : {0, 16})
        EXPECT_REFUSED(Error, "expected 1 to 15", LimitParts(box, level));
    const TopologyRefiner mesh(gridMesh(2, 2));
    EXPECT_REFUSED(Error, "dimension 2", LimitParts(mesh, 1));
    const std::vector<Point3> few(7);
    EXPECT_REFUSED(Error, "got 7 positions for 8 vertices", LimitParts(box, 1).place(few));
}

}  // namespace
}  // namespace espalier::limit
