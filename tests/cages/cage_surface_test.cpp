// SPDX-License-Identifier: Apache-2.0
#include "cages/cage_surface.h"

#include <espalier/base/bounding_box.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/complex_builder.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <gtest/gtest.h>

#include <set>

#include "grid_cages.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

/// A cage with sharp and smooth edges, all vertices moved a little.
Lattice bentCage() {
    Lattice lattice = test::gridCage(test::figure(), 0.4);
    for (Point3& p : lattice.positions)
        p = {p[0] + 0.05 * std::sin(5 * p[1]), p[1] + 0.05 * std::sin(7 * p[2]),
             p[2] + 0.05 * std::sin(6 * p[0])};
    return lattice;
}

TEST(CageSurface, isTheBoundaryOfTheLevels) {
    const Lattice lattice = bentCage();
    far::TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    const CageSurface surface(refiner);
    refiner.refineUniform(CageSurface::kLevel);
    const auto positions =
        stencils::refinePositions(refiner, CageSurface::kLevel, lattice.positions);
    const far::CellComplex& complex = refiner.level(CageSurface::kLevel).complex;
    std::vector<std::vector<Point3>> expected, found;
    for (Index face = 0; face < complex.count(2); ++face) {
        if (complex.relation(2, 3)[face].size() != 1) continue;
        expected.emplace_back();
        for (const Index v : complex.relation(2, 0)[face]) expected.back().push_back(positions[v]);
    }
    const auto vertices = surface.fineVertices(lattice.positions);
    for (const auto& loop : surface.fineFaces().loops) {
        found.emplace_back();
        for (const Index v : loop) found.back().push_back(vertices[v]);
    }
    // Positions come by different sums: rounded to 1e-9, far below the size of a face, 0.05.
    for (auto* faces : {&expected, &found}) {
        for (auto& face : *faces) {
            for (Point3& p : face)
                for (double& coordinate : p) coordinate = std::round(coordinate * 1e9 + 0.37) / 1e9;
            std::sort(face.begin(), face.end());
        }
        std::sort(faces->begin(), faces->end());
    }
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t face = 0; face < found.size(); ++face)
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                ASSERT_NEAR(found[face][i][axis], expected[face][i][axis], 1.5e-9) << face;
}

TEST(CageSurface, hullsHoldTheNextLevel) {
    const Lattice lattice = bentCage();
    const CageSurface surface(far::TopologyRefiner(lattice.complex, refinerOptions(lattice)));
    const auto fine = surface.fineVertices(lattice.positions);
    const auto finest = surface.finestVertices(fine);
    const auto& faces = surface.fineFaces();
    // Level 4 has four faces for each face of level 3, in the order of the faces.
    ASSERT_EQ(surface.finestFaces().loops.size(), 4 * faces.loops.size());
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (std::size_t child = 0; child < surface.finestFaces().loops.size(); ++child) {
        const auto face = static_cast<Index>(child / 4);
        for (int i = 0; i < 5; ++i) {
            const Point3 way = {normal(random), normal(random), normal(random)};
            double most = -1e9;
            for (const Index v : faces.hull(face)) most = std::max(most, dot(way, fine[v]));
            // This holds the limit of the face, too.
            for (const Index v : surface.finestFaces().hull(static_cast<Index>(child)))
                ASSERT_LE(dot(way, finest[v]), most + 1e-12) << "face " << face;
        }
    }
}

