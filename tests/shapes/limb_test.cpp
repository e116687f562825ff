// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/cell_distances.h>
#include <espalier/shapes/limb.h>
#include <espalier/shapes/solids.h>
#include <espalier/shapes/transform.h>

#include <cmath>

#include "support/lattices_with_limbs.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

Limb limbOf(const Lattice& lattice, const Point3& point) {
    return selectLimb(lattice.complex, lattice.positions, point);
}

/// Returns the cells whose vertices all lie in a box.
std::vector<Index> cellsIn(const Lattice& lattice, const Point3& low, const Point3& high) {
    std::vector<Index> cells;
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell) {
        bool isIn = true;
        for (const Index vertex : lattice.complex.relation(3, 0)[cell])
            for (std::size_t c = 0; c < 3; ++c)
                isIn = isIn && lattice.positions[vertex][c] >= low[c] &&
                       lattice.positions[vertex][c] <= high[c];
        if (isIn) cells.push_back(cell);
    }
    return cells;
}

/// The definition in limb.h, without any shortcut. Returns the cells of the limb; none without one.
std::vector<Index> slowLimb(const Lattice& lattice, const Point3& point) {
    const auto& complex = lattice.complex;
    const auto distance = [](const Point3& a, const Point3& b) {
        return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    };
    // Distances from the point, by Bellman and Ford.
    const Index first = nearestCell(complex, lattice.positions, point);
    std::vector<double> ways(lattice.positions.size(), kInfinity), before;
    for (const Index start : complex.relation(3, 0)[first])
        ways[start] = distance(point, lattice.positions[start]);
    while (before != ways) {
        before = ways;
        for (Index cell = 0; cell < complex.count(3); ++cell)
            for (const Index a : complex.relation(3, 0)[cell])
                for (const Index b : complex.relation(3, 0)[cell])
                    ways[b] = std::min(
                        ways[b], ways[a] + distance(lattice.positions[a], lattice.positions[b]));
    }
    std::vector<std::pair<double, Index>> order;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        double total = 0;
        const auto vertices = complex.relation(3, 0)[cell];
        for (const Index vertex : vertices) total += ways[vertex];
        order.emplace_back(cell == first ? -1 : total / static_cast<double>(vertices.size()), cell);
    }
    std::ranges::sort(order);
    struct Cut {
        std::set<Index> cells;
        double volume = 0, width = 0;
    };
    std::vector<Cut> cuts;
    for (std::size_t k = 1; k <= order.size(); ++k) {
        if (k < order.size() && order[k].first < order[k - 1].first + 1e-7) continue;
        Cut cut;
        for (std::size_t i = 0; i < k; ++i) cut.cells.insert(order[i].second);
        for (const Index cell : cut.cells)
            cut.volume += cellVolume(complex, lattice.positions, cell);
        double area = 0;
        for (Index face = 0; face < complex.count(2); ++face) {
            const auto cells = complex.relation(2, 3)[face];
            if (cells.size() != 2 || cut.cells.contains(cells[0]) == cut.cells.contains(cells[1]))
                continue;
            const auto loop = loopOf(complex, lattice.positions, face);
            for (std::size_t i = 2; i < loop.size(); ++i) {  // flat faces here
                const Point3 &a = loop[0], &b = loop[i - 1], &c = loop[i];
                const double p = distance(a, b), q = distance(b, c), r = distance(c, a);
                const double s = (p + q + r) / 2;  // Heron's formula
                area += std::sqrt(s * (s - p) * (s - q) * (s - r));
            }
        }
        cut.width = area / std::pow(cut.volume, 2.0 / 3);
        cuts.push_back(cut);
    }
    for (const double part : {1.0 / 3, 0.5}) {
        double best = 0;
        std::vector<Index> cells;
        for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
            if (cuts[k].volume > part * cuts.back().volume * 1.000001) continue;
            double widest = cuts[k].width;
            for (std::size_t j = k; j < cuts.size(); ++j) {
                if (cuts[j].width < cuts[k].width && cuts[j].volume < cuts.back().volume * 0.500001)
                    break;
                widest = std::max(widest, cuts[j].width);
            }
            if (widest / cuts[k].width > best) {
                best = widest / cuts[k].width;
                cells.assign(cuts[k].cells.begin(), cuts[k].cells.end());
            }
        }
        if (best >= (part < 0.4 ? 1.5 : 2)) return cells;
    }
    return {};
}

