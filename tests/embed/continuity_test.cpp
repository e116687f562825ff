// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/continuity.h>
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

/// Returns the faces of a lattice whose vertices all satisfy a condition.
template <class Condition>
std::vector<Index> facesWhere(const Lattice& lattice, Condition condition) {
    std::vector<Index> faces;
    for (Index face = 0; face < lattice.complex.count(2); ++face) {
        const auto vertices = lattice.complex.relation(2, 0)[face];
        if (std::all_of(vertices.begin(), vertices.end(),
                        [&](Index v) { return condition(lattice.positions[v]); }))
            faces.push_back(face);
    }
    return faces;
}

template <class Condition>
std::vector<Index> verticesWhere(const Lattice& lattice, Condition condition) {
    std::vector<Index> vertices;
    for (std::size_t v = 0; v < lattice.positions.size(); ++v)
        if (condition(lattice.positions[v])) vertices.push_back(Index(v));
    return vertices;
}

// A box is the tricubic B-spline with a layer 2P₀ − P₁ around it: the first derivative on a side is
// P₁ − P₀, and the second is 0.
TEST(Continuity, SideOfABoxFreezesOneOrTwoLayers) {
    const Lattice box = shapes::box({.cells = {4, 3, 3}, .max = {4, 3, 3}});
    const TopologyRefiner base(box.complex);
    const auto side = facesWhere(box, [](const Point3& p) { return p[0] == 0; });
    ASSERT_EQ(side.size(), 9U);
    EXPECT_EQ(verticesHoldingFaces(base, side, Continuity::C0),
              verticesWhere(box, [](const Point3& p) { return p[0] == 0; }));
    for (const auto continuity : {Continuity::C1, Continuity::C2})
        EXPECT_EQ(verticesHoldingFaces(base, side, continuity),
                  verticesWhere(box, [](const Point3& p) { return p[0] <= 1; }));
}

// Inside, the cubic B-spline at a knot is (1, 4, 1)/6, its first derivative (−1, 0, 1)/2, and its
// second (1, −2, 1): all three depend on the same three layers.
TEST(Continuity, PlaneInsideABoxFreezesThreeLayers) {
    const Lattice box = shapes::box({.cells = {6, 2, 2}, .max = {6, 2, 2}});
    const TopologyRefiner base(box.complex);
    const auto plane = facesWhere(box, [](const Point3& p) { return p[0] == 3; });
    ASSERT_EQ(plane.size(), 4U);
    for (const auto continuity : {Continuity::C0, Continuity::C1, Continuity::C2})
        EXPECT_EQ(verticesHoldingFaces(base, plane, continuity),
                  verticesWhere(box, [](const Point3& p) { return p[0] >= 2 && p[0] <= 4; }));
}

/// The slow way: refines a whole level, and finds the vertices of the level on the faces and the
/// base vertices that these depend on.
struct FacesOnLevel {
    TopologyRefiner refiner;
    int level;
    ByEntity<std::uint8_t> isHeld;

    FacesOnLevel(const TopologyRefiner& base, int levels, const std::vector<Index>& faces)
        : refiner(base), level(levels) {
        refiner.refineUniform(levels);
        const CellComplex& complex = base.level(0).complex;
        for (int d = 0; d <= 3; ++d) isHeld[d].resize(complex.count(d));
        for (const Index face : faces)
            for (int d = 0; d <= 2; ++d)
                for (const Index part : complex.relation(2, d)[face]) isHeld[d][part] = 1;
        for (int k = 1; k <= level; ++k) isHeld = refiner.refinement(k).inherit(isHeld);
    }

    const CellComplex& complex() const { return refiner.level(level).complex; }

    std::set<Index> held() const {
        std::set<Index> vertices;
        for (std::size_t v = 0; v < isHeld[0].size(); ++v)
            if (isHeld[0][v]) vertices.insert(Index(v));
        return vertices;
    }
    /// Returns the vertices of the cells that contain one of some vertices.
    std::set<Index> around(const std::set<Index>& vertices) const {
        std::set<Index> result;
        for (const Index v : vertices)
            for (const Index cell : complex().relation(0, 3)[v])
                for (const Index w : complex().relation(3, 0)[cell]) result.insert(w);
        return result;
    }
    StencilTable<double> rows(const std::set<Index>& vertices) const {
        return stencils::buildStencils(refiner, level,
                                       std::vector<Index>(vertices.begin(), vertices.end()));
    }
    std::vector<Index> columns(const std::set<Index>& vertices) const {
        const auto table = rows(vertices);
        std::set<Index> result;
        for (Index row = 0; row < table.rowCount(); ++row)
            for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                if (std::abs(table.weights(row)[k]) > 1e-11) result.insert(table.columns(row)[k]);
        return {result.begin(), result.end()};
    }
};

