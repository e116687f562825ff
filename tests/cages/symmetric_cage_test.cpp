// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/cages/cage.h>
#include <espalier/far/topology_match.h>
#include <espalier/solve/design_variables.h>
#include <gtest/gtest.h>

#include <set>

#include "cages/symmetry.h"
#include "face_models.h"
#include "lattice_measures.h"
#include "soup_models.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::cages {
namespace {

using test::FaceModel;

/// Expects that a lattice is exactly symmetric: vertices and cells have mirror images.
void expectSymmetric(const Lattice& lattice, int axis, double at) {
    SCOPED_TRACE(testing::Message() << "axis " << axis << ", plane " << at);
    std::map<Point3, Index> numbers;
    for (std::size_t i = 0; i < lattice.positions.size(); ++i)
        numbers[sum(lattice.positions[i], {0, 0, 0})] = static_cast<Index>(i);
    // All vertices are at places of their own.
    ASSERT_EQ(numbers.size(), lattice.positions.size());
    std::vector<Index> images;
    for (const Point3& position : lattice.positions) {
        Point3 image = position;
        // Exact by Sterbenz or by the choice of the coordinates: no tolerance.
        image[axis] = 2 * at - image[axis];
        const auto found = numbers.find(sum(image, {0, 0, 0}));
        ASSERT_TRUE(found != numbers.end()) << testing::PrintToString(position);
        images.push_back(found->second);
    }
    std::set<std::vector<Index>> cells;
    const auto& corners = lattice.complex.relation(3, 0);
    const auto cellOf = [&](Index cell, bool isImage) {
        std::vector<Index> vertices;
        for (const Index vertex : corners[cell])
            vertices.push_back(isImage ? images[vertex] : vertex);
        std::ranges::sort(vertices);
        return vertices;
    };
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell) cells.insert(cellOf(cell, false));
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
        EXPECT_TRUE(cells.contains(cellOf(cell, true))) << cell;
    // The variables of a design accept the mirror.
    solve::DesignVariables design(lattice.complex.count(0));
    design.mirror(lattice.positions, axis, at, 0);
}

/// Makes a cage and expects all that cages promise.
Lattice cageOf(const FaceModel& model, Index vertices, ModelSymmetry& symmetry,
               CageOptions options = {}) {
    options.vertices = vertices;
    Lattice made = cage(model, options, &symmetry);
    EXPECT_GE(made.complex.count(0), 0.8 * vertices);
    EXPECT_LE(made.complex.count(0), 1.2 * vertices);
    std::vector<Point3> places;
    const std::size_t step = std::max<std::size_t>(1, model.points.size() / 400);
    for (std::size_t i = 0; i < model.points.size(); i += step) places.push_back(model.points[i]);
    EXPECT_EQ(test::outsideLevel(made, places), 0);
    EXPECT_EQ(test::outsideLimit(made, places), 0);
    EXPECT_THAT(test::badCells(made), IsEmpty());
    EXPECT_TRUE(test::topologyOf(made.complex).isManifold);
    return made;
}

std::array<bool, 3> usedPlanes(const ModelSymmetry& symmetry) {
    return {symmetry.planes[0].isUsed, symmetry.planes[1].isUsed, symmetry.planes[2].isUsed};
}

/// A figure that is symmetric about x = 0 only: its legs point forwards, its head is high.
FaceModel walker() {
    return test::joined({test::ballModel(3, {0.45, 0.3, 0.7}),
                         test::ballModel(3, {0.3, 0.28, 0.32}, {0, 0.1, 0.95}),
                         test::ballModel(2, {0.55, 0.14, 0.14}, {0.75, 0, 0.35}),
                         test::ballModel(2, {0.55, 0.14, 0.14}, {-0.75, 0, 0.35}),
                         test::ballModel(2, {0.16, 0.3, 0.6}, {0.3, 0.15, -1}),
                         test::ballModel(2, {0.16, 0.3, 0.6}, {-0.3, 0.15, -1})});
}

