// SPDX-License-Identifier: Apache-2.0
#include "limit/layered_edge.h"

#include <espalier/embed/basis_functions.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/limit/limit_stencils.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <Eigen/LU>

#include "limit/limit_tangents.h"
#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/tables.h"
#include "support/test.h"

namespace espalier::limit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr Rules kRules[] = {Rules::Siggraph96, Rules::Cse96, Rules::Mlca};

/// Level 1 of a cylinder, with a layered edge of its axis.
struct Axis {
    explicit Axis(Index sectors, Rules rules)
        : lattice(shapes::cylinder({.sectors = int(sectors), .layers = 2})),
          refiner(lattice.complex, {.rules = rules}) {
        refiner.refineUniform(1);
        const far::CellComplex& complex = level().complex;
        for (Index e = 0; e < complex.count(1) && layers.empty(); ++e) {
            if (Index(complex.relation(1, 3)[e].size()) != sectors) continue;
            edge = e;
            if (const auto found = layersAround(level(), e)) layers = *found;
        }
    }

    const far::Level& level() const { return refiner.level(1); }

    /// Positions of the vertices of level 1 in a pose.
    std::vector<Point3> positions(const std::vector<Point3>& pose) const {
        return stencils::applyLevelTable(stencils::buildStencils(refiner, 1), pose);
    }

    Lattice lattice;
    TopologyRefiner refiner;
    Index edge = kMaxIndex;
    std::vector<Index> layers;
};

Vector3d sum(std::span<const embed::VertexWeight> weights, const std::vector<Point3>& positions) {
    Vector3d result = Vector3d::Zero();
    for (const auto& [vertex, weight] : weights) result += weight * vec(positions[vertex]);
    return result;
}

// Places on the edge are at the limits that refinement gives.
TEST(LayeredEdge, PositionsAreTheLimitsOfRefinement) {
    for (const Rules rules : kRules)
        for (const Index sectors : {3, 5, 7, 12}) {
            if (sectors != 5 && (kIsSlow || rules != Rules::Siggraph96)) continue;
            const Axis axis(sectors, rules);
            ASSERT_FALSE(axis.layers.empty()) << sectors;
            const auto refinement = EdgeRefinement::make(rules, sectors);
            ASSERT_TRUE(refinement) << sectors;
            // A frame of a cell at the edge, and the place of the edge in it.
            const auto ends = axis.level().complex.relation(1, 0)[axis.edge];
            const auto frame = *embed::frameOf(
                axis.level().complex, axis.level().complex.relation(1, 3)[axis.edge].front());
            const auto cornerOf = [&](Index vertex) {
                return std::size_t(std::find(frame.corners.begin(), frame.corners.end(), vertex) -
                                   frame.corners.begin());
            };
            const std::vector<double> places = {0, 0.5, 1, 0.25, 0.3, 1.0 / 3, 0.7, 0.999, 1e-5};
            std::vector<LimitLocation> locations;
            for (const double at : places) {
                LimitLocation location{frame.cell, {}};
                for (std::size_t a = 0; a < 3; ++a)
                    location.uvw[a] = (1 - at) * double(embed::bitOf(cornerOf(ends[0]), a)) +
                                      at * double(embed::bitOf(cornerOf(ends[1]), a));
                locations.push_back(location);
            }
            const auto pose = shaken(axis.lattice.positions, 5);
            const auto expected = times(
                buildLimitStencils(axis.refiner, 1, locations, {.tolerance = 1e-9}).position, pose);
            for (std::size_t i = 0; i < places.size(); ++i) {
                const auto rows = refinement->rowsAt(axis.layers, places[i]);
                // The reference blends cells of 1e-9, which bend by a power of 1.6 of their size.
                EXPECT_LT((sum(rows.position, axis.positions(pose)) -
                           expected.row(Eigen::Index(i)).transpose())
                              .norm(),
                          1e-13)
                    << sectors << " sectors, at " << places[i];
            }
        }
}

/// Returns F from three directions at rest and in a pose: Fᵀ = (T X)⁻¹ T x.
Matrix3d gradient(const Matrix3d& atRest, const Matrix3d& posed) {
    return (atRest.inverse() * posed).transpose();
}

// The directions span the tangents that refinement gives at vertices.
TEST(LayeredEdge, DirectionsAreTheTangentsOfRefinement) {
    for (const Rules rules : kRules)
        for (const Index sectors : {3, 5, 7, 12}) {
            const Axis axis(sectors, rules);
            const auto refinement = EdgeRefinement::make(rules, sectors);
            const auto pose = shaken(axis.lattice.positions, 6);
            const auto found = [&](double at, const std::vector<Point3>& base) {
                const auto rows = refinement->rowsAt(axis.layers, at);
                const auto positions = axis.positions(base);
                Matrix3d result;
                for (Eigen::Index k = 0; k < 3; ++k)
                    result.row(k) = sum(rows.directions[std::size_t(k)], positions).transpose();
                return result;
            };
            // The edge, then its first half, then the second half of that.
            stencils::Levels levels(TopologyRefiner(axis.level(), axis.refiner.options()));
            Index edge = axis.edge, from = axis.level().complex.relation(1, 0)[edge][0];
            double low = 0, high = 1;
            for (const bool isHigh : {false, true}) {
                const far::CellComplex complex = levels.finestLevel().complex;
                const auto ends = complex.relation(1, 0)[edge];
                const std::array<double, 2> places = {ends[0] == from ? low : high,
                                                      ends[0] == from ? high : low};
                for (std::size_t end = 0; end < 2; ++end) {
                    const std::vector<CellCorner> corner = {
                        {complex.relation(1, 3)[edge].front(), ends[end]}};
                    const auto table = buildTangentTable(levels.refiner(), levels.finest(), corner);
                    const auto expected = [&](const std::vector<Point3>& base) -> Matrix3d {
                        auto positions = axis.positions(base);
                        for (const auto& step : levels.tables())
                            positions = stencils::applyLevelTable(step, positions);
                        return times(table, positions);
                    };
                    // Both are limits of iterations; see LimitGradients for their accuracy.
                    EXPECT_LT((gradient(found(places[end], axis.lattice.positions),
                                        found(places[end], pose)) -
                               gradient(expected(axis.lattice.positions), expected(pose)))
                                  .norm(),
                              1e-8)
                        << sectors << " sectors, at " << places[end];
                }
                levels.refineAround(complex.relation(1, 3)[edge]);
                const auto& step = levels.refiner().refinement(levels.finest());
                const Index other = ends[0] == from ? ends[1] : ends[0];
                const Entity self{1, edge};
                edge = step.childOf({{0, isHigh ? other : from}, self})->index;
                from =
                    step.childOf({isHigh ? self : Entity{0, from}, isHigh ? self : Entity{0, from}})
                        ->index;
                (isHigh ? low : high) = (low + high) / 2;
            }
        }
}