/// Returns sets of faces to hold: the boundary of a lattice, the faces at a corner of the boundary,
/// and one face inside.
std::vector<std::vector<Index>> partsOf(const CellComplex& complex) {
    std::vector<std::vector<Index>> parts(2);
    std::optional<Index> inside;
    for (Index face = 0; face < complex.count(2); ++face)
        if (complex.relation(2, 3)[face].size() == 1)
            parts[0].push_back(face);
        else
            inside = face;
    const Index corner = complex.relation(2, 0)[parts[0].front()][0];
    for (const Index face : parts[0]) {
        const auto vertices = complex.relation(2, 0)[face];
        if (std::find(vertices.begin(), vertices.end(), corner) != vertices.end())
            parts[1].push_back(face);
    }
    if (inside) parts.push_back({*inside});
    return parts;
}

// In lattices of every kind, the faces depend on the same vertices on all levels from the second
// on, and so do the cells beside them.
TEST(Continuity, DependsOnTheSameVerticesAtEveryLevel) {
    for (const auto& [name, lattice] : zoo())
        for (const auto boundary : {Boundary::Sharp, Boundary::EdgeOnly}) {
            for (const auto& faces : partsOf(lattice.complex))
                for (const int level : {2, 3})
                    for (const Rules rules : {Rules::Siggraph96, Rules::Mlca}) {
                        const TopologyRefiner base(
                            lattice.complex,
                            {.rules = rules, .boundary = boundary, .marks = lattice.marks});
                        if (level == 3 && lattice.complex.count(3) > 12) continue;
                        SCOPED_TRACE(name + ", level " + std::to_string(level));
                        const FacesOnLevel whole(base, level, faces);
                        EXPECT_EQ(verticesHoldingFaces(base, faces, Continuity::C0),
                                  whole.columns(whole.held()));
                        for (const auto continuity : {Continuity::C1, Continuity::C2})
                            EXPECT_EQ(verticesHoldingFaces(base, faces, continuity),
                                      whole.columns(whole.around(whole.held())));
                    }
        }
}

// If the vertices of C1 are frozen, displacements near the faces grow about as h³. Distances halve
// from one level to the next, and the vertices just beyond the unmoved ones move less than a
// quarter as far. So first and second differences vanish.
TEST(Continuity, MovingVerticesKeepSecondDerivatives) {
    for (const auto& [name, lattice] : zoo()) {
        if (lattice.complex.count(3) > 12) continue;
        for (const auto& faces : partsOf(lattice.complex))
            for (const Rules rules : {Rules::Siggraph96, Rules::Mlca}) {
                const TopologyRefiner base(lattice.complex,
                                           {.rules = rules, .marks = lattice.marks});
                SCOPED_TRACE(name);
                const auto frozen = verticesHoldingFaces(base, faces, Continuity::C1);
                double before = 0;
                for (const int level : {2, 3}) {
                    const FacesOnLevel whole(base, level, faces);
                    const auto table = whole.rows(whole.around(whole.around(whole.held())));
                    double farthest = 0;
                    for (Index row = 0; row < table.rowCount(); ++row) {
                        double sum = 0;
                        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                            if (!std::binary_search(frozen.begin(), frozen.end(),
                                                    table.columns(row)[k]))
                                sum += std::abs(table.weights(row)[k]);
                        farthest = std::max(farthest, sum);
                    }
                    if (level == 3) {
                        EXPECT_LT(farthest, 0.25 * before + 1e-12);
                    }
                    before = farthest;
                }
            }
    }
}

/// A lattice, and a part of a model to hold.
struct Held {
    Lattice lattice = shapes::box({.cells = {6, 4, 4}, .max = {6, 4, 4}});
    TopologyRefiner base{lattice.complex};
    std::vector<Point3> part;

    explicit Held(unsigned seed = 5) {
        for (const Point3& p : pointsIn(Refined(lattice, 1), 400, seed))
            if (p[0] < 1.8) part.push_back(p);
    }
    std::vector<Index> freeze(Continuity continuity, int level = 2,
                              const EmbeddingOptions& options = {}) const {
        return verticesHoldingPoints({base, lattice.positions}, part, continuity,
                                     {.level = level, .embedding = options});
    }
    /// Returns positions in which all vertices but the frozen ones have moved.
    std::vector<Point3> pose(const std::vector<Index>& frozen) const {
        auto positions = lattice.positions;
        const auto random = randomValues(3 * positions.size(), 7);
        for (std::size_t i = 0; i < random.size(); ++i)
            if (!std::binary_search(frozen.begin(), frozen.end(), Index(i / 3)))
                positions[i / 3][i % 3] += random[i];
        return positions;
    }
    /// Returns the largest displacement of some points when all vertices but the frozen ones move.
    double largestMove(const std::vector<Index>& frozen, const std::vector<Point3>& points,
                       const EmbeddingOptions& options = {}) const {
        const auto table =
            bindPoints({base, lattice.positions}, points, {.level = 2, .embedding = options}).table;
        const auto moved = stencils::applyLevelTable(table, pose(frozen));
        const auto atRest = stencils::applyLevelTable(table, lattice.positions);
        double largest = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
            largest = std::max(largest, (vec(moved[i]) - vec(atRest[i])).lpNorm<1>());
        return largest;
    }
};