TEST(SymmetricCage, isSymmetricAboutThePlaneOfTheModel) {
    for (const double at : {0.0, 0.3, -1234.7})
        for (const Index vertices : {40, 120}) {
            const FaceModel model = test::moved(walker(), {at, 0.1, 0});
            ModelSymmetry symmetry;
            const Lattice made = cageOf(model, vertices, symmetry);
            EXPECT_EQ(usedPlanes(symmetry), (std::array{true, false, false}));
            // The middle of the box, which is rounded.
            EXPECT_NEAR(symmetry.planes[0].at, at, 1e-12 * (1 + std::abs(at)));
            EXPECT_LE(symmetry.planes[0].off, 1e-12);
            EXPECT_GT(symmetry.planes[1].off, 0.01);
            expectSymmetric(made, 0, symmetry.planes[0].at);
        }
}

TEST(SymmetricCage, isSymmetricAboutSeveralPlanes) {
    // A ring has three, a bottle of two bodies two.
    const FaceModel bottle = test::joined(
        {test::ballModel(3, {0.5, 0.5, 0.9}), test::ballModel(3, {0.15, 0.15, 0.6}, {0, 0, 1.1})});
    ModelSymmetry symmetry;
    const Lattice ofBottle = cageOf(bottle, 100, symmetry);
    EXPECT_EQ(usedPlanes(symmetry), (std::array{true, true, false}));
    expectSymmetric(ofBottle, 0, symmetry.planes[0].at);
    expectSymmetric(ofBottle, 1, symmetry.planes[1].at);
    const FaceModel ring = test::ringModel(1, 0.35);
    const Lattice ofRing = cageOf(ring, 120, symmetry);
    EXPECT_EQ(usedPlanes(symmetry), (std::array{true, true, true}));
    for (int axis = 0; axis < 3; ++axis) expectSymmetric(ofRing, axis, symmetry.planes[axis].at);
    EXPECT_EQ(test::topologyOf(ofRing.complex), (test::SolidTopology{1, 1, 0}));
}

/// Returns a model turned about the x axis.
FaceModel turned(FaceModel model, double angle) {
    for (Point3& p : model.points)
        p = {p[0], std::cos(angle) * p[1] - std::sin(angle) * p[2],
             std::sin(angle) * p[1] + std::cos(angle) * p[2]};
    return model;
}

TEST(SymmetricCage, isSymmetricForAModelTurnedAboutTheNormalOfThePlane) {
    for (const double angle : {0.4, 1.1, 2.5}) {
        ModelSymmetry symmetry;
        const Lattice made = cageOf(turned(walker(), angle), 100, symmetry);
        EXPECT_EQ(usedPlanes(symmetry), (std::array{true, false, false}));
        expectSymmetric(made, 0, 0);
    }
}

/// Returns the fraction of the edges of a lattice that are within about 14 degrees of the x axis,
/// or of the y or z axis turned by an angle about x.
double edgesAlong(const Lattice& lattice, double angle) {
    const std::array<Point3, 3> axes = {
        {{1, 0, 0}, {0, std::cos(angle), std::sin(angle)}, {0, -std::sin(angle), std::cos(angle)}}};
    Index along = 0;
    const auto& ends = lattice.complex.relation(1, 0);
    for (Index edge = 0; edge < lattice.complex.count(1); ++edge) {
        const Point3 way = normalised(
            difference(lattice.positions[ends[edge][1]], lattice.positions[ends[edge][0]]));
        for (const Point3& axis : axes)
            if (std::abs(dot(axis, way)) > 0.97) ++along;
    }
    return static_cast<double>(along) / lattice.complex.count(1);
}