// Patches have Bézier points instead.
TEST(CageSurface, irregularHullsAreTheHullsOfTheNextLevelAroundOtherFacesThanPatches) {
    const Lattice lattice = bentCage();
    const CageSurface surface(far::TopologyRefiner(lattice.complex, refinerOptions(lattice)));
    const auto fine = surface.fineVertices(lattice.positions);
    const auto finest = surface.finestVertices(fine);
    const auto irregular = surface.irregularVertices(fine);
    EXPECT_LT(irregular.size(), finest.size());
    int patches = 0, others = 0;
    for (Index face = 0; face < std::ssize(surface.fineFaces().loops); ++face) {
        const auto hull = surface.irregularHull(face);
        if (surface.fineFaces().isPatch[face] != 0) {
            ++patches;
            ASSERT_THAT(hull, IsEmpty());
            continue;
        }
        ++others;
        std::set<Point3> expected, found;
        for (Index child = 4 * face; child < 4 * face + 4; ++child)
            for (const Index v : surface.finestFaces().hull(child)) expected.insert(finest[v]);
        for (const Index number : hull) found.insert(irregular[number]);
        ASSERT_EQ(found, expected) << "face " << face;
    }
    EXPECT_GT(patches, 0);
    EXPECT_GT(others, 0);
}

/// Returns the point of a Bézier patch at the place (u, v).
Point3 patchAt(std::span<const Point3> points, double u, double v) {
    const auto weights = [](double t) {
        const double s = 1 - t;
        return std::array<double, 4>{s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
    };
    Point3 place = {0, 0, 0};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            place = sum(place, scaled(points[4 * i + j], weights(v)[i] * weights(u)[j]));
    return place;
}

TEST(CageSurface, limitHullsAreTheBezierPointsOfPatches) {
    const Lattice lattice = bentCage();
    const CageSurface surface(far::TopologyRefiner(lattice.complex, refinerOptions(lattice)));
    const auto fine = surface.fineVertices(lattice.positions);
    const auto finest = surface.finestVertices(fine);
    int patches = 0, others = 0;
    std::vector<Point3> ofFace, ofChild;
    for (Index face = 0; face < std::ssize(surface.fineFaces().loops); ++face) {
        surface.fineFaces().limitHull(face, fine, ofFace);
        if (surface.fineFaces().isPatch[face] == 0) {
            ++others;
            EXPECT_THAT(ofFace, SizeIs(surface.fineFaces().hull(face).size()));
            continue;
        }
        ++patches;
        ASSERT_THAT(ofFace, SizeIs(20));
        const Point3 direction = normalised({1.0 + face % 3, 2.0 - face % 5, 0.5});
        double lowest = dot(direction, ofFace.front());
        for (const Point3& point : ofFace) lowest = std::min(lowest, dot(direction, point));
        ASSERT_NEAR(surface.fineFaces().lowestOfPatch(face, fine, direction), lowest, 1e-12)
            << "face " << face;
        // The corners of the patches of the four children are on the patch, at its corners and
        // between them.
        for (Index child = 4 * face; child < 4 * face + 4; ++child) {
            ASSERT_NE(surface.finestFaces().isPatch[child], 0);
            surface.finestFaces().limitHull(child, finest, ofChild);
            for (const std::size_t corner : {0, 3, 12, 15}) {
                double least = 1;
                for (const double u : {0.0, 0.5, 1.0})
                    for (const double v : {0.0, 0.5, 1.0})
                        least = std::min(
                            least, length(difference(patchAt(ofFace, u, v), ofChild[corner])));
                ASSERT_LE(least, 1e-12) << "face " << face;
            }
        }
    }
    // Faces at the extraordinary vertices and at the sharp edges have no patch.
    EXPECT_GE(patches, 1000);
    EXPECT_GE(others, 100);
}

/// Points at random in the box around a lattice, for models of one point each.
std::vector<Point3> randomPoints(const Lattice& lattice, int count) {
    const BoundingBox bounds(lattice.positions);
    std::mt19937 random(5);
    std::vector<Point3> points(count);
    for (Point3& p : points)
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] =
                std::uniform_real_distribution<double>(bounds.min[axis], bounds.max[axis])(random);
    return points;
}