TEST(Continuity, HeldPointsStay) {
    const Held held;
    const auto frozen = held.freeze(Continuity::C0);
    // Sums of at most 64 products of numbers below 10, in double.
    EXPECT_LT(held.largestMove(frozen, held.part), 1e-13);
    // Every frozen vertex is needed.
    for (std::size_t i = 0; i < frozen.size(); ++i) {
        auto fewer = frozen;
        fewer.erase(fewer.begin() + std::ptrdiff_t(i));
        EXPECT_GT(held.largestMove(fewer, held.part), 1e-9) << frozen[i];
    }
    EXPECT_LT(frozen.size(), held.lattice.positions.size());
}

// Points half a cell of the level beside the held points, in each direction, stay too.
TEST(Continuity, PointsBesideHeldPointsStayToo) {
    const Held held;
    for (const auto continuity : {Continuity::C1, Continuity::C2}) {
        const auto frozen = held.freeze(continuity);
        for (int axis = 0; axis < 3; ++axis)
            for (const double step : {-0.125, 0.125}) {
                auto moved = held.part;
                for (Point3& p : moved) p[axis] = std::clamp(p[axis] + step, 0.0, axis ? 4.0 : 6.0);
                EXPECT_LT(held.largestMove(frozen, moved), 1e-13);
            }
        const auto least = held.freeze(Continuity::C0);
        EXPECT_TRUE(std::includes(frozen.begin(), frozen.end(), least.begin(), least.end()));
    }
}

// A point in the middle of a base cell depends on all 4³ vertices around the cell. A point on a
// corner of the lattice depends on the corner only. For C1, its cell of level 2 and the cells
// around reach up to 1/2. The point there, of level 1, depends on the level-1 point of vertex 1,
// which depends on vertices 0 to 2.
TEST(Continuity, PointsInTheMiddleAndInACorner) {
    Held held;
    const auto block = [&](double low, double high) {
        return verticesWhere(held.lattice, [&](const Point3& p) {
            return std::all_of(p.begin(), p.end(), [&](double c) { return c >= low && c <= high; });
        });
    };
    held.part = {{1.4, 1.4, 1.4}};
    EXPECT_EQ(held.freeze(Continuity::C2), block(0, 3));
    held.part = {{0, 0, 0}};
    EXPECT_EQ(held.freeze(Continuity::C0), block(0, 0));
    EXPECT_EQ(held.freeze(Continuity::C1), block(0, 2));
}

// Let h = 2^-n of a base cell. The vertices of level n beside the cell that starts at 3 are from 3
// − h to 3 + 2h. The B-spline of vertex 5 starts at 3 as (x − 3)³/6. Its weight in the vertex at 3
// + 2h is its blossom at the three knots around: h · 2h · 3h / 6. At level 13 this weight is 2e-12,
// but in a second derivative it is 4^13 times as large. Vertex 1 has the weight 0 in the vertex at
// 3 − h, because its own B-spline ends at 3.
TEST(Continuity, FreezesTheLastLayerAtFineLevels) {
    const int level = 13;
    const double cell = std::ldexp(1, -level);
    const Lattice box = shapes::box({.cells = {6, 6, 6}, .max = {6, 6, 6}});
    const TopologyRefiner base(box.complex);
    const Point3 point = {3 + cell / 2, 3 + cell / 2, 3 + cell / 2};
    const auto frozen =
        verticesHoldingPoints({base, box.positions}, {{point}}, Continuity::C2, {.level = level});
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (double x = 0; x <= 6; ++x) {
            Point3 at = {3, 3, 3};
            at[axis] = x;
            const auto vertex = verticesWhere(box, [&](const Point3& p) { return p == at; });
            ASSERT_EQ(vertex.size(), 1U);
            EXPECT_EQ(std::binary_search(frozen.begin(), frozen.end(), vertex[0]), x >= 2 && x <= 5)
                << x;
        }
    // If the weight is this small along each of three axes, 6e-36 in total, it counts as 0.
    const auto corner = verticesWhere(box, [](const Point3& p) { return p == Point3{5, 5, 5}; });
    ASSERT_EQ(corner.size(), 1U);
    EXPECT_FALSE(std::binary_search(frozen.begin(), frozen.end(), corner[0]));
}