TEST(Limb, IsTheArmAtItsHand) {
    const Lattice lattice = figure();
    const Limb left = limbOf(lattice, {-0.2, 2, 5}), right = limbOf(lattice, {14, 1.5, 5.5});
    EXPECT_EQ(left.cells, cellsIn(lattice, {0, 0, 0}, {5, 4, 6}));
    EXPECT_EQ(right.cells, cellsIn(lattice, {9, 0, 0}, {14, 4, 6}));
    EXPECT_EQ(left.vertices.size(), 6U * 9);
    EXPECT_EQ(left.section.faces.size(), 4U);
    EXPECT_NEAR(left.section.area, 4, 1e-14);
    const Point3 joint = {5, 2, 5};
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(left.section.center[c], joint[c], 1e-14);
    EXPECT_GT(left.opening, 2);
    for (const Index face : left.section.faces)
        for (const Index vertex : lattice.complex.relation(2, 0)[face])
            EXPECT_EQ(lattice.positions[vertex][0], 5);
}

TEST(Limb, IsTheSameAsItsDefinition) {
    const Lattice lattice = figure();
    int limbs = 0;
    for (const Point3& point :
         {Point3{0, 2, 5}, {2.5, 1, 5.9}, {13.9, 3.2, 4.1}, {5, 0, 0}, {9, 4, 6}, {7, 2, 3}}) {
        const auto expected = slowLimb(lattice, point);
        limbs += static_cast<int>(!expected.empty());
        if (expected.empty())
            EXPECT_REFUSED(Error, "no limb", limbOf(lattice, point));
        else
            EXPECT_EQ(limbOf(lattice, point).cells, expected) << point[0];
    }
    EXPECT_GE(limbs, 3);
}

// Widths are ratios of areas and volumes, and distances keep their order.
TEST(Limb, MovesWithTheLattice) {
    const Lattice lattice = figure();
    const Point3 hand = {-0.2, 1.7, 5.2};
    for (const Affine& map : {translation({1e5, -1e5, 3e4}), scaling({1e-30, 1e-30, 1e-30}),
                              rotation({1, 2, 3}, 1.0) * scaling({1e20, 1e20, 1e20})}) {
        const Lattice moved = transformed(lattice, map);
        EXPECT_EQ(limbOf(moved, map(hand)).cells, limbOf(lattice, hand).cells);
    }
}

TEST(Limb, ConvexLatticesHaveNone) {
    for (const Lattice& lattice : {box(), box({.cells = {4, 4, 4}}), box({.cells = {6, 5, 4}}),
                                   box({.cells = {2, 2, 10}, .max = {2, 2, 10}}),
                                   cylinder({.layers = 6}), torus(), dodecahedron(), arm()})
        for (const Point3& position : lattice.positions)
            EXPECT_REFUSED(Error, "the lattice has no limb at", limbOf(lattice, position));
    EXPECT_MESSAGE(
        "the lattice has no limb at (0, 0, 0): no section between there and the rest is narrow "
        "(the widest opening is 1; expected 1.5 or more in a third of the lattice, or 2 in a "
        "half); "
        "select a ball, the vertices near the point, or those beyond a face",
        limbOf(box(), {0, 0, 0}));
}

// Beyond the middle of the bar, the part would have more than half of the volume.
TEST(Limb, IsHalfABarbell) {
    const Lattice lattice = cubes(
        {10, 3, 3}, [](int x, int y, int z) { return x < 3 || x >= 7 || (y == 1 && z == 1); });
    EXPECT_EQ(limbOf(lattice, {0, 1.5, 1.5}).cells, cellsIn(lattice, {0, 0, 0}, {5, 3, 3}));
    EXPECT_EQ(limbOf(lattice, {10, 1.5, 1.5}).cells, cellsIn(lattice, {5, 0, 0}, {10, 3, 3}));
}

