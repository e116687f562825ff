// SPDX-License-Identifier: Apache-2.0
#include "io/models/triangulation.h"

#include <espalier/base/vector3.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "support/test.h"

namespace espalier::io {
namespace {

using Triangle = std::array<std::size_t, 3>;

Point3 areaOf(std::span<const Point3> polygon, const Triangle& triangle) {
    const Point3 loop[] = {polygon[triangle[0]], polygon[triangle[1]], polygon[triangle[2]]};
    return areaVector(loop);
}

/// Requires that the triangles have the winding of the polygon, that each edge of the polygon is an
/// edge of one triangle in the same direction, and that each other edge joins two triangles.
void expectTriangulation(std::span<const Point3> polygon, const std::vector<Triangle>& triangles) {
    ASSERT_EQ(triangles.size(), polygon.size() - 2);
    std::map<std::pair<std::size_t, std::size_t>, int> edges;
    for (const Triangle& t : triangles)
        for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto edge = edges.find({i, (i + 1) % polygon.size()});
        ASSERT_NE(edge, edges.end()) << i;
        EXPECT_EQ(edge->second, 1);
        edges.erase(edge);
    }
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
}

/// Requires a triangulation that covers a plane polygon exactly: no triangle is turned over, and
/// the areas add up.
void expectCovered(std::span<const Point3> polygon) {
    const auto triangles = triangulated(polygon);
    expectTriangulation(polygon, triangles);
    const Point3 whole = areaVector(polygon);
    double sum = 0;
    for (const Triangle& triangle : triangles) {
        const Point3 area = areaOf(polygon, triangle);
        EXPECT_GE(dot(area, whole), 0);
        sum += length(area);
    }
    // Rounding errors of the sum of fewer than 1000 areas.
    EXPECT_NEAR(sum, length(whole), 1e-12 * length(whole));
}

std::vector<Point3> inPlane(std::initializer_list<std::array<double, 2>> corners) {
    std::vector<Point3> polygon;
    for (const auto& [x, y] : corners) polygon.push_back({x, y, 0});
    return polygon;
}

/// Turns the plane z = 0 out of all coordinate planes.
std::vector<Point3> tilted(std::vector<Point3> polygon) {
    for (Point3& p : polygon) p = {p[0] - p[1], p[0] + p[1], 0.5 * p[0] - 0.25 * p[1] + 7};
    return polygon;
}

TEST(Triangulation, OfConvexPolygonsIsAFan) {
    const auto square = inPlane({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    EXPECT_EQ(triangulated(square), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    const auto hexagon = inPlane({{1, 0}, {2, 0}, {3, 1}, {2, 2}, {1, 2}, {0, 1}});
    EXPECT_EQ(triangulated(hexagon),
              (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}));
    EXPECT_EQ(triangulated(std::span(hexagon).first(3)), (std::vector<Triangle>{{0, 1, 2}}));
    EXPECT_TRUE(triangulated(std::span(hexagon).first(2)).empty());
    EXPECT_TRUE(triangulated({}).empty());
}

TEST(Triangulation, CoversPlanePolygonsThatAreNotConvex) {
    // An arrowhead. Corner 1 is reflex, so the fan from corner 0 would leave the polygon. Corner 2
    // is the first ear.
    const auto arrow = inPlane({{4, -2}, {1, 0}, {4, 2}, {0, 0}});
    EXPECT_EQ(triangulated(arrow), (std::vector<Triangle>{{1, 2, 3}, {1, 3, 0}}));
    const std::vector<std::vector<Point3>> polygons = {
        arrow, inPlane({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}),
        // corners on straight edges
        inPlane({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}),
        // A square with a square hole; a slit joins them.
        inPlane({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}})};
    for (const auto& polygon : polygons) {
        // From every corner, in both directions, in and out of the plane.
        for (std::size_t turn = 0; turn < polygon.size(); ++turn) {
            std::vector<Point3> turnedLoop(polygon);
            std::rotate(turnedLoop.begin(), turnedLoop.begin() + std::ptrdiff_t(turn),
                        turnedLoop.end());
            expectCovered(turnedLoop);
            expectCovered(tilted(turnedLoop));
            std::reverse(turnedLoop.begin(), turnedLoop.end());
            expectCovered(tilted(turnedLoop));
        }
    }
}

TEST(Triangulation, CoversStarsAndSpirals) {
    std::mt19937 random(7);
    for (int trial = 0; trial < 50; ++trial) {
        std::vector<Point3> star;
        const int count = 4 + trial;
        for (int i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * i / count;
            const double radius = std::uniform_real_distribution(0.05, 1.0)(random);
            star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
        }
        expectCovered(star);
        expectCovered(tilted(star));
    }
    // Both sides of a band that winds three times around its inner end.
    std::vector<Point3> spiral;
    for (const bool isOuter : {true, false})
        for (int i = 0; i < 100; ++i) {
            const int step = isOuter ? i : 99 - i;
            const double angle = 6 * std::numbers::pi * step / 99;
            const double radius = 1 + angle + (isOuter ? 1 : 0);
            spiral.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
        }
    expectCovered(spiral);
}

TEST(Triangulation, CoversPolygonsOfManyReflexCorners) {
    // A comb, and a spiral of four corners a turn: their ears become ears one after the other.
    std::vector<Point3> comb = inPlane({{0, -1}, {400, -1}}), spiral;
    for (int i = 400; i > 0; --i) comb.push_back({double(i - 1), i % 2 * 100.0, 0});
    for (const int side : {1, 0})
        for (int i = 0; i < 200; ++i) {
            const int step = side == 1 ? i : 199 - i;
            const double angle = step * std::numbers::pi / 2;
            spiral.push_back(
                {(step + 4 + side) * std::cos(angle), (step + 4 + side) * std::sin(angle), 0});
        }
    expectCovered(comb);
    expectCovered(tilted(spiral));
}

TEST(Triangulation, HasTrianglesForAnyPolygon) {
    const double huge = std::numeric_limits<double>::max();
    for (const auto& polygon :
         {inPlane({{0, 0}, {1, 1}, {1, 0}, {0, 1}}),           // crosses itself
          inPlane({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}}),   // has no area
          inPlane({{0, 0}, {0, 0}, {0, 0}, {0, 0}}),           // is one place
          inPlane({{0, 0}, {1, 0}, {0, 0}, {0, 1}, {0, 0}})})  // goes through a place twice
        expectTriangulation(polygon, triangulated(polygon));
    // Coordinates of any size; areas would overflow or underflow.
    for (const double size : {huge, 1e300, 1e-300}) {
        std::vector<Point3> arrow = inPlane({{1, -0.5}, {0.25, 0}, {1, 0.5}, {0, 0}});
        for (Point3& corner : arrow) corner = scaled(corner, size);
        EXPECT_EQ(triangulated(arrow), (std::vector<Triangle>{{1, 2, 3}, {1, 3, 0}})) << size;
    }
    const std::vector<Point3> opposite =
        inPlane({{-huge, -huge}, {huge, -huge}, {huge, huge}, {-huge, huge}});
    EXPECT_EQ(triangulated(opposite), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    // A quadrilateral that is not plane, as of a deformed model.
    const std::vector<Point3> bent = {{0, 0, 0}, {1, 0, 0.5}, {1, 1, 0}, {0, 1, 0.5}};
    expectTriangulation(bent, triangulated(bent));
}

// If the time grew as the square of the number of corners, this would take minutes.
TEST(Triangulation, OfLongLinesIsAFan) {
    constexpr std::size_t kCount = 100'000;
    // In the first direction all areas are exactly 0; in the others, rounding makes some positive.
    // The last line is far from the origin.
    const Point3 directions[] = {{1, 0, 0}, {0.1, 0.7, -0.3}, {0.1, 0.7, -0.3}};
    const Point3 starts[] = {{0, 0, 0}, {0, 0, 0}, {1e5, -2e5, 3e5}};
    for (std::size_t line = 0; line < 3; ++line) {
        SCOPED_TRACE(line);
        std::vector<Point3> polygon;
        for (std::size_t i = 0; i < kCount; ++i)
            polygon.push_back(sum(starts[line], scaled(directions[line], double(i))));
        const auto triangles = triangulated(polygon);
        ASSERT_EQ(triangles.size(), kCount - 2);
        EXPECT_EQ(triangles.front(), (Triangle{0, 1, 2}));
        EXPECT_EQ(triangles.back(), (Triangle{0, kCount - 2, kCount - 1}));
    }
}

// A line of corners that leads back to its start through the same places.
TEST(Triangulation, OfLinesThereAndBackIsQuick) {
    constexpr int kCount = 100'000;
    std::vector<Point3> polygon;
    for (int i = 0; i < kCount; ++i) polygon.push_back({std::min(i, kCount - i) * 0.1, 0, 5});
    EXPECT_EQ(triangulated(polygon).size(), polygon.size() - 2);
}

}  // namespace
}  // namespace espalier::io
