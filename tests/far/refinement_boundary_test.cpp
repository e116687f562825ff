// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/refinement.h>

#include "support/complexes.h"
#include "support/test.h"

// Tests the boundaries of children against the definition, computed slowly:
//
//     ∂[a,b] = Σ σ(b,b') [a,b']  +  (−1)^d Σ σ(a',a) [a',b],   d = dim b − dim a
namespace espalier::far {
namespace {

/// Returns σ(whole, part), or 0 if the part does not bound the whole.
int signOf(const CellComplex& complex, Entity whole, Index part) {
    const auto row = complex.boundary(whole.dimension)[whole.index];
    const auto at = std::find(row.begin(), row.end(), part) - row.begin();
    return at == std::ssize(row) ? 0 : complex.boundary(whole.dimension).signs(whole.index)[at];
}

bool isIn(const CellComplex& complex, Entity part, Entity whole) {
    return contains(complex.relation(whole.dimension, part.dimension)[whole.index], part.index);
}

std::map<Index, int> boundaryByDefinition(const CellComplex& parent, const Refinement& refinement,
                                          const Interval& interval) {
    const auto& [a, b] = interval;
    std::map<Index, int> boundary;
    for (const Index part : parent.relation(b.dimension, b.dimension - 1)[b.index]) {
        const Entity below{b.dimension - 1, part};
        if (below.dimension >= a.dimension && isIn(parent, a, below))
            boundary[refinement.childOf({a, below}).value().index] = signOf(parent, b, part);
    }
    const int turn = (b.dimension - a.dimension) % 2 == 0 ? 1 : -1;
    for (const Index whole : parent.relation(b.dimension, a.dimension + 1)[b.index]) {
        const Entity above{a.dimension + 1, whole};
        if (const int sign = signOf(parent, above, a.index); sign != 0)
            boundary[refinement.childOf({above, b}).value().index] = turn * sign;
    }
    return boundary;
}

void expectDefinition(const CellComplex& parent, const Refinement& refinement) {
    const CellComplex& child = refinement.child();
    refinement.forEachChild([&](const Entity& entity, const Interval& interval) {
        if (entity.dimension == 0) return;
        const auto row = child.boundary(entity.dimension)[entity.index];
        const auto signs = child.boundary(entity.dimension).signs(entity.index);
        std::map<Index, int> got;
        for (std::size_t i = 0; i < row.size(); ++i) got[row[i]] = signs[i];
        EXPECT_EQ(got.size(), row.size());
        EXPECT_EQ(got, boundaryByDefinition(parent, refinement, interval))
            << entity.dimension << " " << entity.index;
    });
}

std::vector<CellComplex> bases() {
    return {singleCell(StandardCell::Tetrahedron),
            singleCell(StandardCell::Pyramid),
            bipyramid(5),
            bipyramid(20),  // with more vertices than placeInRow() scans
            grid({3, 2, 2}),
            mixedCells(),
            gridMesh(3, 2),
            buildCurve(4, true)};
}

TEST(RefinementBoundary, AgreesWithTheDefinition) {
    for (const CellComplex& base : bases()) {
        const Refinement first(base);
        expectDefinition(base, first);
        expectDefinition(first.child(), Refinement(first.child()));
    }
}

/// Returns the intervals whose lower ends contain one of the chosen vertices: all of them, or only
/// those in the first two cells.
Refinement::Kept around(const CellComplex& complex, const std::vector<Index>& vertices,
                        bool inFirstCellsAlone) {
    Refinement::Kept kept;
    const int dimension = complex.dimension();
    for (int d = 0; d <= dimension; ++d)
        for (Index index = 0; index < complex.count(d); ++index) {
            kept.lower[d].push_back(
                std::any_of(vertices.begin(), vertices.end(), [&](Index vertex) {
                    return isIn(complex, {0, vertex}, {d, index});
                }));
            const auto cells = complex.relation(d, dimension)[index];
            kept.upper[d].push_back(
                !inFirstCellsAlone ||
                std::any_of(cells.begin(), cells.end(), [](Index cell) { return cell < 2; }));
        }
    return kept;
}

TEST(RefinementBoundary, AgreesWithTheDefinitionForPartialRefinement) {
    for (const CellComplex& base : bases())
        for (const std::vector<Index>& vertices :
             {std::vector<Index>{0}, std::vector<Index>{0, 1, 3}})
            for (const bool inFirstCellsAlone : {false, true}) {
                const auto kept = around(base, vertices, inFirstCellsAlone);
                expectDefinition(base, Refinement(base, &kept));
            }
}

// The kept children have the numbers of the whole refinement without gaps.
TEST(RefinementBoundary, KeptChildrenStayInOrder) {
    for (const CellComplex& base : bases()) {
        const auto kept = around(base, {0, 1, 2}, true);
        const Refinement whole(base), part(base, &kept);
        std::array<Index, 4> next = {};
        whole.forEachChild([&](const Entity&, const Interval& interval) {
            const auto child = part.childOf(interval);
            const auto& [a, b] = interval;
            const auto isMarked = [](const ByEntity<std::uint8_t>& marks, const Entity& end) {
                return marks[end.dimension][end.index] != 0;
            };
            ASSERT_EQ(child.has_value(), isMarked(kept.lower, a) && isMarked(kept.upper, b));
            if (!child) return;
            const int d = b.dimension - a.dimension;
            EXPECT_EQ(*child, (Entity{d, next[d]++}));
            EXPECT_EQ(part.parentOf(*child), interval);
        });
        for (int d = 0; d <= base.dimension(); ++d) EXPECT_EQ(part.child().count(d), next[d]);
    }
}

TEST(RefinementBoundary, ChildrenInheritFromTheirUpperEnds) {
    for (const CellComplex& base : bases()) {
        ByEntity<int> values;
        int next = 0;
        for (int d = 0; d <= base.dimension(); ++d)
            for (Index i = 0; i < base.count(d); ++i) values[d].push_back(next++);
        const auto kept = around(base, {2}, false);
        for (const Refinement& refinement : {Refinement(base), Refinement(base, &kept)}) {
            const auto inherited = refinement.inherit(values);
            refinement.forEachChild([&](const Entity& child, const Interval& interval) {
                EXPECT_EQ(inherited[child.dimension][child.index],
                          values[interval.upper.dimension][interval.upper.index]);
            });
        }
    }
}

/// Returns the same complex without the mark that a refinement made it.
CellComplex unmarked(const CellComplex& complex) {
    CellComplex::Boundaries boundaries;
    for (int d = 1; d <= complex.dimension(); ++d) boundaries[d - 1] = complex.boundary(d);
    return CellComplex(complex.dimension(), complex.count(0), boundaries);
}

void expectSameRelations(const CellComplex& complex, const CellComplex& expected) {
    for (int from = 0; from <= complex.dimension(); ++from)
        for (int to = 0; to <= complex.dimension(); ++to) {
            const Incidence &got = complex.relation(from, to), &rows = expected.relation(from, to);
            ASSERT_EQ(got.rowCount(), rows.rowCount());
            for (Index row = 0; row < rows.rowCount(); ++row)
                ASSERT_TRUE(std::ranges::equal(got[row], rows[row])) << from << to << " " << row;
        }
}

// Relations of refined complexes are written down; those of other complexes are collected from
// faces. Refining either gives the same child.
TEST(RefinementBoundary, RefinedComplexesHaveTheRelationsOfAnyComplex) {
    for (const CellComplex& base : bases()) {
        const auto kept = around(base, {0, 1, 2}, true);
        for (const Refinement& refinement : {Refinement(base), Refinement(base, &kept)}) {
            const CellComplex& child = refinement.child();
            EXPECT_TRUE(child.isRefined());
            EXPECT_FALSE(unmarked(child).isRefined());
            expectSameRelations(child, unmarked(child));
            expectSameRelations(Refinement(child).child(), Refinement(unmarked(child)).child());
        }
    }
}

TEST(Incidence, UniformRowsNeedNoOffsets) {
    const Incidence uniform = Incidence::uniform(3, {4, 5, 6, 1, 2, 0});
    Rows<Index> rows;
    rows.offsets = {0, 3, 6};
    rows.values = {4, 5, 6, 1, 2, 0};
    const Incidence stored(rows);
    for (const Incidence* each : {&uniform, &stored}) {
        EXPECT_EQ(each->rowCount(), 2);
        EXPECT_EQ((*each)[1][0], 1);
        EXPECT_EQ(each->offset(2), 6);
        EXPECT_EQ(each->rowOf(2), 0);
        EXPECT_EQ(each->rowOf(3), 1);
        EXPECT_EQ(each->transposed(7)[5].front(), 0);
        EXPECT_EQ(each->transposed(7)[3].size(), 0u);
    }
    // Empty rows are skipped.
    rows.offsets = {0, 0, 2, 2, 6};
    EXPECT_EQ(Incidence(rows).rowOf(0), 1);
    EXPECT_EQ(Incidence(rows).rowOf(1), 1);
    EXPECT_EQ(Incidence(rows).rowOf(2), 3);
}

}  // namespace
}  // namespace espalier::far