// Cells that are not joined to the limb do not matter.
TEST(Limb, OtherPiecesAreLeftOut) {
    const Lattice lattice = cubes({20, 4, 6}, [](int x, int y, int z) {
        return (x >= 5 && x < 9) || (x < 14 && y >= 1 && y < 3 && z >= 4) || x >= 15;
    });
    EXPECT_EQ(limbOf(lattice, {0, 2, 5}).cells, cellsIn(lattice, {0, 0, 0}, {5, 4, 6}));
}

// Two blocks touch at one vertex, where no section is. The sum of areas with signs is 0 but for
// rounding, so that it must not count as a narrow section.
TEST(Limb, BlocksThatTouchAtAVertexHaveNoSectionThere) {
    const Lattice lattice = cubes({8, 7, 9}, [](int x, int y, int z) {
        return (x < 3 && y < 2 && z < 3) || (x >= 3 && y >= 2 && z >= 3);
    });
    for (int i = 0; i < 40; ++i) {
        const Affine map = scaling({1 + 0.013 * i, 1 + 0.029 * (i % 7), 1 + 0.017 * (i % 11)});
        const Limb limb = limbOf(transformed(lattice, map), map({0, 0, 0}));
        EXPECT_GT(limb.section.area, 1);
        EXPECT_GT(limb.cells.size(), 18U);
    }
}

TEST(Limb, BeyondAFaceIsTheSmallerPart) {
    const Lattice lattice = figure();
    for (const double x : {1.0, 3.0, 5.0}) {
        const Index face =
            nearestInnerFace(lattice.complex, lattice.positions, {x + 0.01, 1.5, 4.5});
        const Limb hand = selectBeyond(lattice.complex, lattice.positions, face);
        EXPECT_EQ(hand.cells, cellsIn(lattice, {0, 0, 0}, {x, 4, 6}));
        EXPECT_NEAR(hand.section.center[0], x, 1e-14);
        EXPECT_NEAR(hand.section.area, 4, 1e-14);
    }
    // Both legs are above the plane z = 2; they are joined below it.
    const Lattice legs = twoLegs();
    const Index face = nearestInnerFace(legs.complex, legs.positions, {2.5, 0.5, 2});
    EXPECT_EQ(selectBeyond(legs.complex, legs.positions, face).cells,
              cellsIn(legs, {2, 0, 2}, {3, 1, 4}));
}

TEST(Limb, RefusesBadInput) {
    const Lattice lattice = figure();
    const auto& complex = lattice.complex;
    const auto& positions = lattice.positions;
    EXPECT_REFUSED(Error, "selectLimb: point: expected finite numbers, got (nan, 0, 0)",
                   selectLimb(complex, positions, {kNan, 0, 0}));
    EXPECT_REFUSED(Error, "the lattice has no limb at (0, 0, 0)",
                   selectLimb(complex, std::vector<Point3>(positions.size()), {0, 0, 0}));
    EXPECT_REFUSED(Error, "selectLimb: got 2 positions for",
                   selectLimb(complex, std::vector<Point3>(2), {0, 0, 0}));
    EXPECT_REFUSED(Error, "selectBeyond: face: expected 0 to ",
                   selectBeyond(complex, positions, -1));
    Index boundary = 0;
    while (complex.relation(2, 3)[boundary].size() == 2) ++boundary;
    EXPECT_REFUSED(Error, "a face between two cells; this one is on the boundary",
                   selectBeyond(complex, positions, boundary));
    EXPECT_REFUSED(Error, "no face of the lattice is between two cells",
                   nearestInnerFace(cube().complex, cube().positions, {0, 0, 0}));
    auto apart = positions;
    apart[0][0] = 1e200;
    EXPECT_REFUSED(Error, "the positions are more than 1e90 apart",
                   selectLimb(complex, apart, {0, 0, 0}));
}

}  // namespace
}  // namespace espalier::shapes
