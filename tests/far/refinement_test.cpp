// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_refiner.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

/// The number of incident pairs for each two dimensions of a complex.
struct Incidences {
    Offset pairs[4][4];
    explicit Incidences(const CellComplex& complex) {
        for (int upper = 0; upper <= 3; ++upper)
            for (int lower = 0; lower <= upper; ++lower)
                pairs[lower][upper] = upper > complex.dimension()
                                          ? 0
                                          : Offset(complex.relation(upper, lower).values().size());
    }
};

/// Checks the number of children under boundary control: the children are the intervals.
void expectCountsOfIntervals(const TopologyRefiner& refiner) {
    for (int level = 1; level <= refiner.maxLevel(); ++level) {
        const Incidences parent(refiner.level(level - 1).complex);
        const CellComplex& child = refiner.level(level).complex;
        for (int d = 0; d <= refiner.dimension(); ++d) {
            Offset expected = 0;
            for (int lower = 0; lower + d <= refiner.dimension(); ++lower)
                expected += parent.pairs[lower][lower + d];
            EXPECT_EQ(child.count(d), expected) << "level " << level << " dimension " << d;
        }
        EXPECT_EQ(child.eulerCharacteristic(), refiner.level(0).complex.eulerCharacteristic());
        EXPECT_NO_THROW(validate(child));
    }
}

TEST(Refinement, CountsEulerCharacteristicAndValidityAtEveryLevel) {
    for (const CellComplex& base :
         {singleCell(StandardCell::Tetrahedron), singleCell(StandardCell::Pyramid),
          singleCell(StandardCell::Wedge), singleCell(StandardCell::Hexahedron), bipyramid(3),
          bipyramid(5), bipyramid(6), grid({3, 2, 1}), gridMesh(3, 2), buildCurve(4, false),
          buildCurve(4, true),
          // Faces that pass a vertex more than once, and a vertex in no face.
          buildMesh(6, Loops{{0, 1, 2, 2}, {1, 0, 3, 4}}),
          buildMesh(5, Loops{{0, 1, 0, 2}, {1, 0, 3, 4}}), buildMesh(1, Loops{{0, 0, 0, 0}})}) {
        TopologyRefiner refiner = refined(base, 3);
        expectCountsOfIntervals(refiner);
    }
}

// Curves: n segments become 2n. Meshes: a face of n edges becomes n quadrilaterals. Lattices: a
// hexahedron becomes 8. The number of cells of a lattice grows about eightfold per level
// (MacCracken & Joy, section 6, say that it "nearly triples").
TEST(Refinement, GrowthPerLevel) {
    TopologyRefiner curve(buildCurve(5, false)), mesh(gridMesh(2, 3)), lattice(grid({2, 1, 3}));
    curve.refineUniform(3);
    mesh.refineUniform(3);
    lattice.refineUniform(3);
    for (int level = 0; level <= 3; ++level) {
        EXPECT_EQ(curve.level(level).complex.count(1), 4 << level);
        EXPECT_EQ(mesh.level(level).complex.count(2), 6 << (2 * level));
        EXPECT_EQ(lattice.level(level).complex.count(3), 6 << (3 * level));
    }
}

/// Number of edges of `cell` at `vertex`.
Index valenceIn(const CellComplex& complex, Index cell, Index vertex) {
    Index valence = 0;
    for (const Index edge : complex.relation(3, 1)[cell])
        valence += contains(complex.relation(1, 0)[edge], vertex);
    return valence;
}

/// Returns the number of cells of each type n, where 2n is the number of faces.
std::map<Index, Index> typesOf(const CellComplex& complex) {
    std::map<Index, Index> types;
    for (Index cell = 0; cell < complex.count(3); ++cell)
        ++types[Index(complex.relation(3, 2)[cell].size()) / 2];
    return types;
}