TEST(SymmetricCage, turnsTheGridAboutTheNormalOfThePlane) {
    // A bar with a wedge at one end is symmetric about x only.
    FaceModel bar;
    for (unsigned corner = 0; corner < 8; ++corner)
        bar.points.push_back({corner & 1 ? 0.5 : -0.5, (corner >> 1 & 1) ? 0.5 : -0.5,
                              corner >> 2 & 1 ? (corner >> 1 & 1 ? 2.5 : 2.0) : -2.0});
    for (const auto& f : {std::array<Index, 4>{0, 2, 3, 1},
                          {4, 5, 7, 6},
                          {0, 1, 5, 4},
                          {2, 6, 7, 3},
                          {0, 4, 6, 2},
                          {1, 3, 7, 5}})
        bar.addFace({f[0], f[1], f[2], f[3]});
    for (const double angle : {0.6, 2.4}) {
        ModelSymmetry symmetry;
        const Lattice made = cageOf(turned(bar, angle), 100, symmetry);
        EXPECT_EQ(usedPlanes(symmetry), (std::array{true, false, false}));
        expectSymmetric(made, 0, 0);
        // The grid follows the bar: without the turn, its edges are along y and z.
        EXPECT_GT(edgesAlong(made, angle), 0.7);
        EXPECT_LT(edgesAlong(made, 0), 0.5);
    }
}

TEST(SymmetricCage, takesPartsOnBothSidesAndAcrossThePlane) {
    // A pair of balls, no part of which touches the plane; and with a third one in the middle.
    const FaceModel pair = test::joined({test::ballModel(3, {0.5, 0.6, 0.7}, {1.5, 0, 0}),
                                         test::ballModel(3, {0.5, 0.6, 0.7}, {-1.5, 0, 0})});
    ModelSymmetry symmetry;
    const Lattice two = cageOf(pair, 100, symmetry);
    expectSymmetric(two, 0, 0);
    EXPECT_EQ(test::topologyOf(two.complex), (test::SolidTopology{2, 0, 0}));
    const Lattice three =
        cageOf(test::joined({pair, test::ballModel(2, {0.3, 0.3, 0.3})}), 120, symmetry);
    expectSymmetric(three, 0, 0);
    // Two that are near each other stay apart on request.
    const FaceModel near = test::joined({test::ballModel(3, {1, 0.8, 0.9}, {1.05, 0, 0}),
                                         test::ballModel(3, {1, 0.8, 0.9}, {-1.05, 0, 0})});
    const Lattice apart = cageOf(near, 60, symmetry, {.keepApart = true});
    EXPECT_TRUE(symmetry.planes[0].isUsed);
    expectSymmetric(apart, 0, 0);
    EXPECT_EQ(test::topologyOf(apart.complex), (test::SolidTopology{2, 0, 0}));
}

/// A model with one point that is moved.
FaceModel perturbed(double way) {
    FaceModel model = walker();
    Point3 moved = model.points.front();
    for (Point3& point : model.points)
        if (point == moved) point[1] += way;
    return model;
}

TEST(SymmetricCage, takesModelsThatAreNearlySymmetricWithinTheTolerance) {
    // The diagonal is about 4.1.
    ModelSymmetry symmetry;
    const Lattice nearly = cageOf(perturbed(1e-4), 60, symmetry);
    expectSymmetric(nearly, 0, 0);
    EXPECT_NEAR(symmetry.planes[0].off, 1e-4 / 4.1, 1e-5);
    EXPECT_THAT(symmetryText(symmetry), testing::StartsWith("symmetric about x = 0 within 3e-5 "));
    const FaceModel model = perturbed(0.02);
    cageOf(model, 60, symmetry);
    EXPECT_EQ(usedPlanes(symmetry), (std::array{false, false, false}));
    EXPECT_THAT(symmetryText(symmetry),
                testing::StartsWith("not symmetric; off by 0.5 % about x, "));
    const Lattice within = cageOf(model, 60, symmetry, {.symmetry = 0.01});
    expectSymmetric(within, 0, 0);
}

