// SPDX-License-Identifier: Apache-2.0
#include "cages/model_surface.h"

#include <gtest/gtest.h>

#include "face_models.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

using test::FaceModel;

/// A square in the xy-plane at height z, as a face of four new points.
void addSquare(FaceModel& model, double z) {
    const auto first = static_cast<Index>(model.points.size());
    model.points.insert(model.points.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
    model.addFace({first, first + 1, first + 2, first + 3});
}

TEST(ModelSurface, joinsPointsAndDropsDuplicates) {
    FaceModel model;
    addSquare(model, 0);
    addSquare(model, -0.0);       // −0 is 0
    model.addFace({3, 2, 1, 0});  // the other way round: split along the other diagonal
    model.addFace({0, 3, 2, 1});
    const ModelSurface surface(model);
    EXPECT_EQ(surface.modelPointCount(), 4u);
    // 2 triangles around each of the corners 0 and 3; duplicates count once.
    EXPECT_EQ(surface.triangles().size(), 4u);
}

TEST(ModelSurface, keepsPointsOfNoFaceAndDegenerateFaces) {
    FaceModel model;
    addSquare(model, 0);
    model.points.push_back({5, 5, 5});
    model.addFace({0, 0, 0});
    model.addFace({0, 1});
    model.addFace({2});
    const ModelSurface surface(model);
    EXPECT_EQ(surface.openTriangles().size(), surface.triangles().size());
    // The square, the point of no face, the two points and the edge.
    EXPECT_EQ(surface.triangles().size(), 6u);
}

TEST(ModelSurface, findsClosedPiecesAndTurnsThem) {
    FaceModel ball = test::ballModel(2);
    // Some faces are wound the wrong way.
    for (std::size_t f = 0; f < ball.ends.size(); f += 5)
        std::swap(ball.face(f)[0], ball.face(f)[1]);
    const ModelSurface surface(test::joined({ball, test::ringModel(4, 0.5)}));
    ASSERT_EQ(surface.closedPieces().size(), 2u);
    EXPECT_THAT(surface.openTriangles(), IsEmpty());
    const ModelSurface alone(ball);
    ASSERT_EQ(alone.closedPieces().size(), 1u);
    EXPECT_FALSE(alone.closedPieces()[0].isInward);
    // The volume of an inscribed polyhedron of 128 triangles is a little below the ball's 4π / 3.
    EXPECT_NEAR(alone.closedPieces()[0].volume, 3.8, 0.15);
}

TEST(ModelSurface, tellsCavitiesByTheirWinding) {
    const FaceModel hollow =
        test::joined({test::ballModel(2), test::reversed(test::ballModel(2, {0.5, 0.5, 0.5}))});
    const auto inwards = [](const ModelSurface& surface) {
        std::vector<bool> result;
        for (const auto& piece : surface.closedPieces()) result.push_back(piece.isInward);
        return result;
    };
    EXPECT_THAT(inwards(ModelSurface(hollow)), ::testing::UnorderedElementsAre(false, true));
    // Inside out as a whole.
    EXPECT_THAT(inwards(ModelSurface(test::reversed(hollow))),
                ::testing::UnorderedElementsAre(false, true));
}

TEST(ModelSurface, closesSmallHolesOnly) {
    FaceModel ball = test::ballModel(3);
    const std::size_t count = ball.ends.size();
    const auto withFaces = [&](std::size_t kept) {
        FaceModel part;
        part.points = ball.points;
        for (std::size_t f = 0; f < kept; ++f) {
            const auto face = ball.face(f);
            part.addFace({face[0], face[1], face[2]});
        }
        return part;
    };
    const ModelSurface nearly(withFaces(count - 5));
    ASSERT_EQ(nearly.closedPieces().size(), 1u);
    EXPECT_GT(nearly.closedPieces()[0].triangles.size(), nearly.closedPieces()[0].capBegin);
    EXPECT_GT(nearly.points().size(), nearly.modelPointCount());
    const ModelSurface half(withFaces(count / 2));
    EXPECT_THAT(half.closedPieces(), IsEmpty());
}

TEST(ModelSurface, namesWhatIsWrong) {
    FaceModel model;
    EXPECT_REFUSED(Error, "no faces", ModelSurface{model});
    addSquare(model, 0);
    FaceModel wrong = model;
    wrong.corners[2] = 9;
    EXPECT_REFUSED(Error, "a face names point 9; expected 0 to 3", ModelSurface{wrong});
    wrong = model;
    wrong.ends[0] = 7;
    EXPECT_REFUSED(Error, "face 0 ends at corner 7; expected 0 to 4", ModelSurface{wrong});
    wrong = model;
    wrong.points[1][2] = kNan;
    EXPECT_REFUSED(Error, "point 1 is not finite", ModelSurface{wrong});
    wrong.points[1][2] = 1e100;
    EXPECT_REFUSED(Error, "point 1 is too far from the origin", ModelSurface{wrong});
}

}  // namespace
}  // namespace espalier::cages
