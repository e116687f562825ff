// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>

#include <numbers>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

using std::numbers::pi;

/// The numbers of vertices and faces of a disk of n sides. Each ring has n vertices and n faces. A
/// polygonal core is one face without a vertex inside; a core of wedges has n faces and one vertex.
struct DiskSize {
    Index vertices;
    Index faces;
    DiskSize(Index n, const DiskPattern& pattern)
        : vertices(n * pattern.rings + (pattern.core == Core::Wedges ? 1 : 0)),
          faces(pattern.core == Core::Wedges ? n * pattern.rings : 1 + n * (pattern.rings - 1)) {}
};

const DiskPattern kPatterns[] = {{1, Core::Wedges},
                                 {2, Core::Wedges},
                                 {3, Core::Wedges},
                                 {1, Core::Polygon},
                                 {3, Core::Polygon}};

/// Returns the area of a regular polygon.
double polygonArea(int sides, double radius) {
    return sides * radius * radius * std::sin(2 * pi / sides) / 2;
}

TEST(Box, HasTheCountsOfAGrid) {
    for (const auto& [i, j, k] : {std::array{1, 1, 1}, std::array{3, 2, 1}, std::array{2, 4, 3}}) {
        const Lattice lattice = box({{i, j, k}, {-1, 0, 2}, {1, 3, 2.5}});
        const Counts expected = {
            (i + 1) * (j + 1) * (k + 1),
            i * (j + 1) * (k + 1) + (i + 1) * j * (k + 1) + (i + 1) * (j + 1) * k,
            i * j * (k + 1) + i * (j + 1) * k + (i + 1) * j * k, i * j * k};
        EXPECT_EQ(countsOf(lattice.complex), expected);
        EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
        EXPECT_NEAR(totalVolume(lattice), 2 * 3 * 0.5, kRounding);
        expectValid(lattice);
    }
}

TEST(Box, NumbersVerticesWithXFastestAndEndsAtItsCornersExactly) {
    const Lattice lattice = box({{3, 2, 4}, {0.1, 0.2, 0.3}, {0.7, 1.1, 1.3}});
    EXPECT_EQ(at(lattice, 0), (Point3{0.1, 0.2, 0.3}));
    EXPECT_EQ(at(lattice, 3), (Point3{0.7, 0.2, 0.3}));
    EXPECT_EQ(at(lattice, 4 * 2), (Point3{0.1, 1.1, 0.3}));
    EXPECT_EQ(at(lattice, 4 * 3 * 5 - 1), (Point3{0.7, 1.1, 1.3}));
    // Cell (2, 1, 3) is 2 + 3 (1 + 2 · 3) = 23, the last one; its first vertex is vertex (2, 1, 3).
    EXPECT_EQ(lattice.complex.relation(3, 0)[23][0], 2 + 4 * (1 + 3 * 3));
}

TEST(Box, MeetsInVerticesOfSixEdgesInside) {
    const Lattice lattice = box({{2, 2, 2}});
    EXPECT_EQ(lattice.complex.relation(0, 1)[13].size(), 6U);
    EXPECT_EQ(lattice.complex.relation(0, 3)[13].size(), 8U);
}

TEST(Cylinder, HasTheCountsOfASweptDisk) {
    for (const DiskPattern& pattern : kPatterns)
        for (const int sectors : {3, 7})
            for (const int layers : {1, 3}) {
                const Lattice lattice = cylinder({sectors, pattern, layers});
                const DiskSize disk(sectors, pattern);
                EXPECT_EQ(countsOf(lattice.complex),
                          sweptDiskCounts(disk.vertices, disk.faces, layers));
                EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
                EXPECT_NEAR(totalVolume(lattice), polygonArea(sectors, 1), kRounding);
                expectValid(lattice);
            }
}

TEST(Cylinder, HasWedgesAroundItsAxis) {
    const int sectors = 7;
    const Lattice lattice = cylinder({sectors, {2}, 3});
    const Index perLayer = 1 + 2 * sectors;
    for (Index layer = 0; layer < 3; ++layer) {
        // Exactly the wedges of the layer meet at the layer's edge of the axis.
        const Index axis = edgeBetween(lattice.complex, layer * perLayer, (layer + 1) * perLayer);
        const auto cells = lattice.complex.relation(1, 3)[axis];
        EXPECT_EQ(cells.size(), std::size_t(sectors));
        for (const Index cell : cells) EXPECT_EQ(lattice.complex.relation(3, 0)[cell].size(), 6U);
    }
    // A vertex of the axis has one edge per sector, and one along the axis at the ends, two inside.
    EXPECT_EQ(lattice.complex.relation(0, 1)[0].size(), 1U + sectors);
    EXPECT_EQ(lattice.complex.relation(0, 1)[perLayer].size(), 2U + sectors);
}

