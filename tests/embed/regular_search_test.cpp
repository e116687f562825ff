// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/patch_solver.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/regular_binding.h>
#include <espalier/embed/regular_search.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include "support/complexes.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

using Eigen::Vector3d;

/// A search in a lattice.
struct Search {
    TopologyRefiner base;
    std::vector<Point3> positions;
    PointDescent descent;
    RegularSearch regular;

    Search(const Lattice& lattice, double spacing)
        : base(lattice.complex, refinerOptions(lattice)),
          positions(lattice.positions),
          descent({base, positions}, CellSolver::scaleOf(positions, 1e-6)),
          regular({base, positions}, descent, spacing) {}
};

/// Returns the row of a point that has a place.
std::vector<VertexWeight> rowOf(const RegularPlaces& places, Index point, double spacing) {
    const auto length = static_cast<std::size_t>(places.places[point].length);
    std::vector<Index> vertices(length);
    std::vector<double> weights(length);
    places.writeRow(point, spacing, vertices.data(), weights.data());
    std::vector<VertexWeight> row;
    for (std::size_t k = 0; k < length; ++k) row.push_back({vertices[k], weights[k]});
    return row;
}

// The vertices of a level are where the level tables put them, with the weights of the level
// tables.
TEST(RegularSearch, RowsOfLevelVerticesAreRowsOfS) {
    const std::array<Index, 3> cells = {4, 3, 1};
    Lattice lattice;
    lattice.complex = test::grid(cells);
    for (Index k = 0; k <= 1; ++k)
        for (Index j = 0; j <= 3; ++j)
            for (Index i = 0; i <= 4; ++i)
                lattice.positions.push_back({i + 0.1 * j, j + 0.2 * k * i, k + 0.1 * i});
    for (const int level : {1, 2, 3}) {
        TopologyRefiner refiner(lattice.complex);
        refiner.refineUniform(level);
        const auto points = stencils::refinePositions(refiner, level, lattice.positions);
        const auto s = stencils::buildStencils(refiner, level);
        const Search search(lattice, spacingOf(level));
        const RegularPlaces places = search.regular.locate(points);
        ASSERT_EQ(places.count(), std::ssize(points));
        for (Index vertex = 0; vertex < s.rowCount(); ++vertex) {
            std::vector<double> difference(lattice.positions.size());
            for (std::size_t k = 0; k < s.columns(vertex).size(); ++k)
                difference[s.columns(vertex)[k]] += s.weights(vertex)[k];
            for (const auto& [base, weight] : rowOf(places, vertex, spacingOf(level)))
                difference[base] -= weight;
            // The rounding of a place in cells of size 1, and of a product of three weights.
            for (const double each : difference) EXPECT_LE(std::abs(each), 1e-14);
        }
    }
}

// In a cube with dyadic coordinates nothing is rounded: rows are as in S, without further entries.
TEST(RegularSearch, RowsAreExactWherePlacesAre) {
    const Lattice lattice = shapes::box({.cells = {4, 4, 4}});
    TopologyRefiner refiner(lattice.complex);
    refiner.refineUniform(2);
    const auto points = stencils::refinePositions(refiner, 2, lattice.positions);
    const auto s = stencils::buildStencils(refiner, 2);
    const Search search(lattice, spacingOf(2));
    const RegularPlaces places = search.regular.locate(points);
    for (Index vertex = 0; vertex < s.rowCount(); ++vertex) {
        const auto row = rowOf(places, vertex, spacingOf(2));
        ASSERT_EQ(row.size(), s.columns(vertex).size()) << vertex;
        for (std::size_t k = 0; k < row.size(); ++k) {
            EXPECT_EQ(row[k].vertex, s.columns(vertex)[k]);
            EXPECT_EQ(row[k].weight, s.weights(vertex)[k]);
        }
    }
}

TEST(RegularSearch, LeavesPointsThatAreInNoRegularCell) {
    // Along x, the spline of the middle cell goes back a little: 1.3 is there, and only there.
    const std::array<Index, 3> cells = {3, 1, 1};
    Lattice lattice;
    lattice.complex = test::grid(cells);
    const double x[] = {0, 1.6, 1, 2.6};
    for (Index k = 0; k <= 1; ++k)
        for (Index j = 0; j <= 1; ++j)
            for (Index i = 0; i <= 3; ++i)
                lattice.positions.push_back({x[i], double(j), double(k)});
    const Search folded(lattice, kLimitSpacing);
    const std::vector<Point3> points = {
        {0.05, 0.5, 0.5}, {1.3, 0.5, 0.5}, {0.5, 0.5, 1.5}, {kNan, 0, 0}};
    const auto places = folded.regular.locate(points).places;
    EXPECT_GT(places[0].length, 0);
    EXPECT_EQ(places[1].length, 0) << "the cell folds";
    EXPECT_EQ(places[2].length, 0) << "outside";
    EXPECT_EQ(places[3].length, 0);

    const Lattice wedges = shapes::cylinder({.sectors = 5, .pattern = {.rings = 1}});
    EXPECT_TRUE(Search(wedges, kLimitSpacing).regular.isEmpty());
    // In a ring of three cells, the cells before and after a cell are neighbours of each other.
    const Search ring(shapes::torus({.segments = 3}), spacingOf(1));
    EXPECT_EQ(ring.regular.locate(ring.positions).count(), 0);
}

