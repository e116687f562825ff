// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/standard_cells.h>
#include <espalier/limit/limit_stencils.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include "support/random_lattices.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::limit {
namespace {

/// Returns the weights of the grid points of a box lattice along one axis of n cells, at place x,
/// in a derivative of the B-spline with phantom layers 2P₀ − P₁. Uses the recurrence of Cox and de
/// Boor instead of a matrix.
std::vector<double> axisWeights(Index n, double x, int order) {
    // B(t) of degree d with knots 0, 1, …, d + 1.
    const auto basis = [](const auto& self, int degree, double t) -> double {
        if (degree == 0) return t >= 0 && t < 1 ? 1 : 0;
        return (t * self(self, degree - 1, t) + (degree + 1 - t) * self(self, degree - 1, t - 1)) /
               degree;
    };
    const auto derivative = [&](const auto& self, int degree, int k, double t) -> double {
        if (k == 0) return basis(basis, degree, t);
        return self(self, degree - 1, k - 1, t) - self(self, degree - 1, k - 1, t - 1);
    };
    std::vector<double> all(std::size_t(n) + 3);  // Phantoms at both ends.
    for (Index i = -1; i <= n + 1; ++i) all[i + 1] = derivative(derivative, 3, order, x - i + 2);
    std::vector<double> weights(all.begin() + 1, all.end() - 1);
    weights[0] += 2 * all.front();
    weights[1] -= all.front();
    weights[n] += 2 * all.back();
    weights[std::size_t(n - 1)] -= all.back();
    return weights;
}

void expectSplineRow(const StencilTable<double>& table, Index row, const std::array<Index, 3>& n,
                     const std::array<double, 3>& place, const std::array<int, 3>& orders) {
    const auto x = axisWeights(n[0], place[0], orders[0]);
    const auto y = axisWeights(n[1], place[1], orders[1]);
    const auto z = axisWeights(n[2], place[2], orders[2]);
    std::vector<double> difference;
    for (const double c : z)
        for (const double b : y)
            for (const double a : x) difference.push_back(a * b * c);
    for (std::size_t k = 0; k < table.columns(row).size(); ++k)
        difference[std::size_t(table.columns(row)[k])] -= table.weights(row)[k];
    // The bound that the project promises.
    for (const double d : difference) ASSERT_NEAR(d, 0, 1e-13);
}

constexpr std::array<std::array<int, 3>, 10> kOrders = {{{0, 0, 0},
                                                         {1, 0, 0},
                                                         {0, 1, 0},
                                                         {0, 0, 1},
                                                         {2, 0, 0},
                                                         {1, 1, 0},
                                                         {1, 0, 1},
                                                         {0, 2, 0},
                                                         {0, 1, 1},
                                                         {0, 0, 2}}};

const StencilTable<double>& tableOf(const LimitStencils& stencils, std::size_t order) {
    if (order == 0) return stencils.position;
    return order < 4 ? stencils.first[order - 1] : stencils.second[order - 4];
}

// Position and derivatives on box lattices, also ones that are one cell thick, on level 0 and on
// level 1 (where a coordinate covers half the length).
TEST(LimitStencils, BoxEqualsTheTensorSpline) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const std::array<Index, 3>& n : {std::array<Index, 3>{1, 1, 1}, {3, 1, 2}, {4, 3, 5}}) {
        TopologyRefiner refiner = test::refined(test::grid(n), 1);
        const auto positions = gridPositions(n);
        for (int level = 0; level <= 1; ++level) {
            const auto& complex = refiner.level(level).complex;
            // Positions of the corners in the parameters of the whole box: their Greville points.
            const auto corners =
                level == 0 ? positions : stencils::refinePositions(refiner, level, positions);
            std::vector<LimitLocation> locations;
            for (int i = 0; i < 40; ++i) {
                const auto cell = Index(random() % unsigned(complex.count(3)));
                LimitLocation location{cell, {unit(random), unit(random), unit(random)}};
                if (i % 4 == 0) location.uvw = {0, 0.5, double(i % 8 == 0)};
                locations.push_back(location);
            }
            const auto stencils = buildLimitStencils(refiner, level, locations, {.derivatives = 2});
            for (std::size_t i = 0; i < locations.size(); ++i) {
                const auto v = *far::hexahedronVertices(complex, CellId(locations[i].cell));
                const auto at = [&](std::size_t corner) { return corners[std::size_t(v[corner])]; };
                // Find the axis of the box that each axis of the cell is parallel to, and its
                // direction.
                std::array<double, 3> place = at(0);
                std::array<std::size_t, 3> axes;
                std::array<double, 3> steps;
                const std::array<std::size_t, 3> ends = {1, 3, 4};
                for (std::size_t a = 0; a < 3; ++a)
                    for (std::size_t c = 0; c < 3; ++c) {
                        const double step = at(ends[a])[c] - at(0)[c];
                        if (std::abs(step) < 0.1) continue;
                        axes[a] = c;
                        steps[a] = step;
                        place[c] += step * locations[i].uvw[a];
                    }
                for (std::size_t o = 0; o < kOrders.size(); ++o) {
                    std::array<int, 3> orders = {};
                    double scale = 1;
                    for (std::size_t a = 0; a < 3; ++a) {
                        orders[axes[a]] = kOrders[o][a];
                        scale *= std::pow(steps[a], kOrders[o][a]);
                    }
                    auto& table = tableOf(stencils, o);
                    Array<double> weights(table.weights().begin(), table.weights().end());
                    for (double& weight : weights) weight /= scale;
                    expectSplineRow({table.columnCount(),
                                     {table.offsets().begin(), table.offsets().end()},
                                     {table.columns().begin(), table.columns().end()},
                                     std::move(weights)},
                                    Index(i), n, place, orders);
                }
            }
        }
    }
}