TEST(SymmetricCage, obeysGivenPlanes) {
    ModelSymmetry symmetry;
    const Lattice none = cageOf(walker(), 60, symmetry, {.symmetric = Symmetric::None});
    EXPECT_EQ(symmetryText(symmetry), "");
    EXPECT_FALSE(symmetry.isMeasured);
    // The cage holds the mirror image of the model, too.
    FaceModel model = walker();
    const Lattice given = cageOf(model, 80, symmetry, {.symmetric = Symmetric::Y});
    EXPECT_EQ(usedPlanes(symmetry), (std::array{false, true, false}));
    const double at = symmetry.planes[1].at;
    expectSymmetric(given, 1, at);
    for (Point3& point : model.points) point[1] = 2 * at - point[1];
    EXPECT_EQ(test::outsideLimit(given, model.points), 0);
    EXPECT_THAT(symmetryText(symmetry), HasSubstr("(the model is off by "));
    EXPECT_THAT(symmetryText(symmetry), HasSubstr("the model is symmetric about x = 0, too"));
}

/// Returns triangles, of three corners each, with their mirror images across the first axes.
FaceModel mirroredTriangles(const std::vector<Point3>& corners, std::size_t axes) {
    FaceModel model = test::trianglesModel(static_cast<int>(corners.size() / 3), [&](int t, int i) {
        return corners[static_cast<std::size_t>(3 * t + i)];
    });
    for (std::size_t axis = 0; axis < axes; ++axis) {
        FaceModel image = model;
        for (Point3& point : image.points) point[axis] = -point[axis];
        model = test::joined({model, image});
    }
    return model;
}

TEST(SymmetricCage, triesFewerPlanesIfNoLatticeCanBeFitted) {
    // Small triangles far from each other. Random ones, for which these planes are lost, were
    // searched for.
    const std::vector<Point3> four = {
        {0.335, 0.4869, 0.2184}, {0.3155, 0.4896, 0.2152}, {0.3121, 0.4772, 0.2239}};
    const std::vector<Point3> other = {
        {0.6288, 0.9611, 0.4088}, {0.6122, 0.9649, 0.4202}, {0.633, 0.9725, 0.4441}};
    const std::vector<Point3> two = {{0.8281, 0.604, 0.7386},  {0.8023, 0.6061, 0.7552},
                                     {0.8211, 0.5953, 0.7227}, {0.5505, 0.0473, 0.3164},
                                     {0.5547, 0.0516, 0.326},  {0.5206, 0.0376, 0.3209}};
    struct Case {
        const std::vector<Point3>& corners;
        std::size_t axes;
        Index vertices;
        std::array<bool, 3> used;
        const char* text;
    };
    for (const auto& [corners, axes, vertices, used, text] :
         {Case{two, 3, 28, {true, false, false}, "y = 0, z = 0, too"},
          Case{four, 2, 49, {false, true, false}, "x = 0, too"},  // x is tried first, in vain
          Case{other, 2, 49, {false, false, false}, "x = 0, y = 0, too"}}) {
        SCOPED_TRACE(text);
        const FaceModel model = mirroredTriangles(corners, axes);
        ModelSymmetry symmetry;
        const Lattice made = cageOf(model, vertices, symmetry);
        EXPECT_EQ(usedPlanes(symmetry), used);
        EXPECT_THAT(symmetryText(symmetry), HasSubstr(text));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(symmetry.planes[axis].isOfModel, axis < axes);
            if (used[axis]) expectSymmetric(made, static_cast<int>(axis), 0);
        }
    }
    // Given planes are not left out, and all choices of cells are tried.
    ModelSymmetry symmetry;
    const Lattice given =
        cageOf(mirroredTriangles(other, 2), 49, symmetry, {.symmetric = Symmetric::XY});
    EXPECT_EQ(usedPlanes(symmetry), (std::array{true, true, false}));
    expectSymmetric(given, 0, 0);
    expectSymmetric(given, 1, 0);
}

