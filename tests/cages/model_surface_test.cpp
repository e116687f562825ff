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
    model.addFace({3, 2, 1, 0});  // the other way round
    model.addFace({2, 3, 0, 1});  // from another corner
    const ModelSurface surface(model);
    EXPECT_EQ(surface.modelPointCount(), 4u);
    // By place, the points are (0,0), (0,1), (1,0), (1,1): 0 to 3. The square is split from 0.
    EXPECT_THAT(surface.triangles(), ElementsAre(Triangle{0, 1, 3}, Triangle{0, 2, 3}));
}

TEST(ModelSurface, keepsPointsOfNoFaceAndDegenerateFaces) {
    FaceModel model;
    addSquare(model, 0);
    model.points.push_back({5, 5, 5});
    model.addFace({0, 0, 0});
    model.addFace({0, 1});
    model.addFace({2});
    model.addFace({1, 1, 3, 1});
    model.points.push_back({6, 6, 6});
    model.addFace({0, 5, 0, 0});
    const ModelSurface surface(model);
    // The square, the point of no face, the points 0 and 2, the lines 0 1, 1 3 and 0 5.
    EXPECT_EQ(surface.triangles().size(), 8u);
    // Points and lines of other faces add nothing. By place, the points of the square are 0, 2, 3
    // and 1; (5, 5, 5) is 4 and (6, 6, 6) is 5. The diagonal of the square is from 0 to 3.
    EXPECT_THAT(surface.openTriangles(),
                ElementsAre(Triangle{0, 5, 5}, Triangle{1, 2, 2}, Triangle{4, 4, 4},
                            Triangle{0, 1, 3}, Triangle{0, 2, 3}));
}

/// Every kind of piece: a cavity in a ball with a hole, a ring of quadrilaterals, a sheet, polygons
/// that are not convex or pass a point twice, three triangles at an edge, loose lines and points.
FaceModel mixedModel() {
    FaceModel ball = test::ballModel(2);
    ball.corners.resize(ball.corners.size() - 3);
    ball.ends.pop_back();
    FaceModel loose;
    loose.points = {{4, 0, 0}, {5, 0, 0.1}, {5, 1, 0}, {4.5, 0.2, 0.3}, {4, 1, 0}, {7, 7, 7}};
    loose.addFace({0, 1, 2, 3, 4});
    loose.addFace({1, 2, 3, 2, 4});
    loose.addFace({2, 3, 2, 3, 2, 4, 3});
    loose.addFace({0, 2});
    loose.addFace({1, 4});
    loose.addFace({0, 0, 1, 5});
    loose.addFace({0, 1, 4});
    loose.addFace({5, 5, 5});
    loose.points.push_back({8, 8, 8});
    return test::joined({ball, test::reversed(test::ballModel(1, {0.5, 0.5, 0.5})),
                         test::moved(test::ringModel(1, 0.3), {0, 0, 3}),
                         test::moved(test::sheetModel(), {0, 4, 0}), loose});
}

void expectSameBits(const ModelSurface& a, const ModelSurface& b) {
    EXPECT_EQ(a.points(), b.points());
    EXPECT_EQ(a.triangles(), b.triangles());
    EXPECT_EQ(a.openTriangles(), b.openTriangles());
    ASSERT_EQ(a.closedPieces().size(), b.closedPieces().size());
    for (std::size_t i = 0; i < a.closedPieces().size(); ++i) {
        const auto &p = a.closedPieces()[i], &q = b.closedPieces()[i];
        EXPECT_EQ(p.triangles, q.triangles);
        EXPECT_EQ(p.capBegin, q.capBegin);
        EXPECT_EQ(p.volume, q.volume);
        EXPECT_EQ(p.winding, q.winding);
    }
}

TEST(ModelSurface, hasTheSameBitsForAnyOrderOfTheModel) {
    const FaceModel model = mixedModel();
    const ModelSurface surface(model);
    EXPECT_GE(surface.closedPieces().size(), 3u);
    EXPECT_GT(surface.openTriangles().size(), 10u);
    for (const unsigned seed : {1u, 2u, 3u}) {
        const FaceModel other = test::inAnotherOrder(model, seed);
        expectSameBits(surface, ModelSurface(other));
        expectSameBits(surface, ModelSurface(test::reversed(other)));
    }
    // In each piece, a few faces may be turned around.
    FaceModel turned = model;
    for (std::size_t f = 0; f < turned.ends.size(); f += 3)
        std::reverse(turned.face(f).begin(), turned.face(f).end());
    expectSameBits(surface, ModelSurface(turned));
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
    EXPECT_EQ(alone.closedPieces()[0].winding, 1);
    // The volume of an inscribed polyhedron of 128 triangles is a little below the ball's 4π / 3.
    EXPECT_NEAR(alone.closedPieces()[0].volume, 3.8, 0.15);
}

TEST(ModelSurface, tellsCavitiesByTheirWinding) {
    const FaceModel hollow =
        test::joined({test::ballModel(2), test::reversed(test::ballModel(2, {0.5, 0.5, 0.5}))});
    const auto inwards = [](const ModelSurface& surface) {
        std::vector<bool> result;
        for (const auto& piece : surface.closedPieces()) result.push_back(piece.winding < 0);
        return result;
    };
    EXPECT_THAT(inwards(ModelSurface(hollow)), ::testing::UnorderedElementsAre(false, true));
    // Inside out as a whole.
    EXPECT_THAT(inwards(ModelSurface(test::reversed(hollow))),
                ::testing::UnorderedElementsAre(false, true));
    // Each face both ways: the winding tells nothing, and there is no cavity.
    const ModelSurface both(test::joined({hollow, test::reversed(hollow)}));
    for (const auto& piece : both.closedPieces()) EXPECT_EQ(piece.winding, 0);
    EXPECT_EQ(both.closedPieces().size(), 2u);
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
