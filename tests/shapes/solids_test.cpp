// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/solids.h>

#include <numbers>

#include "lattice_checks.h"
#include "support/complexes.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

struct RegularCase {
    Lattice (*make)(const RegularSolidOptions&);
    Counts counts;
    std::size_t faceSize;
    std::size_t valence;
    double volume;  ///< if the vertices are on the unit sphere
};

TEST(Solids, AreThePlatonicSolids) {
    const double s5 = std::sqrt(5.0);
    // Volumes by edge length a: tetrahedron a³/(6√2), a = √(8/3); cube a³, a = 2/√3; octahedron
    // a³√2/3, a = √2; dodecahedron (15 + 7√5) a³/4, a = 4/(√3 (1 + √5)); icosahedron
    // 5 (3 + √5) a³/12, a = 4/√(10 + 2√5).
    const RegularCase cases[] = {
        {tetrahedron, {4, 6, 4, 1}, 3, 3, std::pow(8.0 / 3, 1.5) / (6 * std::sqrt(2.0))},
        {cube, {8, 12, 6, 1}, 4, 3, std::pow(2 / std::sqrt(3.0), 3)},
        {octahedron, {6, 12, 8, 1}, 3, 4, 4.0 / 3},
        {dodecahedron,
         {20, 30, 12, 1},
         5,
         3,
         (15 + 7 * s5) / 4 * std::pow(4 / (std::sqrt(3.0) * (1 + s5)), 3)},
        {icosahedron,
         {12, 30, 20, 1},
         3,
         5,
         5 * (3 + s5) / 12 * std::pow(4 / std::sqrt(10 + 2 * s5), 3)},
    };
    for (const RegularCase& solid : cases) {
        const Lattice lattice = solid.make({2});
        EXPECT_EQ(countsOf(lattice.complex), solid.counts);
        EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
        for (Index face = 0; face < lattice.complex.count(2); ++face)
            EXPECT_EQ(lattice.complex.relation(2, 0)[face].size(), solid.faceSize);
        for (Index vertex = 0; vertex < lattice.complex.count(0); ++vertex) {
            EXPECT_EQ(valenceInCell(lattice.complex, 0, vertex), solid.valence);
            EXPECT_NEAR(norm(at(lattice, vertex)), 2, kRounding);
        }
        EXPECT_NEAR(totalVolume(lattice), 8 * solid.volume, kRounding * 8);
        expectValid(lattice);
    }
}

TEST(Solids, StandOnPolygons) {
    for (const int n : {3, 4, 5, 9}) {
        const double base =
            n * std::sin(2 * std::numbers::pi / n) / 2 * 0.25;  // a regular n-gon of radius 0.5
        const PolygonalSolidOptions options = {n, 0.5, 3};
        const Lattice onPrism = prism(options);
        EXPECT_EQ(countsOf(onPrism.complex), (Counts{2 * n, 3 * n, n + 2, 1}));
        EXPECT_NEAR(totalVolume(onPrism), 3 * base, kRounding);
        expectValid(onPrism);

        const Lattice onPyramid = pyramid(options);
        EXPECT_EQ(countsOf(onPyramid.complex), (Counts{n + 1, 2 * n, n + 1, 1}));
        EXPECT_NEAR(totalVolume(onPyramid), base, kRounding);
        EXPECT_EQ(valenceInCell(onPyramid.complex, 0, n), std::size_t(n));
        expectValid(onPyramid);

        const Lattice onBoth = bipyramid(options);
        EXPECT_EQ(countsOf(onBoth.complex), (Counts{n + 2, 3 * n, 2 * n, 1}));
        EXPECT_NEAR(totalVolume(onBoth), base, kRounding);
        EXPECT_EQ(valenceInCell(onBoth.complex, 0, n), std::size_t(n));
        EXPECT_EQ(valenceInCell(onBoth.complex, 0, n + 1), std::size_t(n));
        EXPECT_EQ(at(onBoth, n), (Point3{0, 0, -1.5}));
        EXPECT_EQ(at(onBoth, n + 1), (Point3{0, 0, 1.5}));
        expectValid(onBoth);
    }
}

TEST(Solids, BecomeTypeNCells) {
    // MacCracken & Joy 1996, section 2.2: a vertex of valence n becomes a cell of 2n quadrilaterals
    // (with 2n + 2 vertices: 2 of valence n and 2n of valence 3; the paper says 2n − 2).
    TopologyRefiner refiner = test::refined(icosahedron().complex, 1);
    const CellComplex& refined = refiner.level(1).complex;
    EXPECT_EQ(refined.count(3), 12);
    for (Index cell = 0; cell < refined.count(3); ++cell) {
        EXPECT_EQ(refined.relation(3, 2)[cell].size(), 10U);
        EXPECT_EQ(refined.relation(3, 0)[cell].size(), 12U);
    }
}

}  // namespace
}  // namespace espalier::shapes
