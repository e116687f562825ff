// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/shapes/cell_distances.h>
#include <espalier/shapes/cell_selection.h>
#include <espalier/shapes/limb.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/solids.h>

#include "support/lattices_with_limbs.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

/// Returns the vertices at positions that isIn() accepts.
template <class IsIn>
std::vector<Index> verticesWhere(const Lattice& lattice, const IsIn& isIn) {
    std::vector<Index> vertices;
    for (std::size_t v = 0; v < lattice.positions.size(); ++v)
        if (isIn(lattice.positions[v])) vertices.push_back(static_cast<Index>(v));
    return vertices;
}

// In a grid the vertices n edges away from a corner are those with x + y + z = n.
TEST(CellSelection, GrowsAndShrinksAlongEdges) {
    const Lattice lattice = box({.cells = {4, 4, 4}, .max = {4, 4, 4}});
    const auto within = [&](double steps) {
        return verticesWhere(lattice,
                             [&](const Point3& p) { return p[0] + p[1] + p[2] <= steps + 1e-9; });
    };
    const auto corner = within(0);
    ASSERT_EQ(corner.size(), 1U);
    EXPECT_EQ(growSelection(lattice.complex, corner, 0), corner);
    for (int steps = 1; steps <= 12; ++steps) {
        EXPECT_EQ(growSelection(lattice.complex, corner, steps), within(steps));
        EXPECT_EQ(shrinkSelection(lattice.complex, within(steps), 1),
                  within(steps < 12 ? steps - 1 : 12));
    }
    EXPECT_EQ(growSelection(lattice.complex, corner, 1000000000), within(12));
    EXPECT_TRUE(shrinkSelection(lattice.complex, corner).empty());
    const std::vector<Index> repeated = {corner[0], corner[0]};
    EXPECT_EQ(growSelection(lattice.complex, repeated), within(1));
}

// In space the two legs are 1 apart; along the cells the way goes over the foot.
TEST(CellSelection, MeasuresAlongTheCells) {
    const Lattice lattice = twoLegs();
    const auto& complex = lattice.complex;
    const auto& positions = lattice.positions;
    const auto near = selectNear(complex, positions, {0.5, 0.5, 4}, 2);
    const auto ball = selectBall(positions, {0.5, 0.5, 4}, 2);
    int across = 0;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        if (positions[v][0] >= 2) {
            EXPECT_EQ(near[v], 0);
        }
        across += static_cast<int>(positions[v][0] >= 2 && ball[v] == 1);
    }
    EXPECT_GT(across, 0);
    // From the outer edge of one leg, straight down 3 cubes.
    const auto top = verticesWhere(lattice, [](const Point3& p) { return p[0] == 0 && p[2] == 4; });
    const auto weights = selectAlongCells(complex, positions, top, {Falloff::Profile::Linear, 4});
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (positions[v][0] == 0) {
            EXPECT_NEAR(weights[v], positions[v][2] / 4, 1e-15);
        }
    const auto other =
        verticesWhere(lattice, [](const Point3& p) { return p[0] == 3 && p[2] == 4; });
    EXPECT_EQ(weights[other[0]], 0);
}

// The definition, by Bellman and Ford.
TEST(CellSelection, DistancesAreThoseOfTheShortestWays) {
    for (const Lattice& lattice : {figure(), twoLegs(), icosahedron(), star()}) {
        const std::vector<WayStart> starts = {{0, 0.25}, {5, 0}};
        std::vector<double> expected(lattice.positions.size(), kInfinity);
        for (const WayStart& start : starts) expected[start.vertex] = start.length;
        std::vector<double> before;
        while (before != expected) {
            before = expected;
            for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
                for (const Index a : lattice.complex.relation(3, 0)[cell])
                    for (const Index b : lattice.complex.relation(3, 0)[cell])
                        expected[b] = std::min(
                            expected[b], expected[a] + length(difference(lattice.positions[a],
                                                                         lattice.positions[b])));
        }
        EXPECT_EQ(distancesAlongCells(lattice.complex, lattice.positions, starts), expected);
    }
    const Lattice apart = cubes({3, 1, 1}, [](int x, int, int) { return x != 1; });
    const auto distances =
        distancesAlongCells(apart.complex, apart.positions, std::vector<WayStart>{{0, 0}});
    EXPECT_EQ(std::ranges::count(distances, kInfinity), 8);
}