TEST(SymmetricCage, refusesGivenPlanesThatCannotBeFitted) {
    // With y alone, there is a lattice.
    const FaceModel model = mirroredTriangles({{0.5019, 0.4958, 0.1338},
                                               {0.1421, 0.2186, 0.4185},
                                               {0.2481, 0.0841, 0.3455},
                                               {0.1668, 0.8786, 0.951},
                                               {0.0387, 0.6991, 0.5728},
                                               {0.898, 0.6669, 0.5478}},
                                              2);
    ModelSymmetry symmetry;
    expectSymmetric(cageOf(model, 28, symmetry, {.keepApart = true, .symmetric = Symmetric::Y}), 1,
                    0);
    EXPECT_REFUSED(Error, "or without symmetry",
                   cage(model, {.vertices = 28, .keepApart = true, .symmetric = Symmetric::XY}));
}

TEST(SymmetricCage, looksAtFacesToo) {
    // A box without its lid: the points are symmetric about z, the faces are not.
    FaceModel crate;
    for (unsigned corner = 0; corner < 8; ++corner)
        crate.points.push_back(
            {3.0 * (corner & 1), 2.0 * (corner >> 1 & 1), corner >> 2 & 1 ? 2.5 : 0});
    for (const auto& f :
         {std::array<Index, 4>{0, 2, 3, 1}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
        crate.addFace({f[0], f[1], f[2], f[3]});
    const auto planes = measureSymmetry(ModelSurface(crate), 1e-4);
    EXPECT_EQ(planes[0].off, 0);
    EXPECT_EQ(planes[1].off, 0);
    EXPECT_GT(planes[2].off, 0.05);
    EXPECT_TRUE(planes[0].isOfModel && planes[1].isOfModel && !planes[2].isOfModel);
}

TEST(SymmetricCage, hasTheSameBitsForAnyOrderOfTheFacesAndThreads) {
    FaceModel model = walker();
    for (Point3& point : model.points) point[0] += 0.3;  // The plane is not at 0.
    const auto make = [](const FaceModel& faces) { return cage(faces, {.vertices = 80}); };
    const Lattice a = test::withThreads(1, [&] { return make(model); });
    const Lattice b =
        test::withThreads(4, [&] { return make(test::reversed(test::inAnotherOrder(model, 3))); });
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_TRUE(far::topologyDifference(a.complex, b.complex) == std::nullopt);
}

TEST(SymmetricCage, holdsFlatModels) {
    FaceModel square;
    square.points = {{0, 0, 0.25}, {2, 0, 0.25}, {2, 1, 0.25}, {0, 1, 0.25}};
    square.addFace({0, 1, 2, 3});
    ModelSymmetry symmetry;
    const Lattice made = cageOf(square, 60, symmetry);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_TRUE(symmetry.planes[axis].isUsed);
        expectSymmetric(made, axis, symmetry.planes[axis].at);
    }
}

TEST(ModelSymmetry, movesVerticesByRounding) {
    // Two vertices that are images of each other, and one on the plane.
    for (const double at : {0.0, 0.1, 1e6 / 3}) {
        const double unit = unitOfMirror(at, 2);
        const double plane = unit > 0 ? std::round(at / unit) * unit : at;
        std::vector<Point3> positions = {{at + 0.7, 1, 2}, {at - 0.7, 1, 2}, {at, 3, 4}};
        const std::vector<VertexMirror> mirrors = {{0, plane, unit, {1, 0, 2}}};
        makeSymmetric(mirrors, positions);
        EXPECT_EQ(positions[0][0] - plane, plane - positions[1][0]);
        EXPECT_EQ(positions[2][0], plane);
        EXPECT_NEAR(positions[0][0], at + 0.7, 1e-13 * (1 + at));
        std::vector<Point3> gradient = {{1, 2, 3}, {5, 6, 7}, {1, 1, 1}};
        makeGradientSymmetric(mirrors, gradient);
        EXPECT_EQ(gradient, (std::vector<Point3>{{-2, 4, 5}, {2, 4, 5}, {0, 1, 1}}));
    }
}

}  // namespace
}  // namespace espalier::cages
