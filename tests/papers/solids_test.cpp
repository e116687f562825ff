// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>

#include "support/random_lattices.h"
#include "support/rows.h"
#include "support/test.h"

// Catmull-Clark solids: CSE-96-1, sections 4 and 6; MacCracken & Joy 1996, sections 2.2 and 3.
namespace espalier::stencils {
namespace {

/// Computes the points of a lattice of polyhedra by the rules of the papers, from faces and cells
/// only: independent of strata and masks.
class Solid {
public:
    explicit Solid(const CellComplex& complex) : complex_(complex) {}

    /// True if the entity belongs to a face of a single cell.
    bool isOnBoundary(Entity entity) const {
        for (const Index face : around(entity, 2))
            if (around({2, face}, 3).size() == 1) return true;
        return false;
    }

    /// The rules inside a lattice: CSE-96-1, section 6, and MacCracken & Joy, section 2.2.
    Row inside(Rules rules, Entity entity) const {
        Row own = centroid(complex_, entity);
        if (entity.dimension == 3) return own;
        const Row c = averageAround(entity, 3);
        if (entity.dimension == 2) {
            // (C0 + 2A + C1)/4
            EXPECT_EQ(around(entity, 3).size(), 2u);
            return (2 * c + 2 * own) / 4;
        }
        const Row a = averageAround(entity, 2);
        if (entity.dimension == 1) {
            const auto n = double(around(entity, 2).size());
            return rules == Rules::Cse96 ? (c + 2 * a + own) / 4 : (c + 2 * a + (n - 3) * own) / n;
        }
        return (c + 3 * a + 3 * averageAround(entity, 1) + own) / 8;
    }

    /// The rules of section 3: corners stay, sharp edges are cubic B-spline curves, and the rest of
    /// the boundary is a Catmull-Clark surface.
    Row onBoundary(Entity entity) const {
        Row own = centroid(complex_, entity);
        if (entity.dimension == 2) return own;
        if (entity.dimension == 1) {
            if (isSharp(entity.index)) return own;
            const std::vector<Index> faces = onSurface(entity, 2);
            EXPECT_EQ(faces.size(), 2u);
            return (centroids(2, faces) + own) / 2;
        }
        std::vector<Row> neighbours;
        for (const Index edge : onSurface(entity, 1))
            if (isSharp(edge)) neighbours.push_back(2 * centroid(complex_, {1, edge}) + -1 * own);
        if (around(entity, 3).size() == 1 || neighbours.size() > 2) return own;
        if (neighbours.size() == 2) return (neighbours[0] + 6 * own + neighbours[1]) / 8;
        const std::vector<Index> edges = onSurface(entity, 1);
        const auto n = double(edges.size());
        return (centroids(2, onSurface(entity, 2)) + 2 * centroids(1, edges) + (n - 3) * own) / n;
    }

private:
    std::span<const Index> around(Entity entity, int dimension) const {
        return complex_.relation(entity.dimension, dimension)[entity.index];
    }
    Row centroids(int dimension, std::span<const Index> entities) const {
        std::vector<Row> rows;
        for (const Index entity : entities) rows.push_back(centroid(complex_, {dimension, entity}));
        return average(rows);
    }
    Row averageAround(Entity entity, int dimension) const {
        return centroids(dimension, around(entity, dimension));
    }
    std::vector<Index> onSurface(Entity entity, int dimension) const {
        std::vector<Index> found;
        for (const Index other : around(entity, dimension)) {
            const bool isThere = dimension == 2 ? around({2, other}, 3).size() == 1
                                                : isOnBoundary({dimension, other});
            if (isThere) found.push_back(other);
        }
        return found;
    }
    /// True for a boundary edge in one cell (far::SharpEdges::SingleCell, which differs from the
    /// paper's words).
    bool isSharp(Index edge) const { return around({1, edge}, 3).size() == 1; }