TEST(CellSelection, NearestCellsAndFacesAreThoseOfThePoint) {
    const Lattice lattice = figure();
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell) {
        Point3 inside = cellMiddle(lattice.complex, lattice.positions, cell);
        EXPECT_NEAR(cellVolume(lattice.complex, lattice.positions, cell), 1, 1e-14);
        for (const double part : {-0.4, -0.1, 0.3}) {
            inside[0] += part;
            EXPECT_EQ(nearestCell(lattice.complex, lattice.positions, inside), cell);
            inside[0] -= part;
        }
    }
}

// An arm turns about the middle of its section with the body, and stays attached there.
TEST(CellSelection, LimbsTurnAboutTheirBorder) {
    const Lattice lattice = figure();
    const auto& complex = lattice.complex;
    const auto& positions = lattice.positions;
    const auto arm = selectLimb(complex, positions, {0, 2, 5}).vertices;
    const Section border = selectionBorder(complex, positions, arm);
    EXPECT_LT(length(difference(border.center, {5, 2, 5})), 1e-14);
    EXPECT_EQ(border.faces.size(), 4U);
    const auto turned = pose::rotate(
        positions, {0, 1, 0}, 0.6,
        {.weights = selectAlongCells(complex, positions, arm), .center = border.center});
    // The middle of the section stays; so do all vertices of the body beside the section.
    EXPECT_LT(length(difference(selectionBorder(complex, turned, arm).center, border.center)),
              1e-14);
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!std::ranges::binary_search(arm, static_cast<Index>(v))) {
            EXPECT_EQ(turned[v], positions[v]);
        }
}

TEST(CellSelection, TheBorderOfALayerIsTheLayer) {
    const Lattice lattice = box({.cells = {2, 2, 3}, .max = {2, 2, 3}});
    const auto top = verticesWhere(lattice, [](const Point3& p) { return p[2] == 3; });
    const Section border = selectionBorder(lattice.complex, lattice.positions, top);
    EXPECT_EQ(border.faces.size(), 4U);
    EXPECT_LT(length(difference(border.center, {1, 1, 3})), 1e-15);
    const auto half = verticesWhere(lattice, [](const Point3& p) { return p[2] >= 1; });
    EXPECT_LT(length(difference(selectionBorder(lattice.complex, lattice.positions, half).center,
                                {1, 1, 1})),
              1e-15);
}

TEST(CellSelection, RefusesBadInput) {
    const Lattice lattice = box();
    const auto& complex = lattice.complex;
    const auto& positions = lattice.positions;
    const std::vector<Index> some = {0, 8}, all = {0, 1, 2, 3, 4, 5, 6, 7};
    EXPECT_REFUSED(Error, "growSelection: vertices[1]: expected 0 to 7, got 8",
                   growSelection(complex, some));
    EXPECT_REFUSED(Error, "shrinkSelection: steps: expected 0 or more, got -1",
                   shrinkSelection(complex, all, -1));
    EXPECT_REFUSED(Error, "selectNear: radius: expected a finite number of 0 or more, got -1",
                   selectNear(complex, positions, {0, 0, 0}, -1));
    EXPECT_REFUSED(Error, "selectNear: point: expected finite numbers",
                   selectNear(complex, positions, {kInfinity, 0, 0}, 1));
    EXPECT_REFUSED(Error, "the selection has no border", selectionBorder(complex, positions, all));
    EXPECT_REFUSED(Error, "the selection has no border", selectionBorder(complex, positions, {}));
    EXPECT_REFUSED(Error, "selectAlongCells: got 1 positions for 8 vertices",
                   selectAlongCells(complex, std::vector<Point3>(1), all));
}

}  // namespace
}  // namespace espalier::shapes
