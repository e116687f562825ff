// SPDX-License-Identifier: Apache-2.0
// The checks of surface meshes: ValidityCheck(SurfaceMesh, …).
#include <espalier/solve/validity.h>

#include <cmath>
#include <numbers>

#include "poses.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::solve {
namespace {

/// A grid of (n + 1)² points in the square from 0 to n, and its squares as faces.
struct Grid {
    far::SurfaceMesh mesh;
    Positions points;
};

/// \param corners 3 for triangles, 4 for quadrilaterals
Grid gridOf(Index n, int corners) {
    Grid grid{far::SurfaceMesh((n + 1) * (n + 1)), {}};
    for (Index j = 0; j <= n; ++j)
        for (Index i = 0; i <= n; ++i) grid.points.push_back({double(i), double(j), 0});
    for (Index j = 0; j < n; ++j)
        for (Index i = 0; i < n; ++i) {
            const Index a = i + (n + 1) * j, b = a + 1, c = b + n + 1, d = a + n + 1;
            if (corners == 4) {
                grid.mesh.addFace(std::vector<Index>{a, b, c, d});
            } else {
                grid.mesh.addFace(std::vector<Index>{a, b, c});
                grid.mesh.addFace(std::vector<Index>{a, c, d});
            }
        }
    return grid;
}

/// Turns about the x axis through the point (0, 0, height).
Positions turned(Positions points, double angle, double height = 0) {
    for (Point3& p : points) {
        const double y = p[1], z = p[2] - height;
        p[1] = std::cos(angle) * y - std::sin(angle) * z;
        p[2] = std::sin(angle) * y + std::cos(angle) * z + height;
    }
    return points;
}

/// Rolls the plane up around the x axis.
Positions rolled(Positions points, double radius) {
    for (Point3& p : points)
        p = {p[0], radius * std::sin(p[1] / radius), radius * (1 - std::cos(p[1] / radius))};
    return points;
}

// A corner (1, 1) of the triangle (0, 0), (1, 0), (1, 1) moves across the opposite side to
// (1, −1): the area is 1 − 2t of the area at rest.
TEST(SurfacePieces, AreasInAPlaneHaveTheSignOfThePlane) {
    for (const bool isReversed : {false, true}) {
        far::SurfaceMesh mesh(3);
        mesh.addFace(isReversed ? std::vector<Index>{2, 1, 0} : std::vector<Index>{0, 1, 2});
        const Positions rest = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
        const Positions pose = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}};
        const ValidityCheck check(mesh, rest);
        EXPECT_THAT(check.badAtRest(), IsEmpty());
        EXPECT_THAT(check.check(pose).inverted, ElementsAre(0));
        EXPECT_NEAR(check.check(pose).smallest->value, -1, 1e-12);
        EXPECT_NEAR(check.largestStep(pose).length, 0.5, 1e-12);
        EXPECT_LT(check.largestStep(pose).length, 0.5);
    }
}

// The corner (1, 1) of a square moves to (¼, ¼): beyond the diagonal, so that the corner's angle
// is over 180 degrees and the areas at the corners (1, 0) and (0, 1), which were 1, are ¼.
// At t, the corner is at (c, c) with c = 1 − ¾t; the area at (1, 0) is that of (−1, 0) and
// (c − 1, c): c; at (c, c) it is 2c − 1, which is 0 at t = 2/3.
TEST(SurfacePieces, QuadrilateralsFoldAtACorner) {
    const Grid grid = gridOf(1, 4);
    Positions pose = grid.points;
    pose[3] = {0.25, 0.25, 0};
    const ValidityCheck check(grid.mesh, grid.points);
    EXPECT_NEAR(check.check(pose).smallest->value, -0.5, 1e-12);
    EXPECT_NEAR(check.largestStep(pose).length, 2.0 / 3, 1e-12);
}

