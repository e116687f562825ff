// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/solve/constraint_patches.h>

#include <cmath>

#include "poses.h"
#include "support/test.h"

namespace espalier::solve {
namespace {

far::MeshPatch patchOf(const std::string& name, const std::string& type,
                       const std::vector<std::vector<Index>>& faces,
                       const std::string& partner = {}) {
    far::MeshPatch patch{name, type};
    patch.partner = partner;
    for (const auto& face : faces) {
        patch.points.insert(patch.points.end(), face.begin(), face.end());
        patch.faces.values.insert(patch.faces.values.end(), face.begin(), face.end());
        patch.faces.offsets.push_back(Offset(patch.faces.values.size()));
    }
    patch.dimension = 2;
    std::ranges::sort(patch.points);
    const auto twice = std::ranges::unique(patch.points);
    patch.points.erase(twice.begin(), twice.end());
    return patch;
}

/// The corners of a cube of side 1: corner i + 2j + 4k is at (i, j, k).
Positions cubeCorners() {
    Positions points;
    for (int i = 0; i < 8; ++i)
        points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
    return points;
}

const std::vector<Index> kBottom = {0, 2, 3, 1}, kTop = {4, 5, 7, 6};

TEST(ConstraintPatches, TypesAndNamesHaveConstraints) {
    const std::vector<std::vector<Index>> faces = {kBottom};
    EXPECT_EQ(constraintOf(patchOf("a", "symmetryPlane", faces)), Constraint::Plane);
    EXPECT_EQ(constraintOf(patchOf("a", "wedge", faces)), Constraint::Plane);
    EXPECT_EQ(constraintOf(patchOf("a", "empty", faces)), Constraint::Sides);
    EXPECT_EQ(constraintOf(patchOf("a", "cyclic", faces, "b")), Constraint::Periodic);
    EXPECT_EQ(constraintOf(patchOf("a", "periodic", faces, "b")), Constraint::Periodic);
    EXPECT_EQ(constraintOf(patchOf("a", "shadow", faces, "b")), Constraint::Periodic);
    EXPECT_EQ(constraintOf(patchOf("a", "periodic", faces)), std::nullopt);
    EXPECT_EQ(constraintOf(patchOf("a", "wall", faces)), std::nullopt);
    EXPECT_EQ(constraintOf(patchOf("Symmetry", "patch", faces)), std::nullopt);
    // Formats without types: by the name.
    EXPECT_EQ(constraintOf(patchOf("y_SYMMETRY", "", faces)), Constraint::Plane);
    EXPECT_EQ(constraintOf(patchOf("asymptote", "", faces)), std::nullopt);
    far::MeshPatch cells = patchOf("symmetry", "", {});
    cells.dimension = 3;
    EXPECT_EQ(constraintOf(cells), std::nullopt);
}

// The diagonal of the cube is √3, so the tolerance is 1.7e-10.
TEST(ConstraintPatches, PlanesMayStretchInThemselvesOnly) {
    const std::vector<far::MeshPatch> patches = {patchOf("sym", "symmetryPlane", {kBottom}),
                                                 patchOf("wall", "wall", {kTop})};
    const ConstraintPatches check(patches, cubeCorners());
    EXPECT_THAT(check.brokenAtRest(), IsEmpty());
    Positions pose = cubeCorners();
    pose[3] = {2, 3, 0};
    pose[7] = {1, 1, 5};
    auto deviations = check.check(pose);
    ASSERT_EQ(deviations.size(), 1u);
    EXPECT_FALSE(deviations[0].isBroken);
    pose[3][2] = 1e-10;
    EXPECT_FALSE(check.check(pose)[0].isBroken);
    pose[3][2] = -0.25;
    deviations = check.check(pose);
    EXPECT_TRUE(deviations[0].isBroken);
    EXPECT_EQ(deviations[0].patch, 0u);
    EXPECT_EQ(deviations[0].point, 3);
    EXPECT_NEAR(deviations[0].distance, 0.25, 1e-15);
    // The whole plane must stay where it is.
    pose = cubeCorners();
    for (const Index point : kBottom) pose[point][2] -= 1;
    EXPECT_NEAR(check.check(pose)[0].distance, 1, 1e-15);
}

TEST(ConstraintPatches, OppositePointsOfTheSidesStayOpposite) {
    const std::vector<far::MeshPatch> patches = {patchOf("frontAndBack", "empty", {kBottom, kTop})};
    const ConstraintPatches check(patches, cubeCorners());
    EXPECT_THAT(check.brokenAtRest(), IsEmpty());
    Positions pose = cubeCorners();
    for (const Index point : {3, 7}) pose[point][0] += 0.5;
    EXPECT_FALSE(check.check(pose)[0].isBroken);
    pose[7][0] += 0.125;  // Within its plane, and no longer opposite.
    EXPECT_TRUE(check.check(pose)[0].isBroken);
    EXPECT_NEAR(check.check(pose)[0].distance, 0.125, 1e-15);
    pose = cubeCorners();
    pose[6][2] = 1.5;  // Out of its plane.
    EXPECT_NEAR(check.check(pose)[0].distance, 0.5, 1e-15);
    EXPECT_EQ(check.check(pose)[0].point, 6);
}

// The two sides may be two patches.
TEST(ConstraintPatches, OppositePointsOfTwoPatchesStayOpposite) {
    const std::vector<far::MeshPatch> patches = {patchOf("front", "empty", {kTop}),
                                                 patchOf("back", "empty", {kBottom}),
                                                 patchOf("wall", "wall", {{0, 1, 5, 4}})};
    const ConstraintPatches check(patches, cubeCorners());
    EXPECT_THAT(check.brokenAtRest(), IsEmpty());
    Positions pose = cubeCorners();
    pose[7][0] += 0.25;
    ASSERT_EQ(check.check(pose).size(), 2u);
    for (const PatchDeviation& deviation : check.check(pose)) {
        EXPECT_TRUE(deviation.isBroken);
        EXPECT_TRUE(deviation.isFromImage);
        EXPECT_NEAR(deviation.distance, 0.25, 1e-15);
    }
}

// The faces of a boundary layer are small: their own normals say little about the plane.
TEST(ConstraintPatches, PlanesAreThoseOfAllFaces) {
    Positions rest;
    std::vector<std::vector<Index>> faces;
    double y = 0, step = 1e-5;
    for (Index row = 0; row < 40; ++row, y += step, step *= 1.3)
        for (const double x : {0.0, 1.0}) {
            // A plane at 5 degrees, written with 6 digits.
            const double z = std::round(std::tan(0.0873) * y * 1e6) / 1e6;
            rest.push_back({x, y, z});
        }
    for (Index row = 0; row + 1 < 40; ++row)
        faces.push_back({2 * row, 2 * row + 1, 2 * row + 3, 2 * row + 2});
    const std::vector<far::MeshPatch> patches = {patchOf("side", "symmetry", faces)};
    EXPECT_THAT(ConstraintPatches(patches, rest).brokenAtRest(), IsEmpty());
}

// Far from the origin, coordinates are rounded by more than 1e-10 of the size.
TEST(ConstraintPatches, RoundingIsAllowedFor) {
    Positions rest = cubeCorners();
    rest.resize(4);
    const auto inPlane = [](double x, double y) {
        return Point3{1e7 + x, y, 0.3 * (1e7 + x) - 0.7 * y};
    };
    for (const Index point : kBottom) rest[point] = inPlane(rest[point][0], rest[point][1]);
    const std::vector<far::MeshPatch> patches = {patchOf("side", "symmetry", {kBottom})};
    const ConstraintPatches check(patches, rest);
    Positions pose = rest;
    pose[3] = inPlane(1.7, 0.9);
    EXPECT_FALSE(check.check(pose)[0].isBroken) << check.check(pose)[0].distance;
    pose[3][2] += 1e-6;
    EXPECT_TRUE(check.check(pose)[0].isBroken);
}

// The symmetry line of a mesh of two dimensions.
TEST(ConstraintPatches, LinesOfAPlaneMeshStayLines) {
    const Positions rest = {{0, 0, 0}, {1, 0.5, 0}, {2, 1, 0}, {0, 2, 0}, {2, 0, 0}};
    far::MeshPatch line{"symmetry"};
    line.dimension = 1;
    line.points = {0, 1, 2};
    const ConstraintPatches check(std::span(&line, 1), rest);
    ASSERT_THAT(check.brokenAtRest(), IsEmpty());
    Positions pose = rest;
    pose[1] = {1.5, 0.75, 0};
    EXPECT_FALSE(check.check(pose)[0].isBroken);
    pose[1] = {1, 0.6, 0};
    // The distance from the line: 0.1 times the cosine of its slope, 1/2.
    EXPECT_NEAR(check.check(pose)[0].distance, 0.1 * std::cos(std::atan(0.5)), 1e-14);
    EXPECT_TRUE(check.check(pose)[0].isBroken);
    // A mesh in space has no such plane.
    Positions bent = rest;
    bent[3][2] = 1;
    EXPECT_THAT(ConstraintPatches(std::span(&line, 1), bent).brokenAtRest(), ElementsAre(0u));
}

// Abaqus has sets of nodes.
TEST(ConstraintPatches, SetsOfPointsStayInTheirPlane) {
    far::MeshPatch set{"XSYMM"};
    set.points = {0, 2, 4, 6};
    const ConstraintPatches check(std::span(&set, 1), cubeCorners());
    ASSERT_THAT(check.brokenAtRest(), IsEmpty());
    Positions pose = cubeCorners();
    pose[2] = {0, 5, 0.5};
    EXPECT_FALSE(check.check(pose)[0].isBroken);
    pose[2] = {0.25, 1, 0};
    EXPECT_NEAR(check.check(pose)[0].distance, 0.25, 1e-14);
    // Points on a line are in many planes, and those of a cube in none.
    for (const std::vector<Index>& points :
         {std::vector<Index>{0, 2}, std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 7}}) {
        set.points = points;
        EXPECT_THAT(ConstraintPatches(std::span(&set, 1), cubeCorners()).brokenAtRest(),
                    ElementsAre(0u));
    }
}

// Periodic by a shift, and by a turn: the second patch is the image of the first one, whose faces
// go around in the other direction.
TEST(ConstraintPatches, PeriodicPatchesStayImages) {
    const auto image = [](const std::vector<Index>& face) {
        std::vector<Index> result = {face[0]};
        result.insert(result.end(), face.rbegin(), face.rend() - 1);
        for (Index& point : result) point += 4;
        return result;
    };
    for (const double angle : {0.0, 0.5, 3.0}) {
        const auto motion = [angle](const Point3& p) {
            return Point3{std::cos(angle) * p[0] - std::sin(angle) * p[2], p[1],
                          std::sin(angle) * p[0] + std::cos(angle) * p[2] + (angle == 0 ? 2 : 0)};
        };
        // A patch that is not plane, of two triangles.
        Positions rest = {{1, 0, 0}, {2, 0, 0}, {2, 1, 0.25}, {1, 1, 0}};
        for (int i = 0; i < 4; ++i) rest.push_back(motion(rest[std::size_t(i)]));
        const std::vector<std::vector<Index>> faces = {{0, 1, 2}, {0, 2, 3}};
        const std::vector<far::MeshPatch> patches = {
            patchOf("a", "cyclic", faces, "b"),
            patchOf("b", "cyclic", {image(faces[0]), image(faces[1])}, "a")};
        const ConstraintPatches check(patches, rest);
        EXPECT_THAT(check.brokenAtRest(), IsEmpty()) << angle;
        Positions pose = rest;
        pose[2] = {2.5, 0.75, 0.5};
        pose[6] = motion(pose[2]);
        for (const PatchDeviation& deviation : check.check(pose)) {
            EXPECT_FALSE(deviation.isBroken) << angle << " " << deviation.distance;
        }
        // Only OpenFOAM has numbers of faces.
        EXPECT_THAT(check.coupledFaces(patches), IsEmpty());
        std::vector<far::MeshPatch> numbered = patches;
        numbered[0].firstFace = 10;
        numbered[1].firstFace = 20;
        const auto coupled = ConstraintPatches(numbered, rest).coupledFaces(numbered);
        ASSERT_EQ(coupled.size(), 4u);
        EXPECT_EQ(coupled[1].face, 11);
        EXPECT_EQ(coupled[1].image, 21);
        EXPECT_EQ(coupled[2].face, 20);
        EXPECT_EQ(coupled[2].image, 10);
        // The rotation of face 11 turns vectors at face 21 back.
        const Point3 vector = difference(rest[5], rest[4]), back = difference(rest[1], rest[0]);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(dot(coupled[1].rotation[c], vector), back[c], 1e-14);
        for (far::MeshPatch& patch : numbered) patch.type = "cyclicAMI";
        EXPECT_THAT(ConstraintPatches(numbered, rest).coupledFaces(numbered), IsEmpty());
        pose[6][1] += 1e-6;
        ASSERT_EQ(check.check(pose).size(), 2u);
        for (const PatchDeviation& deviation : check.check(pose)) {
            EXPECT_TRUE(deviation.isBroken);
            EXPECT_NEAR(deviation.distance, 1e-6, 1e-12);
        }
    }
}

// The images may be given point by point; and the lines of a plane mesh are periodic, too.
TEST(ConstraintPatches, PeriodicLinesStayImages) {
    for (const double angle : {0.0, 0.5, 3.0}) {
        const auto motion = [angle](const Point3& p) {
            return Point3{std::cos(angle) * p[0] - std::sin(angle) * p[1] + (angle == 0 ? 2 : 0),
                          std::sin(angle) * p[0] + std::cos(angle) * p[1], p[2]};
        };
        Positions rest = {{1, 0, 0.5}, {2, 0, 0.5}, {3, 0, 0.5}};
        for (int i = 0; i < 3; ++i) rest.push_back(motion(rest[std::size_t(i)]));
        rest.push_back({1, 2, 0.5});
        std::vector<far::MeshPatch> patches = {{"a"}, {"b"}};
        for (Index point = 0; point < 3; ++point) {
            patches[0].points.push_back(point);
            patches[1].points.push_back(point + 3);
            patches[0].images.push_back({point, point + 3});
            patches[1].images.push_back({point + 3, point});
        }
        for (far::MeshPatch& patch : patches) patch.dimension = 1;
        patches[0].partner = "b";
        patches[1].partner = "a";
        EXPECT_EQ(constraintOf(patches[0]), Constraint::Periodic);
        const ConstraintPatches check(patches, rest);
        ASSERT_THAT(check.brokenAtRest(), IsEmpty()) << angle;
        // Across the line, where a turn around it could not be told.
        Positions pose = rest;
        pose[1] = {2, 0.25, 0.5};
        pose[4] = motion(pose[1]);
        for (const PatchDeviation& deviation : check.check(pose))
            EXPECT_FALSE(deviation.isBroken) << angle << " " << deviation.distance;
        pose[4] = motion({2, -0.25, 0.5});
        ASSERT_EQ(check.check(pose).size(), 2u);
        for (const PatchDeviation& deviation : check.check(pose)) {
            EXPECT_TRUE(deviation.isBroken);
            EXPECT_NEAR(deviation.distance, 0.5, 1e-12);
        }
    }
}

// CGNS gives points without faces, and a family may have the planes on both sides of a mesh.
TEST(ConstraintPatches, PlanesOfCgns) {
    far::MeshPatch points{"bottom", "BCSymmetryPlane"};
    points.points = {0, 1, 2, 3};
    points.dimension = 2;
    far::MeshPatch corner = points;
    corner.points = {0, 1, 2, 4};
    far::MeshPatch line = points;
    line.points = {0, 1};
    const std::vector<far::MeshPatch> patches = {
        points, patchOf("both", "BCSymmetryPlane", {kBottom, kTop}), corner, line};
    EXPECT_EQ(constraintOf(points), Constraint::Plane);
    const ConstraintPatches check(patches, cubeCorners());
    EXPECT_THAT(check.brokenAtRest(), ElementsAre(2u, 3u));
    Positions pose = cubeCorners();
    pose[3][0] = pose[6][1] = 5;
    for (const PatchDeviation& deviation : check.check(pose)) EXPECT_FALSE(deviation.isBroken);
    pose[7][2] = 1.25;
    ASSERT_EQ(check.check(pose).size(), 2u);
    EXPECT_FALSE(check.check(pose)[0].isBroken);
    EXPECT_NEAR(check.check(pose)[1].distance, 0.25, 1e-14);
    pose[3][2] = -0.5;
    EXPECT_NEAR(check.check(pose)[0].distance, 0.5, 1e-14);
}

// Two sides of a wedge about the x axis: a point may move in its plane if its mirror image does.
TEST(ConstraintPatches, WedgesStayMirrorImages) {
    const Positions rest = {{0, 1, 0.25},  {2, 1, 0.25},  {2, 2, 0.5},  {0, 2, 0.5},
                            {0, 1, -0.25}, {2, 1, -0.25}, {2, 2, -0.5}, {0, 2, -0.5}};
    const std::vector<far::MeshPatch> patches = {patchOf("front", "wedge", {{0, 1, 2, 3}}),
                                                 patchOf("back", "wedge", {{4, 7, 6, 5}})};
    const ConstraintPatches check(patches, rest);
    Positions pose = rest;
    pose[2] = {2.5, 3, 0.75};
    pose[6] = {2.5, 3, -0.75};
    for (const PatchDeviation& deviation : check.check(pose)) EXPECT_FALSE(deviation.isBroken);
    pose[6] = {2.25, 3, -0.75};
    ASSERT_EQ(check.check(pose).size(), 2u);
    for (const PatchDeviation& deviation : check.check(pose)) {
        EXPECT_TRUE(deviation.isBroken);
        EXPECT_NEAR(deviation.distance, 0.25, 1e-14);
    }
}

TEST(ConstraintPatches, BrokenAtRestIsNotChecked) {
    Positions rest = cubeCorners();
    rest[3][2] = 0.5;
    const std::vector<far::MeshPatch> patches = {
        patchOf("bent", "symmetry", {kBottom}),
        patchOf("three", "empty", {kBottom, kTop, {0, 1, 5, 4}}),
        patchOf("alone", "cyclic", {kTop}, "missing"), patchOf("good", "wedge", {kTop})};
    const ConstraintPatches check(patches, rest);
    EXPECT_THAT(check.brokenAtRest(), ElementsAre(0u, 1u, 2u));
    ASSERT_EQ(check.check(rest).size(), 1u);
    EXPECT_EQ(check.check(rest)[0].patch, 3u);
    EXPECT_REFUSED(Error, "got 7 positions for 8 points", check.check(std::span(rest).first(7)));
}

}  // namespace
}  // namespace espalier::solve
