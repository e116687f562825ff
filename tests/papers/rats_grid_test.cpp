// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>
#include <espalier/stencils/rats.h>

#include <functional>
#include <utility>

#include "papers/refined_grid.h"
#include "support/test.h"

// Savva & Clapworthy (003), section 2: the new points of n × m old points V_ij, with the printed
// equations, i from 1 to n and j from 1 to m.
namespace espalier::stencils {
namespace {

/// n × m old points, and their new points by RATS or Catmull-Clark.
class RefinedNet {
public:
    RefinedNet(Index countAlongI, Index countAlongJ, Rules rules = Rules::Rats)
        : n(countAlongI),
          m(countAlongJ),
          grid_({n - 1, m - 1}, 1, rules == Rules::Rats ? Boundary::Sharp : Boundary::Open, rules),
          table_(buildLevelTable(grid_.refiner(), 1)) {}

    const Index n, m;

    Row V(Index i, Index j) const { return grid_.at(0, {i - 1, j - 1}); }
    Row F(Index i, Index j) const {
        return (V(i, j) + V(i, j + 1) + V(i + 1, j) + V(i + 1, j + 1)) / 4;
    }

    /// The new point P_ij; indices start at 1.
    Index newPoint(Index i, Index j) const { return grid_.vertexAt(1, {i - 1, j - 1}); }
    Row P(Index i, Index j) const { return rowOf(table_, newPoint(i, j)); }

    Index newPointCount() const { return table_.rowCount(); }

    RatsPoint typeOf(Index i, Index j) const {
        return ratsPoint(grid_.refiner().level(0), grid_.parentAt(1, {i - 1, j - 1}));
    }