// A place on a shared face is the same whichever of the two cells it is given in, also at irregular
// faces.
TEST(LimitStencils, NeighboursAgreeOnSharedFaces) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const auto& [name, lattice] : zoo()) {
        TopologyRefiner refiner = test::refined(lattice.complex, 1, refinerOptions(lattice));
        const auto& complex = refiner.level(1).complex;
        std::vector<LimitLocation> locations;
        for (Index face = 0; face < complex.count(2) && locations.size() < 60; ++face) {
            const auto cells = complex.relation(2, 3)[face];
            if (cells.size() != 2) continue;
            const auto loop = complex.relation(2, 0)[face];
            const double s = unit(random), t = unit(random);
            std::vector<LimitLocation> both;
            for (const Index cell : cells) {
                const auto v = far::hexahedronVertices(complex, CellId(cell));
                if (!v) continue;
                constexpr std::array<std::array<double, 3>, 8> kPlaces = {{{0, 0, 0},
                                                                           {1, 0, 0},
                                                                           {1, 1, 0},
                                                                           {0, 1, 0},
                                                                           {0, 0, 1},
                                                                           {1, 0, 1},
                                                                           {1, 1, 1},
                                                                           {0, 1, 1}}};
                const auto placeOf = [&](Index vertex) {
                    return kPlaces[std::size_t(std::find(v->begin(), v->end(), vertex) -
                                               v->begin())];
                };
                LimitLocation location{cell, {}};
                for (std::size_t c = 0; c < 3; ++c)
                    location.uvw[c] = std::clamp((1 - s) * (1 - t) * placeOf(loop[0])[c] +
                                                     s * (1 - t) * placeOf(loop[1])[c] +
                                                     s * t * placeOf(loop[2])[c] +
                                                     (1 - s) * t * placeOf(loop[3])[c],
                                                 0.0, 1.0);
                both.push_back(location);
            }
            if (both.size() == 2) locations.insert(locations.end(), both.begin(), both.end());
        }
        const auto stencils = buildLimitStencils(refiner, 1, locations);
        const auto positions = times(stencils.position, lattice.positions);
        for (Eigen::Index i = 0; i + 1 < positions.rows(); i += 2)
            // The tolerance, for lattices of size up to 6.
            EXPECT_LT((positions.row(i) - positions.row(i + 1)).norm(), 6e-6) << name << ' ' << i;
    }
}

