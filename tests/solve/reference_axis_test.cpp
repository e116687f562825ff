// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/pose.h>
#include <espalier/solve/reference_axis.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "support/test.h"

namespace espalier::solve {
namespace {

using Points = std::vector<Point3>;
using testing::ElementsAre;

/// A wing of 2 × 1 × 4 cells along z.
const Points& wingVertices() {
    static const Points positions =
        shapes::box({.cells = {2, 1, 4}, .min = {-1, -0.1, 0}, .max = {1, 0.1, 4}}).positions;
    return positions;
}

const AxisOptions kStraight = {.nodes = {{0, 0, 0}, {0, 0, 2}, {0, 0, 4}},
                               .link = AxisLink::Across};

void expectPoints(const Points& points, const Points& expected) {
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(points[i][c], expected[i][c], 1e-14) << "vertex " << i;
}

/// Returns the values at rest with some numbers added.
std::vector<double> movedValues(const ReferenceAxis& axis) {
    auto values = axis.atRest();
    const auto numbers = randomValues(values.size(), 7);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += 0.3 * numbers[i];
    return values;
}

/// Sets value k of each node.
std::vector<double> withAll(const ReferenceAxis& axis, std::size_t k, double value) {
    auto values = axis.atRest();
    for (std::size_t at = k; at < values.size(); at += ReferenceAxis::kValues) values[at] = value;
    return values;
}

TEST(ReferenceAxis, AtRestNothingMoves) {
    for (const bool follows : {false, true}) {
        AxisOptions options = kStraight;
        options.follows = follows;
        const ReferenceAxis axis(wingVertices(), options);
        EXPECT_EQ(axis.nodeCount(), 3);
        EXPECT_EQ(axis.count(), 33);
        expectPoints(axis.positions(axis.atRest()), wingVertices());
    }
}

// Equal values at all nodes are an operation of pose.h.
TEST(ReferenceAxis, EqualNodesAreOneOperation) {
    const ReferenceAxis axis(wingVertices(), kStraight);
    const shapes::pose::Options origin{.center = Point3{0, 0, 0}};
    const auto rotated = shapes::pose::rotate(wingVertices(), {0, 0, 1}, 0.4, origin);
    expectPoints(axis.positions(withAll(axis, 5, 0.4)), rotated);
    expectPoints(axis.positions(withAll(axis, 6, 0.4)), rotated);
    expectPoints(axis.positions(withAll(axis, 7, 1.5)),
                 shapes::pose::scale(wingVertices(), {1.5, 1.5, 1}, origin));
    expectPoints(axis.positions(withAll(axis, 8, 1.5)),
                 shapes::pose::scale(wingVertices(), {1.5, 1, 1}, origin));
    expectPoints(axis.positions(withAll(axis, 9, 1.5)),
                 shapes::pose::scale(wingVertices(), {1, 1.5, 1}, origin));
    // A turn about x is of each section about its own foot.
    const auto tilted = axis.positions(withAll(axis, 3, std::numbers::pi / 2));
    for (std::size_t v = 0; v < wingVertices().size(); ++v) {
        EXPECT_NEAR(tilted[v][1], 0, 1e-15);
        EXPECT_NEAR(tilted[v][2], wingVertices()[v][2] + wingVertices()[v][1], 1e-15);
    }
}

// A twist of the last node only grows along the axis, as pose::twist().
TEST(ReferenceAxis, ValuesAreLinearBetweenNodes) {
    const ReferenceAxis axis(wingVertices(), kStraight);
    auto values = axis.atRest();
    values[11 + 6] = 0.3;
    values[22 + 6] = 0.6;
    expectPoints(axis.positions(values),
                 shapes::pose::twist(wingVertices(), {0, 0, 1}, 0.6, {.center = Point3{0, 0, 0}}));
}

TEST(ReferenceAxis, TurnsAreInTheirOrder) {
    const Points one = {{1, 2, 3}};
    const auto turnedBy = [&](TurnOrder order) {
        const ReferenceAxis axis(one, {.nodes = {{0, 0, 3}, {0, 0, 4}}, .order = order});
        auto values = withAll(axis, 3, std::numbers::pi / 2);
        for (std::size_t at = 4; at < values.size(); at += ReferenceAxis::kValues)
            values[at] = values[at + 1] = std::numbers::pi / 2;
        return axis.positions(values);
    };
    // The link is (1, 2, 0). About x: (1, 0, 2); then about y: (2, 0, -1); then about z: (0, 2,
    // -1).
    expectPoints(turnedBy(TurnOrder::Xyz), {{0, 2, 2}});
    // About z: (-2, 1, 0); about x: (-2, 0, 1); about y: (1, 0, 2).
    expectPoints(turnedBy(TurnOrder::Zxy), {{1, 0, 5}});
    // About x: (1, 0, 2); about z: (0, 1, 2); about y: (2, 1, 0).
    expectPoints(turnedBy(TurnOrder::Xzy), {{2, 1, 3}});
    // About y: (0, 2, -1); about z: (-2, 0, -1); about x: (-2, 1, 0).
    expectPoints(turnedBy(TurnOrder::Yzx), {{-2, 1, 3}});
    // About y: (0, 2, -1); about x: (0, 1, 2); about z: (-1, 0, 2).
    expectPoints(turnedBy(TurnOrder::Yxz), {{-1, 0, 5}});
    // About z: (-2, 1, 0); about y: (0, 1, 2); about x: (0, -2, 1).
    expectPoints(turnedBy(TurnOrder::Zyx), {{0, -2, 4}});
}

// The axis turns by 90° from z to x. Sections that follow turn with it; the others only move.
TEST(ReferenceAxis, SectionsFollowTheAxisOrKeepTheirDirection) {
    const Points one = {{0, 1, 1}};
    AxisOptions options = {.nodes = {{0, 0, 0}, {0, 0, 2}}};
    auto values = ReferenceAxis(one, options).atRest();
    values[11] = 2;
    values[13] = 0;
    expectPoints(ReferenceAxis(one, options).positions(values), {{1, 1, 0}});
    options.follows = true;
    // (t·t₀) d − (t·d) t₀ is 0 for t across both t₀ and d, ...
    expectPoints(ReferenceAxis(one, options).positions(values), {{1, 0, 0}});
    // ... and −t₀ for t = d.
    values[11] = 0;
    values[12] = 2;
    expectPoints(ReferenceAxis(one, options).positions(values), {{0, 1, -1}});
    // Turns about the coordinate axes do not count, and the twist is about the new direction.
    values[6] = values[17] = std::numbers::pi / 2;
    values[3] = 7;
    expectPoints(ReferenceAxis(one, options).positions(values), {{-1, 1, 0}});
}

TEST(ReferenceAxis, ScalesAreAlongTheFrame) {
    const Points one = {{3, 1, 1}};
    const double h = std::sqrt(0.5);
    const ReferenceAxis axis(
        one, {.nodes = {{0, 0, 0}, {0, 0, 2}}, .frame = {{{h, h, 0}, {-h, h, 0}, {0, 0, 1}}}});
    // (3, 1) is 4h along (h, h) and −2h along (−h, h).
    expectPoints(axis.positions(withAll(axis, 8, 2)), {{5, 3, 1}});
    expectPoints(axis.positions(withAll(axis, 9, 2)), {{4, 0, 1}});
}

TEST(ReferenceAxis, LinksFollowTheOptions) {
    // An axis that is bent: along z, then along x.
    const Points nodes = {{0, 0, 0}, {0, 0, 2}, {3, 0, 2}};
    const Points vertices = {{0.5, 0.2, 1}, {-1, 0.3, 5}, {1, 1, 0.5}};
    const auto feet = [&](AxisLink link, const Point3& direction) {
        return ReferenceAxis(vertices, {.nodes = nodes, .link = link, .direction = direction})
            .feet();
    };
    expectPoints(feet(AxisLink::Nearest, {0, 0, 1}), {{0, 0, 1}, {0, 0, 2}, {0, 0, 0.5}});
    // Lines along z: the second one passes (0, 0, any) nearest; of the third, a point of the line
    // along x is below it.
    expectPoints(feet(AxisLink::Along, {0, 0, -2}), {{0.5, 0, 2}, {0, 0, 2}, {1, 0, 2}});
    // Planes across z: the second one meets nothing.
    expectPoints(feet(AxisLink::Across, {0, 0, 3}), {{0, 0, 1}, {0, 0, 2}, {0, 0, 0.5}});
    // The plane z = 2 contains the second segment: the nearest point of it.
    expectPoints(
        ReferenceAxis(Points{{2, 1, 2}}, {.nodes = nodes, .link = AxisLink::Across}).feet(),
        {{2, 0, 2}});
    // At a node, the next segment gives the direction.
    AxisOptions options = {.nodes = nodes, .follows = true};
    const ReferenceAxis axis(Points{{0, 1, 2}}, options);
    auto values = axis.atRest();
    values[17] = std::numbers::pi / 2;  // turns y to z about x
    expectPoints(axis.positions(values), {{0, 0, 3}});
}

/// Checks a table of derivatives against differences of fourth order.
void expectAxisDerivatives(const stencils::StencilTable<double>& table, std::vector<double> values,
                           const std::function<Points(const std::vector<double>&)>& positions) {
    ASSERT_EQ(table.columnCount(), std::ssize(values));
    constexpr double h = 1e-3;
    for (Index column = 0; column < table.columnCount(); ++column) {
        const auto at = [&](double step) {
            auto moved = values;
            moved[column] += step;
            return positions(moved);
        };
        const Points a = at(-2 * h), b = at(-h), c = at(h), d = at(2 * h);
        ASSERT_EQ(table.rowCount(), 3 * std::ssize(a));
        for (Index row = 0; row < table.rowCount(); ++row) {
            double derivative = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                if (table.columns(row)[k] == column) derivative = table.weights(row)[k];
            const auto of = [&](const Points& points) { return points[row / 3][row % 3]; };
            EXPECT_NEAR(derivative, (of(a) - 8 * of(b) + 8 * of(c) - of(d)) / (12 * h), 1e-9)
                << "row " << row << ", column " << column;
        }
    }
}

TEST(ReferenceAxis, MatricesAreTheDerivatives) {
    for (const bool follows : {false, true}) {
        AxisOptions options = {.nodes = {{0, 0.1, -0.2}, {0.2, 0, 2}, {0.6, 0.1, 4.5}},
                               .link = AxisLink::Across,
                               .order = TurnOrder::Xzy,
                               .follows = follows};
        const Points some(wingVertices().begin() + 7, wingVertices().begin() + 19);
        const ReferenceAxis axis(some, options);
        const auto values = movedValues(axis);
        expectAxisDerivatives(axis.matrix(values), values, [&](const std::vector<double>& moved) {
            return axis.positions(moved);
        });
        std::vector<double> rest;
        for (const Points& points : {some, options.nodes})
            for (const Point3& point : points) rest.insert(rest.end(), point.begin(), point.end());
        expectAxisDerivatives(axis.restMatrix(values), rest, [&](const std::vector<double>& moved) {
            Points points;
            for (std::size_t i = 0; i < moved.size(); i += 3)
                points.push_back({moved[i], moved[i + 1], moved[i + 2]});
            return axis
                .movedTo(std::span(points).first(some.size()),
                         std::span(points).subspan(some.size()))
                .positions(values);
        });
    }
}

TEST(ReferenceAxis, RefusesWrongNumbers) {
    const auto refused = [](const AxisOptions& options, const std::string& why) {
        EXPECT_REFUSED(Error, why, ReferenceAxis(wingVertices(), options));
    };
    refused({.nodes = {{0, 0, 0}}}, "nodes: expected two or more, got 1");
    refused({.nodes = {{0, 0, 0}, {0, 0, 0}}}, "nodes[1]: expected a place other than");
    refused({.nodes = {{0, 0, 0}, {0, 0, NAN}}}, "nodes[1]: expected finite numbers");
    AxisOptions options = kStraight;
    options.direction = {0, 0, 0};
    refused(options, "direction: expected a finite vector other than 0");
    options = kStraight;
    options.frame[1] = {1, 0, 0};
    refused(options, "expected three unit vectors at right angles");
    EXPECT_REFUSED(Error, "the position of vertex 1 is not finite",
                   ReferenceAxis(Points{{0, 0, 0}, {0, INFINITY, 0}}, kStraight));
    const ReferenceAxis axis(wingVertices(), kStraight);
    EXPECT_MESSAGE("there are 2 values; expected 33, eleven for each node",
                   axis.positions(std::vector<double>{1, 2}));
    auto values = axis.atRest();
    values[4] = NAN;
    EXPECT_REFUSED(Error, "values[4] is nan", axis.matrix(values));
    values = axis.atRest();
    values[13] = 0;
    EXPECT_REFUSED(Error, "the values move nodes 0 and 1 to the same place",
                   axis.positions(values));
    EXPECT_REFUSED(Error, "expected 30 and 3", axis.movedTo(wingVertices(), Points(2)));
}

}  // namespace
}  // namespace espalier::solve