TEST(Continuity, PointsOutsideFreezeNothing) {
    Held held;
    held.part = {{-1, 0, 0}, {1e9, 0, 0}, {-1e-3, 2, 2}};
    for (const auto continuity : {Continuity::C0, Continuity::C1, Continuity::C2})
        EXPECT_TRUE(held.freeze(continuity).empty());
}

// A point outside stays in place anyway, unless the nearest cell carries it. Then this cell is
// held.
TEST(Continuity, CarriedPointsOutsideStay) {
    Held held;
    const EmbeddingOptions nearest = {.outside = OutsidePolicy::Nearest};
    // One set without a point inside, and one with such a point.
    for (const auto& part :
         {std::vector<Point3>{{-1, 0, 0}, {-1e-3, 2, 2}}, {{-0.5, 1.3, 1.2}, {0.7, 2.2, 2.3}}}) {
        held.part = part;
        const auto least = held.freeze(Continuity::C0, 2, nearest);
        EXPECT_FALSE(least.empty());
        for (const auto continuity : {Continuity::C0, Continuity::C1, Continuity::C2}) {
            const auto frozen = held.freeze(continuity, 2, nearest);
            EXPECT_TRUE(std::includes(frozen.begin(), frozen.end(), least.begin(), least.end()));
            EXPECT_LT(frozen.size(), held.lattice.positions.size());
            // The same tolerance as in HeldPointsStay.
            EXPECT_LT(held.largestMove(frozen, held.part, nearest), 1e-13);
        }
        EXPECT_GT(held.largestMove({}, held.part, nearest), 1e-3);
        // Points less than a cell of the level beside stay too.
        auto beside = held.part;
        for (Point3& p : beside) p[1] += 0.2;
        EXPECT_LT(held.largestMove(held.freeze(Continuity::C1, 2, nearest), beside, nearest),
                  1e-13);
    }
}

TEST(Continuity, BoundRowsFreezeTheSameVertices) {
    const Held held;
    const auto bound = bindPoints({held.base, held.lattice.positions}, held.part, {.level = 2});
    EXPECT_EQ(verticesHoldingRows(bound.table), held.freeze(Continuity::C0));
    EXPECT_TRUE(verticesHoldingRows(stencils::selectRows<double>(bound.table, {})).empty());
}

TEST(Continuity, DoesNotDependOnThreads) {
    const Held held(9);
    const auto expected = held.freeze(Continuity::C2);
    for (const int threads : {1, 5})
        withThreads(threads, [&] { EXPECT_EQ(held.freeze(Continuity::C2), expected); });
}

TEST(Continuity, RefusesInvalidFacesAndPoints) {
    Held held;
    const auto hold = [&](const TopologyRefiner& base, std::vector<Index> faces) {
        return [&base, faces] { verticesHoldingFaces(base, faces, Continuity::C0); };
    };
    EXPECT_THAT(hold(held.base, {}), ThrowsMessage<Error>(HasSubstr("there are no faces to hold")));
    EXPECT_THAT(hold(held.base, {0, 9999}),
                ThrowsMessage<Error>(HasSubstr("there is no face 9999 to hold; the lattice has ")));
    EXPECT_THAT(hold(held.base, {-1}), ThrowsMessage<Error>(HasSubstr("there is no face -1")));
    const TopologyRefiner open(held.lattice.complex, {.boundary = Boundary::Open});
    EXPECT_THAT(hold(open, {0}), ThrowsMessage<Error>(HasSubstr("boundary mode 'open'")));
    TopologyRefiner refined = test::refined(held.lattice.complex, 1);
    EXPECT_THAT(hold(refined, {0}), ThrowsMessage<Error>(HasSubstr("has not been refined")));
    held.part.clear();
    EXPECT_REFUSED(Error, "there are no points to hold", held.freeze(Continuity::C1));
    held.part = {{1, 1, 1}};
    EXPECT_REFUSED(Error, "level: expected 1 to 20 to bind points, got 0",
                   held.freeze(Continuity::C1, 0));
    for (const auto continuity : {Continuity::C0, Continuity::C1}) {
        held.part = {{1, 1, 1}, {2, 2, 2}, {1, 9, 1}};
        EXPECT_REFUSED(Error, "point 2 at (1, 9, 1) is outside the lattice",
                       held.freeze(continuity, 2, {.outside = OutsidePolicy::Error}));
        for (const double bad : {kNan, kInfinity}) {
            held.part[1][2] = bad;
            EXPECT_REFUSED(Error, "point 1 to hold is not finite", held.freeze(continuity));
        }
    }
}

}  // namespace
}  // namespace espalier::embed