    /// The new points that were compared with an equation so far.
    std::multiset<Index>& seen() { return seen_; }

private:
    RefinedGrid grid_;
    StencilTable<double> table_;
    std::multiset<Index> seen_;
};

/// Sizes at which borders touch each other, and sizes at which all ten types occur.
std::vector<std::pair<Index, Index>> sizes() {
    return {{2, 2}, {2, 5}, {5, 2}, {3, 3}, {3, 4}, {4, 4}, {6, 5}};
}

void expectPoint(RefinedNet& net, RatsPoint type, Index i, Index j, const Row& expected) {
    EXPECT_EQ(net.typeOf(i, j), type) << "P_" << i << "," << j;
    // Sums of at most 16 products near 1: about 16 roundings of 1.1e-16.
    EXPECT_LT(difference(net.P(i, j), expected), 2e-15) << "P_" << i << "," << j;
    net.seen().insert(net.newPoint(i, j));
}

using Ends = std::vector<Index>;

/// 1 and n; only 1 if they are equal.
Ends ends(Index n) {
    return n == 1 ? Ends{1} : Ends{1, n};
}

void vAlpha(RefinedNet& net) {
    for (const Index i : ends(net.n))
        for (const Index j : ends(net.m))
            expectPoint(net, RatsPoint::VAlpha, 2 * i - 1, 2 * j - 1, net.V(i, j));  // Eq 4
}

void vBeta(RefinedNet& net) {
    const auto V = [&](Index i, Index j) { return net.V(i, j); };
    for (Index i = 2; i <= net.n - 1; ++i)
        for (const Index j : ends(net.m))
            expectPoint(net, RatsPoint::VBeta, 2 * i - 1, 2 * j - 1,
                        ((V(i - 1, j) + V(i, j)) / 2 + (V(i, j) + V(i + 1, j)) / 2) / 2);  // Eq 5
    for (const Index i : ends(net.n))
        for (Index j = 2; j <= net.m - 1; ++j)
            expectPoint(net, RatsPoint::VBeta, 2 * i - 1, 2 * j - 1,
                        ((V(i, j - 1) + V(i, j)) / 2 + (V(i, j) + V(i, j + 1)) / 2) / 2);  // Eq 6
}

void vGamma(RefinedNet& net) {
    const auto F = [&](Index i, Index j) { return net.F(i, j); };
    for (Index i = 2; i <= net.n - 1; ++i)
        for (Index j = 2; j <= net.m - 1; ++j)
            expectPoint(net, RatsPoint::VGamma, 2 * i - 1, 2 * j - 1,
                        (F(i - 1, j - 1) + F(i, j - 1) + F(i - 1, j) + F(i, j)) / 4);  // Eq 7
}

// In Eq 8 to 11, the P on the right side are old points: V.
void eAlpha(RefinedNet& net) {
    const auto V = [&](Index i, Index j) { return net.V(i, j); };
    for (const Index i : ends(net.n - 1))
        for (const Index j : ends(net.m))
            expectPoint(net, RatsPoint::EAlpha, 2 * i, 2 * j - 1,
                        (V(i, j) + V(i + 1, j)) / 2);  // Eq 8
    for (const Index i : ends(net.n))
        for (const Index j : ends(net.m - 1))
            expectPoint(net, RatsPoint::EAlpha, 2 * i - 1, 2 * j,
                        (V(i, j) + V(i, j + 1)) / 2);  // Eq 9
}

void eBeta(RefinedNet& net) {
    const auto V = [&](Index i, Index j) { return net.V(i, j); };
    for (Index i = 3; i <= net.n - 1; ++i)
        for (const Index j : ends(net.m))
            expectPoint(net, RatsPoint::EBeta, 2 * i - 2, 2 * j - 1,
                        ((V(i - 2, j) + V(i - 1, j)) / 2 + 2 * (V(i - 1, j) + V(i, j)) / 2 +
                         (V(i, j) + V(i + 1, j)) / 2) /
                            4);  // Eq 10
    for (const Index i : ends(net.n))
        for (Index j = 3; j <= net.m - 1; ++j)
            expectPoint(net, RatsPoint::EBeta, 2 * i - 1, 2 * j - 2,
                        ((V(i, j - 2) + V(i, j - 1)) / 2 + 2 * (V(i, j - 1) + V(i, j)) / 2 +
                         (V(i, j) + V(i, j + 1)) / 2) /
                            4);  // Eq 11
}

void eGamma(RefinedNet& net) {
    const auto F = [&](Index i, Index j) { return net.F(i, j); };
    for (Index i = 2; i <= net.n - 1; ++i)
        for (const Index j : ends(net.m - 1))
            expectPoint(net, RatsPoint::EGamma, 2 * i - 1, 2 * j,
                        (F(i - 1, j) + F(i, j)) / 2);  // Eq 12
    for (const Index i : ends(net.n - 1))
        for (Index j = 2; j <= net.m - 1; ++j)
            expectPoint(net, RatsPoint::EGamma, 2 * i, 2 * j - 1,
                        (F(i, j - 1) + F(i, j)) / 2);  // Eq 13
}

void eDelta(RefinedNet& net) {
    const auto F = [&](Index i, Index j) { return net.F(i, j); };
    for (Index i = 3; i <= net.n - 1; ++i)
        for (Index j = 2; j <= net.m - 1; ++j)
            expectPoint(net, RatsPoint::EDelta, 2 * i - 2, 2 * j - 1,
                        ((F(i - 2, j - 1) + F(i - 2, j) + F(i - 1, j - 1) + F(i - 1, j)) / 4 +
                         (F(i - 1, j - 1) + F(i - 1, j) + F(i, j - 1) + F(i, j)) / 4) /
                            2);  // Eq 14
    for (Index i = 2; i <= net.n - 1; ++i)
        for (Index j = 3; j <= net.m - 1; ++j)
            expectPoint(net, RatsPoint::EDelta, 2 * i - 1, 2 * j - 2,
                        ((F(i - 1, j - 2) + F(i, j - 2) + F(i - 1, j - 1) + F(i, j - 1)) / 4 +
                         (F(i - 1, j - 1) + F(i, j - 1) + F(i - 1, j) + F(i, j)) / 4) /
                            2);  // Eq 15
}

void fAlpha(RefinedNet& net) {
    for (const Index i : ends(net.n - 1))
        for (const Index j : ends(net.m - 1))
            expectPoint(net, RatsPoint::FAlpha, 2 * i, 2 * j, net.F(i, j));  // Eq 16
}

void fBeta(RefinedNet& net) {
    const auto F = [&](Index i, Index j) { return net.F(i, j); };
    for (Index i = 3; i <= net.n - 1; ++i)
        for (const Index j : ends(net.m - 1))
            expectPoint(
                net, RatsPoint::FBeta, 2 * i - 2, 2 * j,
                ((F(i - 2, j) + F(i - 1, j)) / 2 + (F(i - 1, j) + F(i, j)) / 2) / 2);  // Eq 17
    for (const Index i : ends(net.n - 1))
        for (Index j = 3; j <= net.m - 1; ++j)
            expectPoint(
                net, RatsPoint::FBeta, 2 * i, 2 * j - 2,
                ((F(i, j - 2) + F(i, j - 1)) / 2 + (F(i, j - 1) + F(i, j)) / 2) / 2);  // Eq 18
}

void fGamma(RefinedNet& net) {
    const auto F = [&](Index i, Index j) { return net.F(i, j); };
    for (Index i = 3; i <= net.n - 1; ++i)
        for (Index j = 3; j <= net.m - 1; ++j)
            expectPoint(
                net, RatsPoint::FGamma, 2 * i - 2, 2 * j - 2,
                ((F(i - 2, j - 2) + F(i - 2, j - 1) + F(i - 1, j - 2) + F(i - 1, j - 1)) / 4 +
                 (F(i - 1, j - 2) + F(i - 1, j - 1) + F(i, j - 2) + F(i, j - 1)) / 4 +
                 (F(i - 2, j - 1) + F(i - 2, j) + F(i - 1, j - 1) + F(i - 1, j)) / 4 +
                 (F(i - 1, j - 1) + F(i - 1, j) + F(i, j - 1) + F(i, j)) / 4) /
                    4);  // Eq 19
}

void forEachNet(const std::function<void(RefinedNet&)>& check) {
    bool isAnySeen = false;
    for (const auto& [n, m] : sizes()) {
        SCOPED_TRACE(std::to_string(n) + " × " + std::to_string(m));
        RefinedNet net(n, m);
        check(net);
        isAnySeen = isAnySeen || !net.seen().empty();
    }
    EXPECT_TRUE(isAnySeen);
}

TEST(RatsGrid, VAlphaCornerVertices) {
    forEachNet(vAlpha);
}
TEST(RatsGrid, VBetaBorderVertices) {
    forEachNet(vBeta);
}
TEST(RatsGrid, VGammaInnerVertices) {
    forEachNet(vGamma);
}
TEST(RatsGrid, EAlphaBorderEdgesWithACorner) {
    forEachNet(eAlpha);
}
TEST(RatsGrid, EBetaBorderEdges) {
    forEachNet(eBeta);
}
TEST(RatsGrid, EGammaInnerEdgesAtTheBorder) {
    forEachNet(eGamma);
}
TEST(RatsGrid, EDeltaInnerEdges) {
    forEachNet(eDelta);
}
TEST(RatsGrid, FAlphaFacesWithACorner) {
    forEachNet(fAlpha);
}
TEST(RatsGrid, FBetaFacesAtTheBorder) {
    forEachNet(fBeta);
}
TEST(RatsGrid, FGammaInnerFaces) {
    forEachNet(fGamma);
}

// Eq 4 to 19 give each of the (2n − 1)(2m − 1) new points exactly once.
TEST(RatsGrid, EquationsGiveEachNewPointOnce) {
    for (const auto& [n, m] : sizes()) {
        RefinedNet net(n, m);
        for (const auto& equations :
             {vAlpha, vBeta, vGamma, eAlpha, eBeta, eGamma, eDelta, fAlpha, fBeta, fGamma})
            equations(net);
        EXPECT_EQ(net.newPointCount(), (2 * n - 1) * (2 * m - 1));
        EXPECT_EQ(net.seen().size(), std::size_t(net.newPointCount()));
        for (Index point = 0; point < net.newPointCount(); ++point)
            EXPECT_EQ(net.seen().count(point), 1u) << n << " × " << m << " point " << point;
    }
}

// Section 2.1. A, B, C and D are face centroids: the subscripts of the P before them are misprints.
TEST(RatsGrid, CatmullClarkPointsOfTheSamePaper) {
    for (const auto& [n, m] : {std::pair<Index, Index>{4, 4}, {6, 5}}) {
        const RefinedNet net(n, m, Rules::Siggraph96);
        const auto V = [&](Index i, Index j) { return net.V(i, j); };
        const auto F = [&](Index i, Index j) { return net.F(i, j); };
        const auto expect = [&](Index i, Index j, const Row& expected) {
            EXPECT_LT(difference(net.P(i, j), expected), 2e-15) << i << ", " << j;
        };
        for (Index i = 2; i <= n; ++i)
            for (Index j = 2; j <= m; ++j)
                expect(2 * i - 3, 2 * j - 3,
                       (V(i - 1, j - 1) + V(i - 1, j) + V(i, j - 1) + V(i, j)) / 4);  // Eq 1
        for (Index i = 2; i <= n; ++i)
            for (Index j = 2; j <= m - 1; ++j) {
                const Row A = F(i - 1, j - 1), B = F(i - 1, j);
                expect(2 * i - 3, 2 * j - 2,
                       ((A + B) / 2 + (V(i - 1, j) + V(i, j)) / 2) / 2);  // 2a
            }
        for (Index i = 2; i <= n - 1; ++i)
            for (Index j = 2; j <= m; ++j) {
                const Row A = F(i - 1, j - 1), C = F(i, j - 1);
                // The paper prints (B + C)/2, but the faces at the edge are A and C.
                expect(2 * i - 2, 2 * j - 3,
                       ((A + C) / 2 + (V(i, j - 1) + V(i, j)) / 2) / 2);  // 2b
            }
        for (Index i = 2; i <= n - 1; ++i)
            for (Index j = 2; j <= m - 1; ++j) {
                const Row A = F(i - 1, j - 1), B = F(i - 1, j), C = F(i, j - 1), D = F(i, j);
                const Row E = ((V(i, j) + V(i, j - 1)) / 2 + (V(i, j) + V(i, j + 1)) / 2 +
                               (V(i, j) + V(i - 1, j)) / 2 + (V(i, j) + V(i + 1, j)) / 2) /
                              4;
                expect(2 * i - 2, 2 * j - 2,
                       (A + B + C + D) / 4 / 4 + E / 2 + V(i, j) / 4);  // Eq 3
            }
        // There are (2n − 3)(2m − 3) new points, 4(n + m − 2) fewer than for RATS.
        EXPECT_EQ(net.newPointCount(), (2 * n - 3) * (2 * m - 3));
        EXPECT_EQ(RefinedNet(n, m).newPointCount() - net.newPointCount(), 4 * (n + m - 2));
    }
}

}  // namespace
}  // namespace espalier::stencils
