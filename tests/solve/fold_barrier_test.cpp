// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/solve/validity.h>

#include "solve/fold_barrier.h"
#include "support/lattices_with_limbs.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::solve {
namespace {

using Columns = Eigen::MatrixX3d;

FoldBarrier barrierOf(const Lattice& lattice, std::vector<char> isFixed = {}) {
    isFixed.resize(lattice.positions.size(), 0);
    return FoldBarrier(TopologyRefiner(lattice.complex), lattice.positions, isFixed);
}

/// The displacements of an affine map.
Columns displacements(const Lattice& lattice, const Eigen::Matrix3d& map) {
    Columns moved(std::ssize(lattice.positions), 3);
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
        const Eigen::Vector3d position = vec(lattice.positions[v]);
        moved.row(v) = (map * position - position).transpose();
    }
    return moved;
}

Eigen::Matrix3d flattening(double height) {
    return Eigen::Vector3d(1, height, 1).asDiagonal();
}

const std::vector<Lattice>& lattices() {
    static const std::vector<Lattice> all = {shapes::box(),        figure(),
                                             shapes::octahedron(), shapes::star(),
                                             shapes::cylinder(),   shapes::arm()};
    return all;
}

// Every tetrahedron has the volume ratio of an affine map.
TEST(FoldBarrier, RisesAsAnAffineMapFlattens) {
    for (const Lattice& lattice : lattices()) {
        const FoldBarrier barrier = barrierOf(lattice);
        const auto energy = [&](double height) {
            return barrier.energy(displacements(lattice, flattening(height)));
        };
        EXPECT_EQ(energy(1), 0);
        EXPECT_EQ(energy(FoldBarrier::kActive * 1.001), 0);
        EXPECT_GT(energy(FoldBarrier::kActive * 0.9), 0);
        EXPECT_EQ(energy(0), kInfinity);
        EXPECT_EQ(energy(-1), kInfinity);
        // c V (h/J − 1)², with the same volumes at each height.
        EXPECT_NEAR(energy(0.025) / energy(0.125), 81, 1e-6);
    }
}

TEST(FoldBarrier, TheGradientIsTheDerivative) {
    for (const Lattice& lattice : lattices()) {
        const FoldBarrier barrier = barrierOf(lattice);
        Columns moved = displacements(lattice, flattening(0.15));
        const Columns direction = Columns(Eigen::Map<const Columns>(
            randomValues(std::size_t(3 * moved.rows()), 5).data(), moved.rows(), 3));
        Columns gradient = Columns::Zero(moved.rows(), 3);
        barrier.energy(moved, &gradient);
        constexpr double kStep = 1e-6;
        const double slope = (barrier.energy(moved + kStep * direction) -
                              barrier.energy(moved - kStep * direction)) /
                             (2 * kStep);
        EXPECT_NEAR((gradient.array() * direction.array()).sum(), slope, 1e-5 * std::abs(slope));
        EXPECT_GT(std::abs(slope), 1e-3);
    }
}

// A corner of the figure is pushed into its cell.
TEST(FoldBarrier, IsInfiniteBehindAFold) {
    const Lattice lattice = shapes::box({.cells = {2, 2, 2}, .min = {0, 0, 0}, .max = {2, 2, 2}});
    const FoldBarrier barrier = barrierOf(lattice);
    const Refined refined(lattice, 3);
    const ValidityCheck check(refined.complex(), refined.positions);
    int valid = 0, folded = 0;
    for (double way = 0; way < 1.5; way += 0.05) {
        auto pose = lattice.positions;
        Columns moved = Columns::Zero(std::ssize(pose), 3);
        for (std::size_t c = 0; c < 3; ++c) pose[0][c] += way;
        moved.row(0).setConstant(way);
        const bool isFolded = !check.check(refined.pose(pose)).inverted.empty();
        ++(isFolded ? folded : valid);
        EXPECT_EQ(std::isinf(barrier.energy(moved)), isFolded) << way;
    }
    EXPECT_GT(valid, 5);
    EXPECT_GT(folded, 5);
}

TEST(FoldBarrier, LeavesOutWhatStays) {
    const Lattice lattice = figure();
    const FoldBarrier barrier = barrierOf(lattice, std::vector<char>(lattice.positions.size(), 1));
    EXPECT_EQ(barrier.energy(displacements(lattice, flattening(-1))), 0);
}

TEST(FoldBarrier, DoesNotDependOnTheNumberOfThreads) {
    const Lattice lattice = shapes::box({.cells = {5, 5, 5}});
    const FoldBarrier barrier = barrierOf(lattice);
    const Columns moved = displacements(lattice, flattening(0.1));
    const auto run = [&] {
        Columns gradient = Columns::Zero(moved.rows(), 3);
        const double energy = barrier.energy(moved, &gradient);
        return std::pair(energy, gradient);
    };
    const auto one = withThreads(1, run);
    for (const int threads : {2, 5}) EXPECT_EQ(withThreads(threads, run), one);
}

}  // namespace
}  // namespace espalier::solve
