// SPDX-License-Identifier: Apache-2.0
#include "cages/model_voxels.h"

#include <espalier/base/vector3.h>
#include <gtest/gtest.h>

#include "face_models.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

using test::FaceModel;

ModelVoxels voxelsOf(const FaceModel& model, const VoxelOptions& options) {
    const ModelSurface surface(model);
    return {surface, surface.points(), options};
}

Point3 centreOf(const CubeGrid& grid, Index cube) {
    const std::array<Index, 3> place = {cube % grid.counts[0],
                                        cube / grid.counts[0] % grid.counts[1],
                                        cube / grid.counts[0] / grid.counts[1]};
    Point3 centre;
    for (int axis = 0; axis < 3; ++axis)
        centre[axis] = grid.origin[axis] + (place[axis] + 0.5) * grid.size;
    return centre;
}

/// Expects that the voxels are the cubes of a solid, given by its distance function. Cubes nearer
/// to the boundary than their size may be in or out.
template <class Distance>
void expectSolid(const ModelVoxels& voxels, Distance distance) {
    const CubeGrid& grid = voxels.grid();
    Index wrong = 0, sure = 0;
    for (Index cube = 0; cube < grid.cubeCount(); ++cube) {
        const double here = distance(centreOf(grid, cube));
        if (std::abs(here) < 1.1 * grid.size) continue;
        ++sure;
        wrong += (here < 0) != (voxels.isUsed()[cube] != 0);
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(sure, 1000);
}

TEST(ModelVoxels, fillClosedPieces) {
    expectSolid(voxelsOf(test::ballModel(4), {.size = 0.07}),
                [](const Point3& p) { return length(p) - 1; });
    expectSolid(voxelsOf(test::reversed(test::ballModel(4)), {.size = 0.07}),
                [](const Point3& p) { return length(p) - 1; });
    expectSolid(voxelsOf(test::ringModel(1, 0.4, 100, 30), {.size = 0.07}),
                [](const Point3& p) { return std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.4; });
}

TEST(ModelVoxels, fillPiecesThatIntersectAndNotCavities) {
    const auto ball = [](double x, double radius) {
        return test::ballModel(4, {radius, radius, radius}, {x, 0, 0});
    };
    const auto distance = [](const Point3& p, double x) {
        return length(difference(p, {x, 0, 0}));
    };
    // One of the two is wound inwards, and still no cavity, since most of it is outside the other.
    expectSolid(
        voxelsOf(test::joined({ball(0, 1), test::reversed(ball(1.4, 0.9))}), {.size = 0.08}),
        [&](const Point3& p) { return std::min(distance(p, 0) - 1, distance(p, 1.4) - 0.9); });
    expectSolid(
        voxelsOf(test::joined({ball(0, 1), test::reversed(ball(0.2, 0.5))}), {.size = 0.06}),
        [&](const Point3& p) { return std::max(distance(p, 0) - 1, 0.5 - distance(p, 0.2)); });
    // A ball in a ball, both wound outwards, is solid.
    expectSolid(voxelsOf(test::joined({ball(0, 1), ball(0.2, 0.5)}), {.size = 0.07}),
                [&](const Point3& p) { return distance(p, 0) - 1; });
}

/// Six squares of a cube that do not meet: each is smaller than a side of the cube.
FaceModel looseBox(double half) {
    FaceModel model;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-1, 1}) {
            const auto first = static_cast<Index>(model.points.size());
            for (const auto& [u, v] :
                 {std::pair(-half, -half), {half, -half}, {half, half}, {-half, half}}) {
                Point3 p;
                p[axis] = side;
                p[(axis + 1) % 3] = u;
                p[(axis + 2) % 3] = v;
                model.points.push_back(p);
            }
            model.addFace({first, first + 1, first + 2, first + 3});
        }
    return model;
}

TEST(ModelVoxels, fillSpaceBehindNarrowGaps) {
    const auto isFilled = [](const ModelVoxels& voxels) {
        return voxels.isUsed()[voxels.grid().cubeOf({0.1, 0, 0})] != 0;
    };
    // The gaps along the edges are √2 · 0.1 wide.
    EXPECT_TRUE(isFilled(voxelsOf(looseBox(0.9), {.size = 0.04, .gap = 0.3})));
    EXPECT_FALSE(isFilled(voxelsOf(looseBox(0.9), {.size = 0.02, .gap = 0.05})));
}

TEST(ModelVoxels, fillAShell) {
    constexpr double kRadius = 0.2;
    const ModelVoxels voxels =
        voxelsOf(test::ballModel(5), {.size = 0.05, .isShell = true, .around = kRadius});
    const CubeGrid& grid = voxels.grid();
    for (Index cube = 0; cube < grid.cubeCount(); ++cube) {
        // Distances are between centres of cubes, and the surface is up to half a diagonal away
        // from the centre of a cube that it meets.
        const double away = std::abs(length(centreOf(grid, cube)) - 1);
        if (away < kRadius - 0.05) {
            EXPECT_TRUE(voxels.isUsed()[cube]);
        }
        if (away > kRadius + 0.05) {
            EXPECT_FALSE(voxels.isUsed()[cube]);
        }
    }
}

TEST(ModelVoxels, knowInnerPoints) {
    const ModelVoxels voxels = voxelsOf(test::ballModel(4), {.size = 0.05});
    EXPECT_TRUE(voxels.isInner({0, 0, 0}));
    EXPECT_TRUE(voxels.isInner({0.7, 0, 0}));
    EXPECT_FALSE(voxels.isInner({0.97, 0, 0}));
    EXPECT_FALSE(voxels.isInner({1.5, 0, 0}));
    // Surroundings are not the solid, and a shell has no inside.
    const ModelVoxels wider = voxelsOf(test::ballModel(4), {.size = 0.05, .around = 0.5});
    EXPECT_TRUE(wider.isUsed()[wider.grid().cubeOf({1.4, 0, 0})]);
    EXPECT_FALSE(wider.isInner({0.97, 0, 0}));
    const ModelVoxels shell =
        voxelsOf(test::ballModel(4), {.size = 0.05, .isShell = true, .around = 0.5});
    EXPECT_FALSE(shell.isInner({1, 0, 0}));
}

TEST(ModelVoxels, containTheSurfaceOfThinModels) {
    const FaceModel sheet = test::sheetModel();
    const ModelVoxels voxels = voxelsOf(sheet, {.size = 0.1, .gap = 0.2});
    for (const Point3& p : sheet.points) EXPECT_TRUE(voxels.isUsed()[voxels.grid().cubeOf(p)]);
}

}  // namespace
}  // namespace espalier::cages