// The middle of an edge at a quarter of it: see second_order_piece_test.cpp.
TEST(SurfacePieces, FacesOfSecondOrderAreCheckedAllOver) {
    const Positions square = {{0, 0, 0},   {1, 0, 0},   {1, 1, 0},   {0, 1, 0},    {0.5, 0, 0},
                              {1, 0.5, 0}, {0.5, 1, 0}, {0, 0.5, 0}, {0.5, 0.5, 0}};
    const Positions triangle = {{0, 0, 0},   {1, 0, 0},     {0, 1, 0},
                                {0.5, 0, 0}, {0.5, 0.5, 0}, {0, 0.5, 0}};
    for (const std::size_t size : {6, 8, 9}) {
        Positions rest = size == 6 ? triangle : square;
        rest.resize(size);
        far::SurfaceMesh mesh{Index(size)};
        std::vector<Index> points(size);
        for (std::size_t i = 0; i < size; ++i) points[i] = Index(i);
        mesh.addFace(points);
        const ValidityCheck check(mesh, rest);
        EXPECT_THAT(check.badAtRest(), IsEmpty());
        Positions pose = rest;
        pose[size == 6 ? 3 : 4] = rest[0];
        EXPECT_THAT(check.check(pose).inverted, ElementsAre(0)) << size;
        EXPECT_NEAR(check.largestStep(pose).length, 0.5, 1e-9) << size;
    }
}

TEST(SurfacePieces, APlaneThatIsMirroredInItselfIsInverted) {
    const Grid grid = gridOf(3, 3);
    Positions mirrored = grid.points;
    for (Point3& p : mirrored) p[0] = -p[0];
    const ValidityCheck check(grid.mesh, grid.points);
    EXPECT_THAT(check.check(mirrored).inverted, SizeIs(18));
    // Turned by half a turn, it is the same plane seen from behind.
    EXPECT_THAT(check.check(turned(grid.points, std::numbers::pi)).inverted, SizeIs(18));
}

TEST(SurfacePieces, ASurfaceInSpaceMayTurnAndRollUp) {
    for (const int corners : {3, 4}) {
        const Grid grid = gridOf(8, corners);
        const Positions curved = rolled(grid.points, 3);
        const ValidityCheck ofPlane(grid.mesh, grid.points), ofRoll(grid.mesh, curved);
        for (const double angle : {1.0, 2.0, 3.0, 4.0}) {
            // Turned by about half a turn, a plane is its own mirror image.
            if (angle != 3.0) {
                EXPECT_THAT(ofPlane.check(turned(grid.points, angle)).inverted, IsEmpty());
            }
            const PoseValidity rigid = ofRoll.check(turned(curved, angle, 1));
            EXPECT_THAT(rigid.inverted, IsEmpty());
            EXPECT_NEAR(rigid.smallest->value, 1, 1e-11);
        }
        EXPECT_THAT(ofPlane.check(curved).inverted, IsEmpty());
        EXPECT_THAT(ofRoll.check(grid.points).inverted, IsEmpty());
        EXPECT_THAT(ofRoll.check(rolled(grid.points, -3)).inverted, IsEmpty());
    }
}

// A point of a rolled surface goes across its neighbour: the two faces behind it turn over.
TEST(SurfacePieces, AFaceThatTurnsOverAgainstItsNeighboursIsInverted) {
    const Grid grid = gridOf(8, 4);
    const Positions rest = rolled(grid.points, 5);
    Positions pose = grid.points;
    pose[4 + 9 * 4][0] += 1.5;
    const Positions folded = turned(rolled(pose, 5), 2);
    const ValidityCheck check(grid.mesh, rest);
    EXPECT_THAT(check.check(folded).inverted, ElementsAre(4 + 8 * 3, 4 + 8 * 4));
}

// A mesh of two dimensions that leaves its plane a little is still one: mirrored or folded in it,
// its faces have no neighbours that tell.
TEST(SurfacePieces, APlaneThatIsNearlyKeptIsAPlane) {
    const Grid grid = gridOf(20, 4);
    const ValidityCheck check(grid.mesh, grid.points);
    for (const double away : {0.0, 1e-9, 1e-4, 0.05}) {
        Positions mirrored = grid.points, folded = grid.points;
        for (std::size_t i = 0; i < mirrored.size(); ++i) {
            mirrored[i] = {-mirrored[i][0], mirrored[i][1], away * std::sin(mirrored[i][0])};
            // Five columns, from 8 to 13, go backwards.
            const double x = folded[i][0];
            folded[i][0] = x < 8 ? x : x < 13 ? 16 - x : x - 10;
            folded[i][2] = away * folded[i][1] / 20;
        }
        EXPECT_THAT(check.check(mirrored).inverted, SizeIs(400)) << away;
        EXPECT_FALSE(check.check(mirrored).comparesNeighbours);
        EXPECT_THAT(check.check(folded).inverted, SizeIs(100)) << away;
        // The plane of the pose is tilted by up to a thousandth.
        EXPECT_NEAR(check.largestStep(mirrored).length, 0.5, 1e-5) << away;
    }
}

