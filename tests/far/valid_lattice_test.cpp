// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_error.h>
#include <espalier/far/topology_refiner.h>

#include <array>
#include <random>
#include <vector>

#include "far/valid_lattice.h"
#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

using SignedRow = std::vector<Signed>;

/// The relations of a lattice, to be changed at random.
struct Relations {
    Index vertexCount;
    std::array<std::vector<SignedRow>, 3> rows;  ///< per dimension − 1

    explicit Relations(const CellComplex& complex) : vertexCount(complex.count(0)) {
        for (int d = 1; d <= 3; ++d)
            for (Index index = 0; index < complex.count(d); ++index) {
                SignedRow& row = rows[std::size_t(d) - 1].emplace_back();
                for (std::size_t i = 0; i < complex.boundary(d)[index].size(); ++i)
                    row.push_back(
                        {complex.boundary(d)[index][i], complex.boundary(d).signs(index)[i]});
            }
    }

    CellComplex complex() const {
        CellComplex::Boundaries boundaries;
        for (std::size_t d = 0; d < 3; ++d) {
            Rows<Signed> all;
            for (const SignedRow& row : rows[d]) {
                all.values.insert(all.values.end(), row.begin(), row.end());
                all.offsets.push_back(Offset(all.values.size()));
            }
            boundaries[d] = SignedIncidence(all);
        }
        return CellComplex(3, vertexCount, boundaries);
    }

    void change(std::mt19937& random) {
        const auto below = [&](std::size_t count) { return random() % count; };
        const std::size_t d = below(3);
        const std::size_t at = below(rows[d].size());
        SignedRow& row = rows[d][at];
        if (row.empty()) return;
        const std::size_t i = below(row.size());
        switch (below(9)) {
            case 0:  // often an entity that exists
                row[i].index = Index(below(d == 0 ? vertexCount + 2 : rows[d - 1].size() + 2)) - 1;
                break;
            case 1:
                row[i].sign = std::int8_t(-row[i].sign);
                break;
            case 2:
                row.erase(row.begin() + std::ptrdiff_t(i));
                break;
            case 3:
                row.push_back(row[i]);
                break;
            case 4:
                std::swap(row[i], row[below(row.size())]);
                break;
            case 5:  // for a face or a cell no damage
                std::rotate(row.begin(), row.begin() + std::ptrdiff_t(i), row.end());
                break;
            case 6:
                rows[d].push_back(SignedRow(row));
                break;
            case 7:  // a third cell, or the same cell from the other side
                for (Signed& entry : row) entry.sign = std::int8_t(-entry.sign);
                rows[d].push_back(SignedRow(row));
                break;
            default:  // two vertices become one
                for (SignedRow& edge : rows[0])
                    for (Signed& end : edge)
                        if (end.index == row[i].index) end.index = 0;
        }
    }
};

bool isAcceptedSlowly(const CellComplex& complex) {
    try {
        requireValid(complex);
        return true;
    } catch (const TopologyError&) {
        return false;
    }
}

TEST(ValidLattice, AgreesWithTheSlowCheck) {
    TopologyRefiner refiner(mixedCells());
    refiner.refineUniform(1);
    const std::vector<CellComplex> all = {singleCell(StandardCell::Tetrahedron),
                                          grid({2, 1, 1}),
                                          grid({3, 3, 3}),
                                          bipyramid(5),
                                          bipyramid(40),
                                          mixedCells(),
                                          refiner.level(1).complex};
    std::mt19937 random(1);
    std::array<int, 2> counts = {0, 0};  // refused, accepted
    for (const CellComplex& original : all) {
        EXPECT_TRUE(isValidLattice(original));
        for (int trial = 0; trial < 200; ++trial) {
            Relations relations(original);
            for (int changes = 1 + trial % 3; changes > 0; --changes) relations.change(random);
            const CellComplex changed = relations.complex();
            const bool isAccepted = isAcceptedSlowly(changed);
            EXPECT_EQ(isValidLattice(changed), isAccepted) << trial;
            ++counts[isAccepted];
        }
    }
    EXPECT_GT(counts[0], 500);
    EXPECT_GT(counts[1], 50);
}

TEST(ValidLattice, IsNoCurveAndNoMesh) {
    EXPECT_FALSE(isValidLattice(buildCurve(3, true)));
    EXPECT_FALSE(isValidLattice(gridMesh(2, 2)));
    EXPECT_FALSE(isValidLattice(CellComplex()));
}

}  // namespace
}  // namespace espalier::far