TEST(Cylinder, HasOnePrismInAPolygonalCore) {
    const Lattice lattice = cylinder({5, {2, Core::Polygon}});
    std::vector<std::size_t> faceCounts;
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
        faceCounts.push_back(lattice.complex.relation(3, 2)[cell].size());
    EXPECT_EQ(faceCounts, (std::vector<std::size_t>{7, 6, 6, 6, 6, 6}));
}

TEST(Cylinder, LiesAlongItsAxis) {
    const Point3 from = {1, 2, 3};
    for (const Point3& to :
         {Point3{1, 2, 5}, Point3{1, 2, 1}, Point3{3, 2, 3}, Point3{2, 3, 4}, Point3{-1, 2, 3}}) {
        const Lattice lattice = cylinder({6, {1}, 2, 0.5, from, to});
        const Point3 axis = minus(to, from);
        EXPECT_NEAR(totalVolume(lattice), polygonArea(6, 0.5) * norm(axis), kRounding);
        EXPECT_EQ(at(lattice, 0), from);
        EXPECT_EQ(at(lattice, 14), to);
        for (Index v = 1; v < 7; ++v) {
            const Point3 spoke = minus(at(lattice, v), from);
            EXPECT_NEAR(norm(spoke), 0.5, kRounding);
            EXPECT_NEAR(spoke[0] * axis[0] + spoke[1] * axis[1] + spoke[2] * axis[2], 0, kRounding);
        }
        expectValid(lattice);
    }
}

TEST(Torus, HasTheCountsOfASweptSection) {
    for (const int segments : {3, 5}) {
        for (const int m : {1, 3}) {
            const Lattice lattice = torus({segments, TorusSection::Grid, m});
            EXPECT_EQ(countsOf(lattice.complex),
                      sweptDiskCounts((m + 1) * (m + 1), m * m, segments, true));
            EXPECT_EQ(lattice.complex.eulerCharacteristic(), 0);
            expectValid(lattice);
        }
        for (const DiskPattern& pattern : kPatterns) {
            const Lattice lattice = torus({segments, TorusSection::Disk, 1, 5, pattern});
            const DiskSize disk(5, pattern);
            EXPECT_EQ(countsOf(lattice.complex),
                      sweptDiskCounts(disk.vertices, disk.faces, segments, true));
            EXPECT_EQ(lattice.complex.eulerCharacteristic(), 0);
            expectValid(lattice);
        }
    }
}

TEST(Torus, HasTheVolumeOfAPolygonalRing) {
    // The volume is the area of a regular N-gon of circumradius R + r less one of R − r, times the
    // height 2 r.
    const double major = 2;
    const double minor = 0.5;
    const Lattice lattice = torus({7, TorusSection::Grid, 2, 6, {}, major, minor});
    EXPECT_NEAR(totalVolume(lattice),
                (polygonArea(7, major + minor) - polygonArea(7, major - minor)) * 2 * minor,
                kRounding);
}

TEST(Star, HasTheCountsOfADiskOfTwoSidesAPoint) {
    for (const DiskPattern& pattern : kPatterns)
        for (const int points : {2, 5}) {
            const Lattice lattice = star({points, pattern, 2});
            const DiskSize disk(2 * points, pattern);
            EXPECT_EQ(countsOf(lattice.complex), sweptDiskCounts(disk.vertices, disk.faces, 2));
            EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
            // The triangles between spokes have these two sides and the angle π / points.
            EXPECT_NEAR(totalVolume(lattice), points * 0.5 * 1 * std::sin(pi / points) * 0.25,
                        kRounding);
            expectValid(lattice);
        }
}

TEST(Star, HasTheTopologyOfItsRoundRestPose) {
    const DiskPattern pattern = {3};
    const Lattice rest = star({6, pattern, 2, 1, 1});
    const Lattice pose = star({6, pattern, 2, 0.3, 1.5, 0.5});
    EXPECT_TRUE(sameTopology(rest.complex, pose.complex));
    for (std::size_t v = 0; v < rest.positions.size(); ++v) {
        // Vertices keep their direction, and move alternately outwards and inwards.
        const std::size_t inLayer = v % (1 + 3 * 12);
        const double factor = inLayer == 0 ? 1 : (inLayer - 1) % 2 == 0 ? 1.5 : 0.3;
        for (std::size_t axis = 0; axis < 2; ++axis)
            EXPECT_NEAR(pose.positions[v][axis], factor * rest.positions[v][axis], kRounding);
    }
}

TEST(Inventory, DiffersInTopologyWhereCountsDiffer) {
    // The comparison that the tests of poses use can fail.
    EXPECT_FALSE(sameTopology(star({5}).complex, star({6}).complex));
    EXPECT_FALSE(sameTopology(box({{2, 1, 1}}).complex, box({{1, 1, 2}}).complex));
}

}  // namespace
}  // namespace espalier::shapes