// Where the rules are the tensor product of a rule for the plane and the rule of the cubic
// B-spline, the sums of the weights of each layer are the B-spline. The rules of MacCracken & Joy
// for a vertex are such a product around four cells only: (C + 3A + 3M + P)/8 averages all n + 2
// edges at the vertex, of which always two are along the axis.
TEST(LayeredEdge, OnlyMlcaIsATensorProduct) {
    for (const Rules rules : kRules)
        for (const Index cells : {3, 4, 5, 7}) {
            const auto refinement = EdgeRefinement::make(rules, cells);
            ASSERT_TRUE(refinement);
            std::vector<Index> layers(std::size_t(4 * (1 + 2 * cells)));
            std::iota(layers.begin(), layers.end(), Index{0});
            double difference = 0;
            for (const double at : {0.0, 0.3, 0.5}) {
                std::array<double, 4> sums = {};
                for (const auto& [vertex, weight] : refinement->rowsAt(layers, at).position)
                    sums[std::size_t(vertex / (1 + 2 * cells))] += weight;
                const auto spline = embed::cubicBSpline(at, 0);
                for (std::size_t k = 0; k < 4; ++k)
                    difference = std::max(difference, std::abs(sums[k] - spline[k]));
            }
            if (rules == Rules::Mlca || cells == 4)
                // The rounding of 48 products.
                EXPECT_LT(difference, 1e-14) << cells;
            else
                EXPECT_GT(difference, 1e-3) << cells;
        }
}

// Only edges inside the lattice have layers around them, and only if the next edges continue them.
TEST(LayeredEdge, LayersEndAtOtherFeatures) {
    const Index sectors = 5;
    Axis axis(sectors, Rules::Siggraph96);
    const far::CellComplex& complex = axis.level().complex;
    int found = 0;
    for (Index e = 0; e < complex.count(1); ++e) {
        if (Index(complex.relation(1, 3)[e].size()) != sectors) continue;
        const auto ends = complex.relation(1, 0)[e];
        const bool isInside =
            axis.level().strata.of({0, ends[0]}) == 3 && axis.level().strata.of({0, ends[1]}) == 3;
        EXPECT_EQ(layersAround(axis.level(), e).has_value(), isInside);
        found += isInside;
    }
    // Two layers of cells have four on level 1, so that the axis has four edges.
    EXPECT_EQ(found, 2);
    // Each vertex occurs once, and layers are in the order of the axis.
    std::set<Index> all(axis.layers.begin(), axis.layers.end());
    EXPECT_EQ(all.size(), std::size_t(4 * (1 + 2 * sectors)));
    const auto positions = axis.positions(axis.lattice.positions);
    for (std::size_t layer = 0; layer < 4; ++layer)
        for (std::size_t i = 0; i < 11; ++i)
            EXPECT_NEAR(positions[axis.layers[11 * layer + i]][2],
                        positions[axis.layers[11 * layer]][2], 1e-12);
}

// Along a sharp or semi-sharp edge other rules hold.
TEST(LayeredEdge, SharpEdgesHaveNoLayers) {
    const Lattice lattice = shapes::cylinder({.sectors = 5, .layers = 3});
    std::vector<Index> inside;
    for (Index v = 0; v < lattice.complex.count(0); ++v)
        if (lattice.complex.relation(0, 3)[v].size() == 10) inside.push_back(v);
    ASSERT_EQ(inside.size(), 2U);
    for (const float sharpness : {0.0F, 1.5F, far::kInfinitelySharp}) {
        far::RefinerOptions options;
        if (sharpness > 0) options.marks.edges = {{{inside[0], inside[1]}, sharpness}};
        TopologyRefiner refiner(lattice.complex, options);
        refiner.refineUniform(1);
        int found = 0;
        for (Index e = 0; e < refiner.level(1).complex.count(1); ++e)
            if (refiner.level(1).complex.relation(1, 3)[e].size() == 5)
                found += layersAround(refiner.level(1), e).has_value();
        // The axis has six edges, and two of them end at the boundary. The other four are the two
        // halves of the marked edge, and the edge at each end of it.
        EXPECT_EQ(found, sharpness > 0 ? 0 : 4) << sharpness;
    }
}

}  // namespace
}  // namespace espalier::limit
