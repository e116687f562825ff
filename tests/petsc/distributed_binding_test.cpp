// SPDX-License-Identifier: Apache-2.0
#include <espalier/bind/bind.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/petsc/distributed_table.h>
#include <espalier/shapes/inventory.h>

#include "ranks.h"
#include "support/refined_lattice.h"
#include "support/test.h"

namespace espalier::petsc {
namespace {

/// A model whose points are bound by their ranks; and, to compare, by one rank.
class DistributedBinding : public ::testing::Test {
protected:
    static constexpr int kLevel = 3;

    bind::Binding bind(std::span<const Point3> points) const {
        return bind::bindPoints({TopologyRefiner(lattice_.complex), lattice_.positions}, points,
                                bind::Level{kLevel});
    }

    /// Returns points of which some are in cells of irregular valence, and every fifth is outside.
    std::vector<Point3> makePoints() const {
        auto points = pointsIn(Refined(lattice_, kLevel), 500, 5);
        for (std::size_t i = 0; i < points.size(); i += 5) points[i] = {9, double(i), -3};
        return points;
    }

    std::vector<Point3> makePose() const { return shaken(lattice_.positions, 7, 0.1); }

    static std::vector<double> numbers(const std::vector<Point3>& points) {
        std::vector<double> result;
        for (const Point3& point : points) result.insert(result.end(), point.begin(), point.end());
        return result;
    }

    const Lattice lattice_ = shapes::cylinder({.sectors = 5});
    const std::vector<Point3> points_ = makePoints();
    const OwnedRange own_ = ownRange(Offset(points_.size()), Spread::Uneven);
    const OwnedRange vertices_ = ownRange(Offset(lattice_.positions.size()), Spread::Even);
    const std::vector<Point3> ownPoints_{points_.begin() + own_.first, points_.begin() + own_.last};
};

TEST_F(DistributedBinding, HasItsRowsOfTheWholeTable) {
    const auto whole = bind(points_), own = bind(ownPoints_);
    EXPECT_EQ(own.table, ownRows(whole.table, own_));
    EXPECT_EQ(whole.table.emptyRows().size(), 100u);

    DistributedTable distributed(MPI_COMM_WORLD, own.table, vertices_.count());
    const auto pose = makePose();
    std::vector<double> displacements = numbers(pose);
    for (std::size_t i = 0; i < displacements.size(); ++i)
        displacements[i] -= numbers(lattice_.positions)[i];
    std::vector<double> moved(3 * ownPoints_.size(), 99);
    distributed.evaluate(ownValues(displacements, vertices_, 3), moved, numbers(ownPoints_));
    const auto expected = ownValues(numbers(osd::evaluateBinding(whole, pose)), own_, 3);
    ASSERT_EQ(moved.size(), expected.size());
    for (std::size_t i = 0; i < moved.size(); ++i) {
        if ((std::size_t(own_.first) + i / 3) % 5 == 0) {
            EXPECT_EQ(moved[i], numbers(ownPoints_)[i]) << "is outside";
        } else {
            // Both sides are sums of up to 64 products of positions up to 2 and weights that sum to
            // 1, in different orders. They differ by at most 64 ulp, and by about 8 in practice.
            EXPECT_NEAR(moved[i], expected[i], 64 * std::numeric_limits<double>::epsilon() * 2);
        }
    }
}

// A point outside does not move with the lattice, so its gradient is ignored.
TEST_F(DistributedBinding, AdjointAgreesWithTheReference) {
    const auto whole = bind(points_);
    DistributedTable distributed(MPI_COMM_WORLD, bind(ownPoints_).table, vertices_.count());
    const auto gradients = randomValues(3 * points_.size(), 8);
    std::vector<double> back(3 * vertices_.count(), 99);
    distributed.evaluateAdjoint(ownValues(gradients, own_, 3), back);

    const osd::CompiledAdjoint<double> adjoint(whole.table);
    std::vector<double> expected(3 * adjoint.rowCount(), 99);
    const auto layout = osd::BufferDescriptor::packed(3);
    adjoint.evaluate(gradients, layout, expected, layout, {0, adjoint.rowCount()});
    const auto own = ownValues(expected, vertices_, 3);
    ASSERT_EQ(back.size(), own.size());
    // Gradients of 400 points are up to 1, and the weights of each sum to 1. The rounding error is
    // at most one ulp of a sum below 400 for each product; in practice errors cancel, and it is
    // about the square root of this bound.
    for (std::size_t i = 0; i < back.size(); ++i)
        EXPECT_NEAR(back[i], own[i], 400 * std::numeric_limits<double>::epsilon());
}

}  // namespace
}  // namespace espalier::petsc
