// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>

#include "support/skew_boxes.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::limit {
namespace {

/// Returns the points of a grid with 6 steps per cell, from `low` to cells − low along each axis.
/// In the cells of every level they are at u = 0, 1/3 or 2/3, so u(1 − u) of a point is the same on
/// every level.
std::vector<Point3> sixths(const Cells& cells, Index low) {
    std::vector<Point3> points;
    for (Index k = 6 * low; k <= 6 * (cells[2] - low); ++k)
        for (Index j = 6 * low; j <= 6 * (cells[1] - low); ++j)
            for (Index i = 6 * low; i <= 6 * (cells[0] - low); ++i)
                points.push_back({i / 6., j / 6., k / 6.});
    return points;
}

/// Returns, for each level, the largest distance from `limit` of the points deformed by that level.
std::vector<double> distancesOfLevels(const Cells& n, Boundary boundary,
                                      const std::vector<Point3>& pose,
                                      const std::vector<Point3>& points, const Positions& limit,
                                      int levels) {
    TopologyRefiner refiner(test::grid(n), {.boundary = boundary});
    std::vector<double> distances;
    for (int level = 1; level <= levels; ++level) {
        refiner.refineUniform(level);
        const auto positions = stencils::refinePositions(refiner, level, gridPositions(n));
        const auto embedding =
            embed::embedPoints(refiner.level(level).complex, positions, points,
                               embed::EmbeddingOptions{.outside = embed::OutsidePolicy::Error});
        const auto table = embed::buildDeformationTable(refiner, level, embedding);
        distances.push_back(largestDistance(times(table, pose), limit));
    }
    return distances;
}

/// Checks that distances fall with order 2. The reason: the control net of level n is the limit f
/// minus h²/6 times its second derivatives (the polar form of x² at (x − h, x, x + h) is x² −
/// h²/3), and trilinear interpolation adds h²/2 · u(1 − u) times these derivatives along each axis.
/// For the points of sixths(), both are h² times the same value on each level; the rest is of order
/// h⁴. Each level halves h.
void expectOrderTwo(const std::vector<double>& distances) {
    for (std::size_t level = 3; level <= distances.size(); ++level) {
        const double order = std::log2(distances[level - 2] / distances[level - 1]);
        EXPECT_GT(order, 1.9) << "from level " << level - 1 << " to " << level;
        EXPECT_LT(order, 2.1) << "from level " << level - 1 << " to " << level;
    }
}

// MacCracken & Joy, section 2.1: the refinement rules are the tricubic B-spline's, so the levels
// converge to the B-spline lattice.
TEST(TensorLimit, BSplineLatticeIsTheLimitOfOpenLattices) {
    const Cells n = {3, 4, 3};
    const auto rest = gridPositions(n);
    const auto pose = shaken(rest, 18);
    const auto points = sixths(n, 1);
    const embed::TensorLattice lattice(test::grid(n), rest, embed::Basis::BSpline);
    const Positions limit = times(tableOf(lattice, points), pose);
    // The pose is a deformation, not the identity.
    ASSERT_GT(largestDistance(limit, asMatrix(points)), 0.1);
    const auto distances = distancesOfLevels(n, Boundary::Open, pose, points, limit, 4);
    expectOrderTwo(distances);
    // The distance tends to 0.
    EXPECT_LT(distances.back(), 2e-3);
}

/// Adds a layer of phantom vertices 2P₀ − P₁ around a pose, one axis after another.
std::vector<Point3> withPhantoms(const Cells& n, const std::vector<Point3>& pose) {
    using Share = std::pair<Index, double>;
    const auto shares = [](Index cells, Index at) -> std::vector<Share> {
        if (at == 0) return {{0, 2}, {1, -1}};
        if (at == cells + 2) return {{cells, 2}, {cells - 1, -1}};
        return {{at - 1, 1}};
    };
    std::vector<Point3> padded;
    for (Index k = 0; k <= n[2] + 2; ++k)
        for (Index j = 0; j <= n[1] + 2; ++j)
            for (Index i = 0; i <= n[0] + 2; ++i) {
                Point3 sum = {};
                for (const Share& x : shares(n[0], i))
                    for (const Share& y : shares(n[1], j))
                        for (const Share& z : shares(n[2], k)) {
                            const Point3& p = pose[gridVertex(n, x.first, y.first, z.first)];
                            for (std::size_t axis = 0; axis < 3; ++axis)
                                sum[axis] += x.second * y.second * z.second * p[axis];
                        }
                padded.push_back(sum);
            }
    return padded;
}

// With boundary control, a box of any size is the B-spline with a phantom layer.
TEST(TensorLimit, BSplineLatticeWithPhantomsIsTheLimitOfSharpBoxes) {
    const Cells n = {2, 1, 1}, padded = {4, 3, 3};
    const auto rest = gridPositions(n);
    const auto pose = shaken(rest, 19);
    const auto points = sixths(n, 0);
    const embed::TensorLattice lattice(test::grid(padded), withPhantoms(n, rest),
                                       embed::Basis::BSpline);
    const Positions limit = times(tableOf(lattice, points), withPhantoms(n, pose));
    ASSERT_GT(largestDistance(limit, asMatrix(points)), 0.1);
    expectOrderTwo(distancesOfLevels(n, Boundary::Sharp, pose, points, limit, 4));
}

}  // namespace
}  // namespace espalier::limit