/// A grid of unit cells, bent so that the spline of each cell differs from the level.
Lattice bentGrid(const std::array<Index, 3>& cells) {
    Lattice lattice;
    lattice.complex = test::grid(cells);
    for (const auto& [x, y, z] : test::gridPositions(cells))
        lattice.positions.push_back(
            {x + 0.1 * y * (y - 2), y + 0.1 * std::sin(2 * z), z + 0.1 * std::sin(3 * x)});
    return lattice;
}

// The other search decides about points outside by more than rounding: its tolerance counts.
TEST(RegularSearch, LeavesPointsJustOutside) {
    const Lattice lattice = bentGrid({2, 2, 2});
    TopologyRefiner refiner(lattice.complex);
    refiner.refineUniform(2);
    const auto level = stencils::refinePositions(refiner, 2, lattice.positions);
    const Search search(lattice, spacingOf(2));
    int count = 0;
    for (Index vertex = 0; vertex < std::ssize(level); ++vertex) {
        const auto& [x, y, z] = level[vertex];
        // On the hollow side at the low end of x, away from its edges.
        if (refiner.level(2).strata.of({0, vertex}) != 2 || x > 0.2 || std::abs(y - 1) > 0.5 ||
            std::abs(z - 1) > 0.5)
            continue;
        ++count;
        const std::vector<Point3> points = {{x - 5e-10, y, z}, {x + 5e-10, y, z}};
        const auto places = search.regular.locate(points).places;
        EXPECT_EQ(places[0].length, 0);
        EXPECT_GT(places[1].length, 0);
    }
    EXPECT_GT(count, 4);
}

// Near a face between cells of the level, Newton's last step may start on the other side of the
// face, where the slopes differ.
TEST(RegularSearch, PlacesAreExactNearFacesOfTheLevel) {
    const std::array<Index, 3> cells = {3, 3, 3};
    Lattice lattice;
    lattice.complex = test::grid(cells);
    lattice.positions = test::shaken(test::gridPositions(cells), 1, 0.3);
    const Search search(lattice, spacingOf(1));
    const far::Level& base = search.base.level(0);
    const TricubicPatch patch(base, *frameOf(base.complex, 13));
    const TricubicMap map(patch.controlPoints(lattice.positions), spacingOf(1));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Point3> points;
    for (int i = 0; i < 20'000; ++i) {
        Vector3d uvw(unit(random), unit(random), unit(random));
        uvw[i % 3] = 0.5 + 1e-8 * (unit(random) - 0.5);
        points.push_back(toArray(map.position(uvw)));
    }
    const RegularPlaces places = search.regular.locate(points);
    EXPECT_GT(places.count(), 19'000);
    // The rounding of coordinates up to 3.
    EXPECT_LE(places.largestResidual, 2e-14);
}

// The points in no regular cell go to the other function in the order of the model, and come back.
TEST(RegularSearch, BindsTheOtherPointsByAnotherFunction) {
    const Lattice lattice = shapes::box({.cells = {2, 2, 2}});
    const LengthUnit unit(lattice.positions);
    Lattice inUnits = lattice;
    inUnits.positions = unit.toUnits(lattice.positions);
    const Search search(inUnits, spacingOf(1));
    std::vector<Point3> points;
    for (int i = 0; i < 10'000; ++i) points.push_back({i % 100 * 0.01, i % 7 * 0.1, 0.3});
    points[4321] = {5, 5, 5};
    points[17] = {-3, 0, 0};
    Offset last = 0;
    const auto bind = [&](OutsidePolicy policy) {
        return bindRegularFirst(
            search.regular, unit, points,
            {.embedding = {.outside = policy},
             .progress = [&](Offset done) { last = std::max(last, done); }},
            [&](std::span<const Point3> others, const BindingOptions& options) {
                EXPECT_THAT(others, ElementsAre(points[17], points[4321]));
                options.progress(2);
                BoundRows<> result;
                result.statuses.assign(2, PointStatus::Outside);
                result.table = stencils::StencilTable<double>(8, {0, 1, 1}, {3}, {1.0});
                result.largestResidual = 0.125;
                return result;
            });
    };
    const BoundRows<> bound = bind(OutsidePolicy::Keep);
    EXPECT_EQ(last, 10'000);
    EXPECT_EQ(bound.largestResidual, 0.125);
    EXPECT_EQ(bound.count(PointStatus::Outside), 2);
    EXPECT_THAT(bound.table.columns(17), ElementsAre(3));
    EXPECT_THAT(bound.table.emptyRows(), ElementsAre(4321));
    const auto back = stencils::applyLevelTable(bound.table, lattice.positions);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i == 17 || i == 4321) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
            ASSERT_NEAR(back[i][axis], points[i][axis], 1e-15) << i << ' ' << axis;
    }
    EXPECT_REFUSED(Error, "point 17 at (-3, 0, 0) is outside", bind(OutsidePolicy::Error));
}

}  // namespace
}  // namespace espalier::embed