// MacCracken & Joy 1996, section 2.2: a vertex of valence n in its cell gives a type-n cell of 2n
// quadrilaterals, with 2 vertices of valence n and 2n of valence 3 (the paper prints 2n − 2: for
// the hexahedron, n = 3, that would be 6 vertices in all).
TEST(Refinement, VertexOfValenceNGivesATypeNCell) {
    for (Index n = 3; n <= 8; ++n) {
        TopologyRefiner refiner = refined(bipyramid(n), 1);
        const CellComplex& child = refiner.level(1).complex;
        const CellComplex& base = refiner.level(0).complex;
        for (Index cell = 0; cell < child.count(3); ++cell) {
            const Interval parent = refiner.refinement(1).parentOf({3, cell});
            EXPECT_EQ(parent.upper, (Entity{3, 0}));
            const Index valence = valenceIn(base, 0, parent.lower.index);
            const auto faces = child.relation(3, 2)[cell];
            EXPECT_EQ(faces.size(), std::size_t(2 * valence));
            for (const Index face : faces) EXPECT_EQ(child.relation(2, 0)[face].size(), 4u);
            const auto vertices = child.relation(3, 0)[cell];
            EXPECT_EQ(vertices.size(), std::size_t(2 * valence + 2));
            std::map<Index, Index> byValence;
            for (const Index vertex : vertices) ++byValence[valenceIn(child, cell, vertex)];
            const std::map<Index, Index> expected =
                valence == 3 ? std::map<Index, Index>{{3, 8}}
                             : std::map<Index, Index>{{valence, 2}, {3, 2 * valence}};
            EXPECT_EQ(byValence, expected);
        }
    }
}

// A type-n cell refines into 2 type-n cells and 2n hexahedra (the paper prints 2n − 2), so for n >
// 3 the number of type-n cells doubles at each level. A bipyramid has two vertices of valence n and
// n of valence 4.
TEST(Refinement, TypeNCellsDoubleAtEachLevel) {
    for (const Index n : {3, 5, 6, 7}) {
        TopologyRefiner refiner = refined(bipyramid(n), 4);
        for (int level = 1; level <= 4; ++level) {
            auto types = typesOf(refiner.level(level).complex);
            const Index doubled = Index{1} << (level - 1);
            EXPECT_EQ(types[4], n * doubled);
            if (n != 3) {
                EXPECT_EQ(types[n], 2 * doubled);
            }
            if (level == 1) continue;
            // Hexahedra: 8 from each hexahedron, and 2m from each type-m cell of the level before.
            auto before = typesOf(refiner.level(level - 1).complex);
            Index hexahedra = 8 * before[3];
            for (const auto& [m, count] : before)
                if (m != 3) hexahedra += 2 * m * count;
            EXPECT_EQ(types[3], hexahedra);
        }
    }
}

TEST(Refinement, ParentAndChildMapsAreInverse) {
    for (const CellComplex& base : {bipyramid(5), grid({2, 2, 1}), gridMesh(2, 2)}) {
        TopologyRefiner refiner = refined(base, 2);
        for (int level = 1; level <= 2; ++level) {
            const Refinement& refinement = refiner.refinement(level);
            for (int d = 0; d <= refiner.dimension(); ++d)
                for (Index i = 0; i < refinement.child().count(d); ++i) {
                    const Interval parent = refinement.parentOf({d, i});
                    EXPECT_EQ(parent.upper.dimension - parent.lower.dimension, d);
                    EXPECT_EQ(refinement.childOf(parent), (Entity{d, i}));
                }
        }
    }
    const TopologyRefiner refiner = [] {
        TopologyRefiner r = refined(grid({2, 1, 1}), 1);
        return r;
    }();
    // Vertex 0 is in cell 0 only.
    EXPECT_TRUE(refiner.refinement(1).childOf({{0, 0}, {3, 0}}));
    EXPECT_FALSE(refiner.refinement(1).childOf({{0, 0}, {3, 1}}));
    EXPECT_FALSE(refiner.refinement(1).childOf({{3, 0}, {0, 0}}));
}