// The limit of a vertex from its ring equals the limit at the corner of a cell that is refined
// around it.
TEST(LimitStencils, CornersOfCellsAgreeWithVertexLimits) {
    for (const auto& [name, lattice] : zoo()) {
        TopologyRefiner refiner = test::refined(lattice.complex, 1, refinerOptions(lattice));
        const auto& complex = refiner.level(1).complex;
        std::vector<LimitLocation> locations;
        std::vector<Index> vertices;
        for (Index cell = 0; cell < complex.count(3) && cell < 40; ++cell)
            if (const auto v = far::hexahedronVertices(complex, CellId(cell))) {
                locations.push_back({cell, {1, 1, 1}});
                vertices.push_back((*v)[6]);
            }
        if (locations.empty()) continue;  // Cells of an icosahedron are of type 5.
        const auto places =
            times(buildLimitStencils(refiner, 1, locations).position, lattice.positions);
        const auto limits = times(buildVertexLimits(refiner, 1, vertices), lattice.positions);
        EXPECT_LT(largestDistance(places, limits), 1e-12) << name;
    }
}

TEST(LimitStencils, RowsOfVertices) {
    const auto lattice = shapes::bipyramid({.sides = 5});
    TopologyRefiner refiner = test::refined(lattice.complex, 1);
    const auto stencils = buildLimitStencils(refiner, 1, {.derivatives = 1});
    EXPECT_TRUE(stencils.position == buildVertexLimits(refiner, 1));
    EXPECT_EQ(stencils.second[0].rowCount(), 0);
    const auto& complex = refiner.level(1).complex;
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        const auto cells = complex.relation(0, 3)[vertex];
        const bool isCorner = std::any_of(cells.begin(), cells.end(), [&](Index cell) {
            return far::hexahedronVertices(complex, CellId(cell)).has_value();
        });
        for (const auto& table : stencils.first) {
            EXPECT_EQ(table.weights(vertex).empty(), !isCorner);
            double sum = 0;
            for (const double weight : table.weights(vertex)) sum += weight;
            // Weights grow by about 1.2 per level, over 20 levels; each row is accurate relative to
            // its own size.
            EXPECT_NEAR(sum, 0, 1e-12);
        }
    }
}

TEST(LimitStencils, RefusesInvalidLocationsAndOptions) {
    const TopologyRefiner refiner(test::grid({2, 1, 1}));
    const auto build = [&](LimitLocation location, LimitStencilOptions options = {}) {
        return buildLimitStencils(refiner, 0, {{location}}, options);
    };
    EXPECT_EQ(build({1, {0.5, 0.5, 0.5}}).position.rowCount(), 1);
    // Rounding of a sum may put a place slightly outside the cell: it then counts as on the face.
    const auto beyond = build({0, {1.0000000000000002, -1e-16, 0.5}});
    EXPECT_TRUE(beyond.position == build({0, {1, 0, 0.5}}).position);
    EXPECT_MESSAGE("place 0 is at 1.00000000001; expected 0 to 1",
                   build({0, {0.5, 1.00000000001, 0.5}}));
    EXPECT_THROW(build({2, {}}), Error);
    EXPECT_THROW(build({-1, {}}), Error);
    EXPECT_THROW(build({0, {0, 1.1, 0}}), Error);
    EXPECT_THROW(build({0, {0, kNan, 0}}), Error);
    EXPECT_THROW(build({0, {}}, {.tolerance = 1}), Error);
    EXPECT_THROW(build({0, {}}, {.derivatives = 3}), Error);
    const std::vector<LimitLocation> first = {{0, {}}};
    const TopologyRefiner tetrahedron(singleCell(far::StandardCell::Tetrahedron));
    EXPECT_THROW(buildLimitStencils(tetrahedron, 0, first), Error);
    const TopologyRefiner open(test::grid({3, 3, 3}), {.boundary = Boundary::Open});
    EXPECT_THROW(buildLimitStencils(open, 0, first), Error);
    const TopologyRefiner mesh(gridMesh(2, 2));
    EXPECT_THROW(buildLimitStencils(mesh, 0, first), Error);
}

}  // namespace
}  // namespace espalier::limit