    const CellComplex& complex_;
};

/// Returns lattices with inner edges of 3, 5 and more faces, and cells of all types, without marks.
std::vector<NamedLattice> irregularLattices() {
    std::vector<NamedLattice> all;
    for (const auto& lattices : {zoo(), featureLattices()})
        for (const auto& named : lattices)
            if (named.lattice.marks.empty()) all.push_back(named);
    for (unsigned seed = 0; seed < 40; seed += 4)  // The ones without marks.
        all.push_back({"seed " + std::to_string(seed), randomLattice(seed)});
    return all;
}

// Checks every point inside lattices of any topology, for both editions. On level 2 cells are of
// type n, and most points are inside.
TEST(Solids, PointsInsideFollowTheRules) {
    Index count = 0;
    for (const auto& [name, lattice] : irregularLattices()) {
        for (const Rules rules : {Rules::Siggraph96, Rules::Cse96}) {
            const TopologyRefiner refiner = refined(lattice.complex, 2, {.rules = rules});
            for (int level = 1; level <= 2; ++level) {
                const Solid solid(refiner.level(level - 1).complex);
                const auto table = buildLevelTable(refiner, level);
                for (Index vertex = 0; vertex < table.rowCount(); ++vertex) {
                    const Entity parent = parentOf(refiner, level, vertex);
                    if (solid.isOnBoundary(parent)) continue;
                    // Averages of averages: about a hundred terms that sum to 1, or to 2 where
                    // weights are negative.
                    ASSERT_LE(difference(rowOf(table, vertex), solid.inside(rules, parent)), 4e-15)
                        << name << " level " << level << " vertex " << vertex;
                    ++count;
                }
            }
        }
    }
    EXPECT_GT(count, shownBySome(10000));
}

// Checks section 3 of MacCracken & Joy for each point on the boundary.
// Boundary.RefinesAsItsMeshDoes checks it for whole surfaces.
TEST(Solids, PointsOnTheBoundaryFollowTheRules) {
    const std::set<std::string> unmarked = {
        "cube",        "bar",     "box",  "cylinder",   "cylinder with rings",
        "star",        "barbell", "arm",  "octahedron", "dodecahedron",
        "mixed cells", "L",       "torus"};
    std::size_t seen = 0;
    for (const auto& [name, lattice] : zoo()) {
        if (unmarked.count(name) == 0) continue;
        ++seen;
        const TopologyRefiner refiner = refined(lattice.complex, 1);
        const Solid solid(lattice.complex);
        const auto table = buildLevelTable(refiner, 1);
        for (Index vertex = 0; vertex < table.rowCount(); ++vertex) {
            const Entity parent = parentOf(refiner, 1, vertex);
            if (!solid.isOnBoundary(parent)) continue;
            // About fifty terms that sum to 1.
            ASSERT_LE(difference(rowOf(table, vertex), solid.onBoundary(parent)), 2e-15)
                << name << " vertex " << vertex;
        }
    }
    EXPECT_GE(seen, std::size_t(shownBySome(int(unmarked.size()))));
}

// The edge rules of the two papers are (C + 2A + M)/4 and (C + 2A + (n − 3)M)/n. So the rows differ
// at inner edges unless these have four faces, and nowhere else.
TEST(Solids, EditionsDifferOnlyAtInnerEdgesWithoutFourFaces) {
    std::set<std::size_t> valences;
    for (const auto& [name, lattice] : irregularLattices()) {
        const TopologyRefiner refiner = refined(lattice.complex, 2);
        const TopologyRefiner cseRefiner = withRules(refiner, Rules::Cse96);
        for (int level = 1; level <= 2; ++level) {
            const auto& [complex, strata, holes] = refiner.level(level - 1);
            const auto siggraph = buildLevelTable(refiner, level);
            const auto cse = buildLevelTable(cseRefiner, level);
            for (Index vertex = 0; vertex < siggraph.rowCount(); ++vertex) {
                const Entity parent = parentOf(refiner, level, vertex);
                bool isOther = parent.dimension == 1 && strata.of(parent) == 3;
                if (isOther) {
                    const std::size_t n = complex.relation(1, 2)[parent.index].size();
                    isOther = n != 4;
                    if (isOther) valences.insert(n);
                }
                const bool differ = difference(rowOf(siggraph, vertex), rowOf(cse, vertex)) > 0;
                ASSERT_EQ(differ, isOther) << name << " level " << level << " vertex " << vertex;
            }
        }
    }
    for (const std::size_t n : {3u, 5u, 6u}) EXPECT_EQ(valences.count(n), 1u) << n;
}

// The connectivity of both papers, and of Azlan & Misro for meshes: a new cell point is joined to
// the new face points of its faces, these to the new edge points of their edges, and these to the
// new vertex points of their ends. There are no other edges.
TEST(Solids, NewPointsAreJoinedAsThePapersSay) {
    for (const CellComplex& base :
         {mixedCells(), bipyramid(5), grid({2, 1, 2}), gridMesh(3, 2),
          far::buildMesh(4, far::faceLoops(far::StandardCell::Tetrahedron)),
          far::buildCurve(5, true)}) {
        const TopologyRefiner refiner = refined(base, 2);
        for (int level = 1; level <= 2; ++level) {
            const CellComplex& old = refiner.level(level - 1).complex;
            const CellComplex& child = refiner.level(level).complex;
            std::set<std::pair<Index, Index>> expected, got;
            for (int d = 1; d <= old.dimension(); ++d)
                for (Index whole = 0; whole < old.count(d); ++whole)
                    for (const Index part : old.relation(d, d - 1)[whole])
                        expected.insert(std::minmax(pointOf(refiner, level, {d, whole}),
                                                    pointOf(refiner, level, {d - 1, part})));
            for (Index edge = 0; edge < child.count(1); ++edge) {
                const auto ends = child.relation(1, 0)[edge];
                got.insert(std::minmax(ends[0], ends[1]));
            }
            EXPECT_EQ(got, expected);
            EXPECT_EQ(got.size(), std::size_t(child.count(1)));
        }
    }
}

// MacCracken & Joy, section 2.2: "after a few subdivisions, the bulk of the lattice will consist of
// type-3 cells arranged in a regular pattern". Irregular edges are inner edges without four faces.
// They are on curves through the points of the first faces and cells. So from level 1 on their
// number doubles with each level, while the number of all edges grows eightfold: their share falls
// to a quarter.
TEST(Solids, BulkIsRegularAfterAFewSubdivisions) {
    for (const CellComplex& base : {mixedCells(), shapes::icosahedron().complex, bipyramid(6),
                                    shapes::cylinder({.layers = 2}).complex}) {
        const TopologyRefiner refiner = refined(base, 4);
        Index irregularBefore = 0;
        double shareBefore = 0;
        for (int level = 1; level <= 4; ++level) {
            const CellComplex& complex = refiner.level(level).complex;
            const Solid solid(complex);
            Index inner = 0, irregular = 0;
            for (Index edge = 0; edge < complex.count(1); ++edge) {
                if (solid.isOnBoundary({1, edge})) continue;
                ++inner;
                irregular += complex.relation(1, 2)[edge].size() != 4;
            }
            const double share = double(irregular) / inner;
            EXPECT_GT(irregular, 0);
            if (level > 1) {
                EXPECT_EQ(irregular, 2 * irregularBefore);
                // A quarter in the limit; a lattice of few cells has fewer edges inside.
                EXPECT_LT(share, 0.26 * shareBefore);
            }
            irregularBefore = irregular;
            shareBefore = share;
        }
        EXPECT_LT(shareBefore, 0.01);
    }
}

}  // namespace
}  // namespace espalier::stencils