// The order that the header documents: vertex points, edge points, face points, cell points.
TEST(Refinement, VerticesAreNumberedByTheDimensionOfTheirParent) {
    TopologyRefiner refiner = refined(bipyramid(4), 1);
    const CellComplex& base = refiner.level(0).complex;
    Index child = 0;
    for (int d = 0; d <= 3; ++d)
        for (Index i = 0; i < base.count(d); ++i, ++child)
            EXPECT_EQ(refiner.refinement(1).parentOf({0, child}), (Interval{{d, i}, {d, i}}));
}

// A child cell [v,c] contains the points of its interval: the points of the entities between v and
// c.
TEST(Refinement, ChildCellHoldsThePointsOfItsInterval) {
    TopologyRefiner refiner = refined(bipyramid(5), 1);
    const CellComplex& base = refiner.level(0).complex;
    const Refinement& refinement = refiner.refinement(1);
    for (Index cell = 0; cell < refinement.child().count(3); ++cell) {
        const Entity v = refinement.parentOf({3, cell}).lower;
        std::set<Index> expected;
        const auto add = [&](Entity entity) {
            expected.insert(refinement.childOf({entity, entity})->index);
        };
        add(v);
        add({3, 0});
        for (int d = 1; d <= 2; ++d)
            for (const Index part : base.relation(0, d)[v.index]) add({d, part});
        EXPECT_EQ(vertexSet(refinement.child(), cell), expected);
    }
}

// Without boundary control, an i×j×k lattice keeps 2(i−1) × 2(j−1) × 2(k−1) cells.
TEST(Refinement, OpenKeepsTheIntervalsAboveInteriorVertices) {
    TopologyRefiner refiner = refined(grid({3, 4, 2}), 3, {.boundary = Boundary::Open});
    std::array<Index, 3> n = {3, 4, 2};
    for (int level = 1; level <= 3; ++level) {
        for (Index& cells : n) cells = 2 * (cells - 1);
        const CellComplex expected = grid(n);
        for (int d = 0; d <= 3; ++d)
            EXPECT_EQ(refiner.level(level).complex.count(d), expected.count(d));
        EXPECT_NO_THROW(validate(refiner.level(level).complex));
    }
}

TEST(Refinement, OpenRefusesALatticeWithoutInteriorVertex) {
    TopologyRefiner refiner(grid({1, 2, 2}), {.boundary = Boundary::Open});
    EXPECT_EQ(causeOf([&] { refiner.refineUniform(1); }), TopologyCause::EmptyComplex);
    EXPECT_EQ(refiner.maxLevel(), 0);
}

TEST(Refinement, MissingLevelsAreRefused) {
    TopologyRefiner refiner = refined(bipyramid(3), 2);
    EXPECT_THROW(refiner.level(3), espalier::Error);
    EXPECT_THROW(refiner.level(-1), espalier::Error);
    EXPECT_THROW(refiner.refinement(0), espalier::Error);
    EXPECT_THROW(refiner.refinement(3), espalier::Error);
    refiner.refineUniform(1);
    EXPECT_EQ(refiner.maxLevel(), 2) << "levels that are there stay";
}

// Face loops start at the point of the lower end. So the diagonal from there to the upper end does
// not depend on the numbering. The tetrahedra of type-n cells rely on this.
TEST(Refinement, LoopsRunFromTheLowerToTheUpperEnd) {
    TopologyRefiner refiner = refined(bipyramid(5), 2);
    for (int level = 1; level <= 2; ++level) {
        const Refinement& refinement = refiner.refinement(level);
        for (Index face = 0; face < refinement.child().count(2); ++face) {
            const Interval parent = refinement.parentOf({2, face});
            const auto loop = refinement.child().relation(2, 0)[face];
            EXPECT_EQ(refinement.parentOf({0, loop[0]}).lower, parent.lower);
            EXPECT_EQ(refinement.parentOf({0, loop[2]}).lower, parent.upper);
        }
    }
}

}  // namespace
}  // namespace espalier::far