// Where faces are compared with their neighbours, steps are what check() says, and are not proved.
TEST(SurfacePieces, StepsOfASurfaceInSpaceAreFoundByHalving) {
    const Grid grid = gridOf(8, 4);
    const Positions rest = rolled(grid.points, 3);
    const ValidityCheck check(grid.mesh, rest);
    // On the way to a turn by half a turn the sheet is a line; at the end, it is the sheet.
    const LargestStep turn = check.largestStep(turned(rest, std::numbers::pi, 1));
    EXPECT_EQ(turn.length, 1);
    EXPECT_FALSE(turn.isTight);
    int inverted = 0;
    for (unsigned seed = 0; seed < 30; ++seed) {
        const Positions pose = turned(shaken(rest, seed, 0.02 * seed), 0.02 * seed, 1);
        const PoseValidity validity = check.check(pose);
        EXPECT_TRUE(validity.comparesNeighbours);
        const LargestStep step = check.largestStep(pose);
        EXPECT_EQ(step.length == 1, validity.inverted.empty());
        EXPECT_THAT(check.check(moved(rest, pose, step.length)).inverted, IsEmpty());
        if (step.length == 1) continue;
        ++inverted;
        EXPECT_THAT(check.check(moved(rest, pose, step.length + 2e-6)).inverted, Not(IsEmpty()));
    }
    EXPECT_GT(inverted, 5);
    EXPECT_LT(inverted, 25);
    EXPECT_EQ(check.isolatedFaces(), 0);
}

TEST(SurfacePieces, FacesThatShareNoPointAreCounted) {
    far::SurfaceMesh mesh(9);
    mesh.addFace(std::vector<Index>{0, 1, 2});
    mesh.addFace(std::vector<Index>{3, 4, 5});
    mesh.addFace(std::vector<Index>{5, 7, 8});
    Positions rest = shaken(Positions(9), 3, 1);
    EXPECT_EQ(ValidityCheck(mesh, rest).isolatedFaces(), 1);
}

TEST(SurfacePieces, FlatFacesAreBadAtRest) {
    far::SurfaceMesh mesh(4);
    mesh.addFace(std::vector<Index>{0, 1, 2});
    mesh.addFace(std::vector<Index>{0, 1, 3});
    const Positions rest = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
    const ValidityCheck check(mesh, rest);
    EXPECT_THAT(check.badAtRest(), ElementsAre(0));
    EXPECT_THAT(check.check(rest).inverted, IsEmpty());
}

TEST(SurfacePieces, DoNotDependOnThreads) {
    const Grid grid = gridOf(60, 3);
    const Positions rest = rolled(grid.points, 20), pose = shaken(rest, 1, 0.6);
    const auto run = [&] {
        const ValidityCheck check(grid.mesh, rest);
        return std::pair(check.check(pose).ratios, check.largestStep(pose).length);
    };
    EXPECT_EQ(withThreads(1, run), withThreads(4, run));
}

TEST(SurfaceMesh, RefusesFacesOfOtherNumbersAndPointsThatDoNotExist) {
    far::SurfaceMesh mesh(5);
    EXPECT_REFUSED(Error, "face 0 has 5 points; expected 3, 4, 6, 8 or 9",
                   mesh.addFace(std::vector<Index>{0, 1, 2, 3, 4}));
    EXPECT_REFUSED(Error, "face 0 names point 5; there are 5",
                   mesh.addFace(std::vector<Index>{0, 1, 5}));
    EXPECT_EQ(mesh.faceCount(), 0);
}

}  // namespace
}  // namespace espalier::solve
