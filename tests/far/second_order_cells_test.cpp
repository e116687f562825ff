// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/second_order_cells.h>
#include <espalier/far/volume_mesh.h>

#include <array>
#include <bit>
#include <numeric>

#include "support/test.h"

namespace espalier::far {
namespace {

constexpr std::array<std::size_t, 7> kSecondOrder = {10, 13, 14, 15, 18, 20, 27};

// Each kind has one point for each edge, which is an edge of its faces, and then at most one for
// each quadrilateral and for its inside.
TEST(SecondOrderCells, HaveAPointOnEachEdge) {
    for (const std::size_t size : kSecondOrder) {
        const StandardCell kind = *kindOfCell(size);
        const auto places = cellPoints(size);
        ASSERT_EQ(places.size(), size);
        for (Index corner = 0; corner < vertexCount(kind); ++corner)
            EXPECT_EQ(places[std::size_t(corner)], 1 << corner);
        std::set<CornerBits> edges, faces;
        for (const auto& loop : faceLoops(kind)) {
            int face = 0;
            for (std::size_t i = 0; i < loop.size(); ++i) {
                edges.insert(CornerBits(1 << loop[i] | 1 << loop[(i + 1) % loop.size()]));
                face |= 1 << loop[i];
            }
            if (loop.size() == 4) faces.insert(CornerBits(face));
        }
        const std::set<CornerBits> all(places.begin(), places.end());
        EXPECT_EQ(all.size(), size);
        EXPECT_TRUE(std::ranges::includes(all, edges)) << size;
        for (const CornerBits place : all)
            EXPECT_TRUE(std::popcount(place) < 3 || std::popcount(place) == 8 ||
                        faces.contains(place));
        EXPECT_TRUE(isSecondOrder(size));
        EXPECT_FALSE(isSecondOrder(std::size_t(vertexCount(kind))));
    }
    EXPECT_EQ(kindOfCell(7), std::nullopt);
    EXPECT_FALSE(isSecondOrder(7));
}

// A mirror image of a mirror image is the cell, and the corners of an edge, of a face and of the
// inside are mirrored with them.
TEST(SecondOrderCells, TurnIntoTheirMirrorImages) {
    for (const std::size_t size : {4, 5, 6, 8, 10, 13, 14, 15, 18, 20, 27}) {
        std::vector<Index> points(size);
        std::iota(points.begin(), points.end(), 100);
        const std::vector<Index> before = points;
        mirrorCell(points);
        EXPECT_NE(points, before);
        const auto places = cellPoints(size);
        for (std::size_t i = 0; i < size; ++i) {
            CornerBits mirrored = 0;
            for (std::size_t corner = 0; corner < 8; ++corner)
                if (places[i] >> corner & 1) mirrored |= CornerBits(1 << (points[corner] - 100));
            EXPECT_EQ(places[std::size_t(points[i] - 100)], mirrored);
        }
        mirrorCell(points);
        EXPECT_EQ(points, before);
    }
}

TEST(SecondOrderCells, NameAPlaceThatIsMissing) {
    std::array<Index, 10> points{};
    std::array<CornerBits, 10> places{};
    std::array<std::size_t, 4> corners = {0, 1, 2, 3};
    EXPECT_THROW(reorderedCell(points, places, corners), Error);
}

// Faces join cells of first and of second order by their corners.
TEST(SecondOrderCells, ShareFacesWithCellsOfFirstOrder) {
    VolumeMeshBuilder builder(11);
    builder.addCell(StandardCell::Tetrahedron, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
    builder.addCell(StandardCell::Tetrahedron, {0, 2, 1, 10});
    const VolumeMesh mesh = builder.build();
    EXPECT_EQ(mesh.internalFaceCount(), 1);
    EXPECT_EQ(mesh.faceCount(), 7);
    EXPECT_TRUE(mesh.isSecondOrder(0));
    EXPECT_FALSE(mesh.isSecondOrder(1));
    EXPECT_THAT(mesh.corners(0), ElementsAre(0, 1, 2, 3));
    EXPECT_THAT(mesh.points(0), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
    EXPECT_EQ(mesh.kind(0), StandardCell::Tetrahedron);
    EXPECT_THROW(VolumeMeshBuilder(20).addCell(StandardCell::Tetrahedron, {0, 1, 2, 3, 4}), Error);
}

}  // namespace
}  // namespace espalier::far
