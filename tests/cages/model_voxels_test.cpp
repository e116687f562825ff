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
        wrong += (here < 0) != (voxels.used()[cube] != 0);
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
        return voxels.used()[voxels.grid().cubeOf({0.1, 0, 0})] != 0;
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
            EXPECT_TRUE(voxels.used()[cube]);
        }
        if (away > kRadius + 0.05) {
            EXPECT_FALSE(voxels.used()[cube]);
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
    EXPECT_TRUE(wider.used()[wider.grid().cubeOf({1.4, 0, 0})]);
    EXPECT_FALSE(wider.isInner({0.97, 0, 0}));
    const ModelVoxels shell =
        voxelsOf(test::ballModel(4), {.size = 0.05, .isShell = true, .around = 0.5});
    EXPECT_FALSE(shell.isInner({1, 0, 0}));
}

/// Returns true if a triangle comes within `most` of a point, by a search in smaller and smaller
/// parts of the triangle.
/// \param along largest difference of a coordinate counts, so that cubes are balls
bool comesNear(const std::array<Point3, 3>& triangle, const Point3& point, double most, int depth) {
    double least = 1e9, extent = 0;
    for (const Point3& corner : triangle) {
        double distance = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            distance = std::max(distance, std::abs(corner[axis] - point[axis]));
            extent = std::max(extent, std::abs(corner[axis] - triangle[0][axis]));
        }
        least = std::min(least, distance);
    }
    if (least <= most) return true;
    if (least > most + 2 * extent || depth == 0) return false;
    const auto& [a, b, c] = triangle;
    const Point3 ab = between(a, b, 0.5), bc = between(b, c, 0.5), ca = between(c, a, 0.5);
    return comesNear({a, ab, ca}, point, most, depth - 1) ||
           comesNear({ab, b, bc}, point, most, depth - 1) ||
           comesNear({ca, bc, c}, point, most, depth - 1) ||
           comesNear({ab, bc, ca}, point, most, depth - 1);
}

// Random triangles, needles, lines along axes and across, and points. A cube that a triangle only
// just touches or misses may be in or out: its distance is within a hundredth of its size.
TEST(ModelVoxels, areTheCubesThatATriangleMeets) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-1, 1);
    const auto any = [&] { return Point3{place(random), place(random), place(random)}; };
    Index sure = 0;
    for (int number = 0; number < 60; ++number) {
        std::array<Point3, 3> t = {any(), any(), any()};
        if (number % 6 == 1) t[2] = between(t[0], t[1], 0.3);        // a line
        if (number % 6 == 2) t[2] = sum(t[1], scaled(any(), 1e-9));  // a needle
        if (number % 6 == 3) t[1] = sum(t[0], {0, 0, 1}), t[2] = sum(t[0], {0, 1e-7, 0.5});
        if (number % 6 == 4) t[1][number % 3] = t[2][number % 3] = t[0][number % 3];
        if (number % 6 == 5) t[1] = sum(t[0], scaled(any(), 0.05)), t[2] = t[0];
        FaceModel model;
        model.points.assign(t.begin(), t.end());
        // Two far points make the grid, whatever the triangle is.
        model.points.insert(model.points.end(), {{-1, -1, -1}, {1, 1, 1}});
        model.addFace({0, 1, 2});
        model.addFace({3, 3, 3});
        model.addFace({4, 4, 4});
        const ModelVoxels voxels = voxelsOf(model, {.size = 0.13, .isShell = true});
        const CubeGrid& grid = voxels.grid();
        const Index first = grid.cubeOf({-1, -1, -1}), last = grid.cubeOf({1, 1, 1});
        for (Index cube = 0; cube < grid.cubeCount(); ++cube) {
            const Point3 centre = centreOf(grid, cube);
            const bool isNear = comesNear(t, centre, 0.49 * grid.size, 12);
            if (isNear != comesNear(t, centre, 0.51 * grid.size, 12)) continue;
            ++sure;
            ASSERT_EQ(voxels.used()[cube] != 0, isNear || cube == first || cube == last)
                << "triangle " << number << ", cube " << cube;
        }
    }
    EXPECT_GT(sure, 200000);
}

TEST(ModelVoxels, containTheSurfaceOfThinModels) {
    const FaceModel sheet = test::sheetModel();
    const ModelVoxels voxels = voxelsOf(sheet, {.size = 0.1, .gap = 0.2});
    for (const Point3& p : sheet.points) EXPECT_TRUE(voxels.used()[voxels.grid().cubeOf(p)]);
}

}  // namespace
}  // namespace espalier::cages