TEST(FindUncovered, coversOnlyPointsInsideAndNearlyAllOfThem) {
    const Lattice lattice = bentCage();
    const far::TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    const CageSurface surface(refiner);
    // Cubes are so small that nearly each point is a group of its own.
    const PointGroups groups(test::fitPoints(randomPoints(lattice, 2000)),
                             CubeGrid({-2, -2, -2}, {2.5, 2, 2}, 0.04));
    const auto level = embed::bindPoints({refiner, lattice.positions}, groups.points());
    const auto limit = limit::bindLimit({refiner, lattice.positions}, groups.points());
    std::vector<char> isUncovered(groups.groups().size(), 0);
    for (const Uncovered& group : findUncovered(surface, lattice.positions, groups, 0))
        isUncovered[group.group] = 1;
    int inside = 0, covered = 0;
    for (std::size_t g = 0; g < isUncovered.size(); ++g)
        for (Index i = groups.groups()[g].first; i < groups.groups()[g].last; ++i) {
            const bool isInside = level.statuses[i] == embed::PointStatus::Inside &&
                                  limit.statuses[i] == embed::PointStatus::Inside;
            EXPECT_TRUE(isInside || isUncovered[g]) << "point " << i;
            inside += isInside;
            covered += !isUncovered[g];
        }
    EXPECT_GE(inside, 500);
    // Points in a thin layer below the boundary are not proved.
    EXPECT_GE(covered, 0.99 * inside);
}

TEST(FindUncovered, countsTheMargin) {
    const Lattice lattice = test::gridCage(test::brick(), 0.5);
    const CageSurface surface(far::TopologyRefiner(lattice.complex, refinerOptions(lattice)));
    const std::vector<Point3> centre = {{0, 0, 0}};
    const PointGroups groups(test::fitPoints(centre), CubeGrid({-3, -3, -3}, {3, 3, 3}, 0.5));
    EXPECT_THAT(findUncovered(surface, lattice.positions, groups, 0.1), IsEmpty());
    EXPECT_THAT(findUncovered(surface, lattice.positions, groups, 2), SizeIs(1));
}

/// Three cubes in the shape of an L, with the edge 3. The inner edge of the L is sharp and lies on
/// the z axis.
Lattice angle() {
    const auto vertexAt = [](Index x, Index y, Index z) { return 8 * z + 3 * y + x; };
    Lattice lattice;
    for (const double z : {-1.5, 1.5})
        for (Index square = 0; square < 8; ++square) {  // without the vertex at (3, 3)
            const Index row = square / 3, column = square % 3;
            lattice.positions.push_back({3.0 * column - 3, 3.0 * row - 3, z});
        }
    far::ComplexBuilder builder(3, 16);
    for (const auto& [x, y] : {std::pair<Index, Index>{0, 0}, {1, 0}, {0, 1}}) {
        std::vector<Index> corners;
        for (const Index z : {0, 1})
            for (const auto& [i, j] : {std::pair<Index, Index>{0, 0}, {1, 0}, {1, 1}, {0, 1}})
                corners.push_back(vertexAt(x + i, y + j, z));
        builder.addCell(far::StandardCell::Hexahedron, corners);
    }
    lattice.complex = builder.build();
    lattice.marks.edges.push_back({{vertexAt(1, 1, 0), vertexAt(1, 1, 1)}});
    return lattice;
}

TEST(FindUncovered, measuresTheMarginAsADistance) {
    const Lattice lattice = angle();
    const CageSurface surface(far::TopologyRefiner(lattice.complex, refinerOptions(lattice)));
    // The inner edge of the L is nearest, √2 away, but only 1 away along each axis. The boxes
    // around the faces at the edge reach over it by up to a quarter of a face of level 2.
    const std::vector<Point3> point = {{-1, -1, 0}};
    const PointGroups groups(test::fitPoints(point), CubeGrid({-4, -4, -4}, {4, 4, 4}, 0.5));
    EXPECT_THAT(findUncovered(surface, lattice.positions, groups, 1.2), IsEmpty());
    EXPECT_THAT(findUncovered(surface, lattice.positions, groups, 1.42), SizeIs(1));
}

}  // namespace
}  // namespace espalier::cages
