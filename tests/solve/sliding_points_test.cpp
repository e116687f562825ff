// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/sliding_points.h>

#include <espalier/base/vector3.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "poses.h"
#include "solve/patch_pieces.h"
#include "solve/slide_fit.h"
#include "support/test.h"

namespace espalier::solve {
namespace {

using Kind = SlideShape::Kind;

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// Faces and lines, whose points get the numbers in which they were added first.
struct Builder {
    Positions points;
    far::MeshPatch patch;

    explicit Builder(const std::string& name, int dimension = 2) {
        patch.name = name;
        patch.dimension = dimension;
    }

    Index add(const Point3& point) {
        for (std::size_t i = 0; i < points.size(); ++i)
            if (length(difference(points[i], point)) < 1e-9) return static_cast<Index>(i);
        points.push_back(point);
        patch.points.push_back(static_cast<Index>(points.size() - 1));
        return patch.points.back();
    }

    /// Adds a grid of faces, or of lines if `second` is 0: place(i / first, j / second).
    template <class Place>
    void grid(int first, int second, Place place) {
        const auto at = [&](int i, int j) {
            return add(place(double(i) / first, second == 0 ? 0 : double(j) / second));
        };
        for (int i = 0; i < first; ++i) {
            if (second == 0) patch.lines.push(std::vector<Index>{at(i, 0), at(i + 1, 0)});
            for (int j = 0; j < second; ++j)
                patch.faces.push(
                    std::vector<Index>{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }

    SlidingPoints slidingPoints() const { return {std::span(&patch, 1), points}; }
};

Point3 onTube(double turn, double along) {
    return {2 + std::cos(turn), -1 + std::sin(turn), along};
}

/// The frame of an oblique cylinder: any rotation.
Point3 turned(const Point3& point) {
    const Point3 axis = normalised({1, 2, -3});
    const Point3 first = normalised(cross(axis, {0, 0, 1})), second = cross(axis, first);
    return sum(sum(scaled(first, point[0]), scaled(second, point[1])),
               sum(scaled(axis, point[2]), {10, 20, 30}));
}

Builder tube(int sides, double turn, int rows, double length,
             Point3 (*place)(const Point3&) = turned) {
    Builder builder("hull");
    builder.grid(sides, rows,
                 [&](double u, double v) { return place(onTube(u * turn, v * length)); });
    return builder;
}

Point3 same(const Point3& point) {
    return point;
}

Positions movedAtRandom(Positions points, double size, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-size, size);
    for (Point3& point : points)
        for (double& coordinate : point) coordinate += uniform(random);
    return points;
}

TEST(SlidingPoints, StayInAnObliquePlane) {
    Builder plane("symm");
    plane.grid(4, 3, [](double u, double v) { return turned({3 * u, 2 * v, 0.5}); });
    plane.points.push_back({0, 0, 0});  // a point of no patch
    const SlidingPoints sliding = plane.slidingPoints();
    EXPECT_EQ(sliding.pointCount(), 20);
    ASSERT_EQ(sliding.patches()[0].shapes.size(), 1u);
    EXPECT_EQ(sliding.patches()[0].shapes[0].kind, Kind::Plane);
    EXPECT_EQ(sliding.curvedPatch(), std::nullopt);
    const Positions pose = movedAtRandom(plane.points, 0.3, 1);
    Positions slid = pose;
    const auto correction = sliding.slide(slid);
    const Point3 normal = normalised({1, 2, -3});
    double largest = 0;
    for (std::size_t i = 0; i < 20; ++i) {
        // Coordinates are below 40; a distance is a sum of three products.
        EXPECT_NEAR(dot(difference(slid[i], plane.points[0]), normal), 0, 200 * kEps);
        // The move is along the normal, and so to the nearest place.
        const Point3 move = difference(slid[i], pose[i]);
        EXPECT_NEAR(length(cross(move, normal)), 0, 200 * kEps);
        largest = std::max(largest, length(move));
    }
    EXPECT_EQ(slid[20], pose[20]);
    EXPECT_EQ(correction.distance, largest);
    EXPECT_GT(largest, 0.1);
    ASSERT_TRUE(correction.point);
    EXPECT_EQ(length(difference(slid[*correction.point], pose[*correction.point])), largest);
}

TEST(SlidingPoints, AcrossAnAxisKeepTheCoordinateToTheBit) {
    Builder plane("symm");
    plane.grid(7, 5, [](double u, double v) { return Point3{std::sqrt(u), 0.1, v * v / 3}; });
    Positions slid = movedAtRandom(plane.points, 0.2, 2);
    plane.slidingPoints().slide(slid);
    for (const Point3& point : slid) EXPECT_EQ(point[1], 0.1);
}

TEST(SlidingPoints, ThatHaveNotMovedStay) {
    for (const Builder& builder : {tube(24, 2 * std::numbers::pi, 3, 4), tube(9, 1, 2, 0.5)}) {
        Positions slid = builder.points;
        EXPECT_EQ(builder.slidingPoints().slide(slid).distance, 0);
        EXPECT_EQ(slid, builder.points);
    }
}

// Whole cylinders and parts of them; short ones, of two rings as in a mesh of two dimensions, and
// long ones; eight sides and many.
TEST(SlidingPoints, StayOnCylinders) {
    const double full = 2 * std::numbers::pi;
    const Builder tubes[] = {tube(8, full, 1, 0.05),   tube(40, full, 1, 0.01),
                             tube(100, full, 20, 300), tube(12, 2, 4, 2),
                             tube(4, 0.5, 2, 1),       tube(10, 3, 30, 200)};
    for (const Builder& builder : tubes) {
        const SlidingPoints sliding = builder.slidingPoints();
        ASSERT_EQ(sliding.patches()[0].shapes.size(), 1u);
        const SlideShape& shape = sliding.patches()[0].shapes[0];
        ASSERT_EQ(shape.kind, Kind::Cylinder);
        EXPECT_EQ(sliding.curvedPatch(), 0u);
        EXPECT_NEAR(shape.radius, 1, 1e-9);
        // Two rings that are 0.01 apart, at coordinates of 30, determine the axis within 1e-12.
        EXPECT_NEAR(std::abs(dot(shape.direction, normalised({1, 2, -3}))), 1, 1e-9);
        const Positions pose = movedAtRandom(builder.points, 0.2, 3);
        Positions slid = pose;
        sliding.slide(slid);
        for (std::size_t i = 0; i < slid.size(); ++i) {
            // Coordinates are up to 330.
            EXPECT_NEAR(length(fromAxis(shape, slid[i])),
                        length(fromAxis(shape, builder.points[i])), 3000 * kEps);
            // The move is across the axis, and towards it or away from it.
            const Point3 move = difference(slid[i], pose[i]);
            EXPECT_NEAR(length(cross(move, fromAxis(shape, pose[i]))), 0, 3000 * kEps);
        }
    }
}

TEST(SlidingPoints, OfACylinderAlongAnAxisHaveThisAxisExactly) {
    const SlidingPoints sliding = tube(16, 2 * std::numbers::pi, 2, 1, same).slidingPoints();
    EXPECT_EQ(sliding.patches()[0].shapes[0].direction, (Point3{0, 0, 1}));
}

TEST(SlidingPoints, OfLinesStayOnLinesAndCircles) {
    Builder line("axis", 1);
    line.grid(5, 0, [](double u, double) { return turned({u * u, 2 * u * u, 0}); });
    const SlidingPoints onLine = line.slidingPoints();
    EXPECT_EQ(onLine.patches()[0].shapes[0].kind, Kind::Line);
    Positions slid = movedAtRandom(line.points, 0.2, 4);
    onLine.slide(slid);
    const Point3 direction = normalised(difference(line.points[5], line.points[0]));
    for (const Point3& point : slid)
        EXPECT_NEAR(length(cross(difference(point, line.points[0]), direction)), 0, 200 * kEps);

    Builder circle("cylinder", 1);
    circle.grid(12, 0, [](double u, double) { return onTube(2 * std::numbers::pi * u, 0.5); });
    const SlidingPoints onCircle = circle.slidingPoints();
    const SlideShape& shape = onCircle.patches()[0].shapes[0];
    EXPECT_EQ(shape.kind, Kind::Circle);
    EXPECT_EQ(onCircle.curvedPatch(), 0u);
    slid = movedAtRandom(circle.points, 0.2, 5);
    onCircle.slide(slid);
    for (const Point3& point : slid) {
        EXPECT_NEAR(length({point[0] - 2, point[1] + 1, 0}), 1, 20 * kEps);
        EXPECT_EQ(point[2], 0.5);
    }
}

// The walls of a channel: four planes, and edges in the direction of x where two of them meet. With
// an inlet, the corners stay.
TEST(SlidingPoints, OfSeveralPiecesStayOnAllOfTheirShapes) {
    Builder walls("walls");
    const auto side = [&](const Point3& from, const Point3& along) {
        walls.grid(4, 3, [&](double u, double v) {
            return sum(sum(from, scaled(along, v)), {3 * u, 0, 0});
        });
    };
    side({0, 0, 0}, {0, 1, 0});
    side({0, 1, 0}, {0, 0, 1});
    side({0, 1, 1}, {0, -1, 0});
    side({0, 0, 1}, {0, 0, -1});
    far::MeshPatch inlet{"inlet"};
    inlet.dimension = 2;
    const Index corners[] = {walls.add({0, 0, 0}), walls.add({0, 1, 0}), walls.add({0, 1, 1}),
                             walls.add({0, 0, 1})};
    inlet.faces.push(corners);
    inlet.points.assign(corners, corners + 4);
    const std::vector<far::MeshPatch> patches = {walls.patch, inlet};
    const SlidingPoints sliding(patches, walls.points);
    EXPECT_EQ(sliding.patches()[0].shapes.size(), 4u);
    EXPECT_EQ(sliding.patches()[1].shapes.size(), 1u);
    Positions slid = movedAtRandom(walls.points, 0.2, 6);
    sliding.slide(slid);
    int edges = 0;
    for (std::size_t i = 0; i < slid.size(); ++i) {
        const Point3 &rest = walls.points[i], &now = slid[i];
        const bool isOnY = rest[1] == 0 || rest[1] == 1, isOnZ = rest[2] == 0 || rest[2] == 1;
        if (isOnY) {
            EXPECT_NEAR(now[1], rest[1], 4 * kEps);
        }
        if (isOnZ) {
            EXPECT_NEAR(now[2], rest[2], 4 * kEps);
        }
        const bool isCorner = isOnY && isOnZ && rest[0] == 0;
        EXPECT_EQ(now == rest, isCorner);
        edges += isOnY && isOnZ && !isCorner ? 1 : 0;
    }
    EXPECT_EQ(edges, 16);
}

// The hull of a can with its lid: points of the rim stay on the circle. Lid and hull are two
// patches.
TEST(SlidingPoints, OfACylinderAndAPlaneStayOnTheirCircle) {
    Builder can = tube(20, 2 * std::numbers::pi, 3, 2, same);
    far::MeshPatch lid{"lid"};
    lid.dimension = 2;
    const Index top = can.add({2, -1, 2});
    can.patch.points.pop_back();
    lid.points = {top};
    for (std::size_t i = 0; i < can.points.size(); ++i)
        if (can.points[i][2] == 2 && Index(i) != top) lid.points.push_back(Index(i));
    std::ranges::sort(lid.points);
    const double step = 2 * std::numbers::pi / 20;
    for (int i = 0; i < 20; ++i)
        lid.faces.push(std::vector<Index>{top, can.add(onTube(i * step, 2)),
                                          can.add(onTube((i + 1) * step, 2))});
    const std::vector<far::MeshPatch> patches = {can.patch, lid};
    const SlidingPoints sliding(patches, can.points);
    Positions slid = movedAtRandom(can.points, 0.2, 7);
    sliding.slide(slid);
    for (std::size_t i = 0; i < slid.size(); ++i) {
        if (can.points[i][2] == 2) {
            EXPECT_NEAR(slid[i][2], 2, 4 * kEps);
        }
        if (Index(i) != top) {
            EXPECT_NEAR(length({slid[i][0] - 2, slid[i][1] + 1, 0}), 1, 20 * kEps);
        }
        EXPECT_NE(slid[i], can.points[i]);
    }
}

// A tunnel with a round roof, whose walls touch the roof: common points stay on the line of
// contact.
TEST(SlidingPoints, OfACylinderThatTouchesAPlaneStayOnTheLine) {
    Builder tunnel("tunnel");
    tunnel.grid(10, 4, [](double u, double v) { return onTube(std::numbers::pi * u, 3 * v); });
    tunnel.grid(3, 4, [](double u, double v) { return Point3{3, -1 - 2 * u, 3 * v}; });
    tunnel.grid(3, 4, [](double u, double v) { return Point3{1, -1 - 2 * u, 3 * v}; });
    // The faces turn by 9 degrees at the line of contact, so the patch is one piece.
    EXPECT_THROW(tunnel.slidingPoints(), Error);
    far::MeshPatch roof{"roof"}, walls{"walls"};
    for (std::size_t face = 0; face < tunnel.patch.faces.count(); ++face) {
        far::MeshPatch& patch = face < 40 ? roof : walls;
        patch.dimension = 2;
        patch.faces.push(tunnel.patch.faces[face]);
        for (const Index point : tunnel.patch.faces[face]) patch.points.push_back(point);
    }
    const std::vector<far::MeshPatch> patches = {roof, walls};
    const SlidingPoints sliding(patches, tunnel.points);
    Positions slid = movedAtRandom(tunnel.points, 0.2, 8);
    sliding.slide(slid);
    int common = 0;
    for (std::size_t i = 0; i < slid.size(); ++i) {
        const Point3& rest = tunnel.points[i];
        if (rest[1] > -1 + 1e-12) {
            EXPECT_NEAR(length({slid[i][0] - 2, slid[i][1] + 1, 0}), 1, 20 * kEps);
        } else {
            EXPECT_NEAR(slid[i][0], rest[0], 8 * kEps);
        }
        if (std::abs(rest[1] + 1) > 1e-12) continue;
        ++common;
        EXPECT_NEAR(slid[i][1], rest[1], 8 * kEps);
        EXPECT_NE(slid[i][2], rest[2]);
    }
    EXPECT_EQ(common, 10);
}

TEST(SlidingPoints, InTheMiddleOfEdgesSlideWithThem) {
    Builder plane("symm");
    plane.grid(3, 3, [](double u, double v) { return Point3{u, v, 0}; });
    const Index middle = plane.add({0.5 / 3, 0, 0});
    Positions slid = movedAtRandom(plane.points, 0.1, 9);
    const SlidingPoints sliding = plane.slidingPoints();
    EXPECT_EQ(sliding.pointCount(), 17);
    sliding.slide(slid);
    EXPECT_EQ(slid[middle][2], 0);
    plane.points[middle][2] = 0.01;
    EXPECT_THAT([&] { plane.slidingPoints(); },
                ThrowsMessage<Error>(HasSubstr("point 16, in the middle of an edge or a face, is "
                                               "0.01 away")));
}

// Files of six digits and of single precision are off by less than a millionth.
TEST(SlidingPoints, OfRoundedFilesAreOnTheirShapes) {
    const auto rounded = [](Builder builder, double scale) {
        for (Point3& point : builder.points)
            for (double& coordinate : point) coordinate = double(float(scale * coordinate));
        return builder;
    };
    for (const double scale : {1e-3, 1.0, 1e5}) {
        EXPECT_EQ(rounded(tube(30, 6, 3, 2), scale).slidingPoints().patches()[0].shapes[0].kind,
                  Kind::Cylinder);
        Builder plane("symm");
        plane.grid(4, 3, [](double u, double v) { return turned({3 * u, 2 * v, 0.5}); });
        EXPECT_EQ(rounded(plane, scale).slidingPoints().patches()[0].shapes[0].kind, Kind::Plane);
    }
}

TEST(SlidingPoints, OnOtherShapesAreRefusedWithTheDistance) {
    Builder ball("ball");
    ball.grid(8, 8, [](double u, double v) {
        return Point3{std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v)};
    });
    EXPECT_THAT([&] { ball.slidingPoints(); },
                ThrowsMessage<Error>(AllOf(
                    HasSubstr("the points of the patch 'ball' cannot slide: 81 points of it are on "
                              "no plane and no cylinder; the best cylinder is 0."),
                    HasSubstr("away from point"), HasSubstr("hold the patch"))));
    Builder curve("foil", 1);
    curve.grid(8, 0, [](double u, double) { return Point3{u, u * u, 0}; });
    EXPECT_THAT([&] { curve.slidingPoints(); },
                ThrowsMessage<Error>(HasSubstr("'foil' cannot slide: 9 points of it are on no line "
                                               "and no circle; the best circle is 0.0")));
    // A cone.
    Builder cone("cone");
    cone.grid(16, 3, [](double u, double v) {
        const double turn = 2 * std::numbers::pi * u, radius = 1 + 0.01 * v;
        return Point3{radius * std::cos(turn), radius * std::sin(turn), v};
    });
    EXPECT_THROW(cone.slidingPoints(), Error);
    far::MeshPatch cells{"fluid"};
    cells.dimension = 3;
    EXPECT_THAT([&] { SlidingPoints(std::span(&cells, 1), Positions{}); },
                ThrowsMessage<Error>(HasSubstr("'fluid' cannot slide: it is a group of cells")));
    far::MeshPatch wrong{"wrong"};
    wrong.points = {7};
    EXPECT_THAT([&] { SlidingPoints(std::span(&wrong, 1), Positions(7)); },
                ThrowsMessage<Error>(HasSubstr("the patch 'wrong' has point 7, but there are 7")));
    wrong.points = {0};
    EXPECT_THAT([&] { SlidingPoints(std::span(&wrong, 1), Positions(7)); },
                ThrowsMessage<Error>(HasSubstr("1 point of it determine no plane")));
}

TEST(SlidingPoints, InPosesWithoutAPlaceAreRefused) {
    const Builder builder = tube(8, 2 * std::numbers::pi, 1, 1, same);
    const SlidingPoints sliding = builder.slidingPoints();
    Positions points = builder.points;
    points.pop_back();
    EXPECT_THAT([&] { sliding.slide(points); },
                ThrowsMessage<Error>(HasSubstr("got 15 positions for 16 points")));
    points = builder.points;
    points[3] = sliding.patches()[0].shapes[0].origin;
    EXPECT_THAT([&] { sliding.slide(points); },
                ThrowsMessage<Error>(HasSubstr("point 3 of the patch 'hull' is moved to the axis "
                                               "of its cylinder")));
}

TEST(PatchPieces, TurnByFiftyDegreesAtMost) {
    const double full = 2 * std::numbers::pi;
    const Builder eight = tube(8, full, 2, 1), seven = tube(7, full, 2, 1);
    EXPECT_EQ(piecesOf(eight.patch, eight.points).size(), 1u);
    EXPECT_EQ(piecesOf(seven.patch, seven.points).size(), 7u);
    // Faces that are wound the other way are the same pieces.
    Builder turned = eight;
    const auto corners = turned.patch.faces.values.data();
    std::reverse(corners, corners + 4);
    EXPECT_EQ(piecesOf(turned.patch, turned.points).size(), 1u);
    // The two sides of a mesh of two dimensions.
    Builder sides("frontAndBack");
    for (const double z : {0.0, 1.0})
        sides.grid(3, 2, [&](double u, double v) { return Point3{u, v, z}; });
    EXPECT_EQ(piecesOf(sides.patch, sides.points).size(), 2u);
    // A rectangle of lines.
    Builder outer("far", 1);
    for (int side = 0; side < 4; ++side)
        outer.grid(4, 0, [&](double u, double) {
            const Point3 from[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
            return between(from[side], from[side + 1], u);
        });
    EXPECT_EQ(piecesOf(outer.patch, outer.points).size(), 4u);
    // Points alone are one piece.
    far::MeshPatch points{"points"};
    points.points = {1, 2, 3};
    const auto pieces = piecesOf(points, eight.points);
    ASSERT_EQ(pieces.size(), 1u);
    EXPECT_EQ(pieces[0].points, points.points);
}

}  // namespace
}  // namespace espalier::solve
