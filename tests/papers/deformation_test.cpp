// SPDX-License-Identifier: Apache-2.0

#include "papers/frozen.h"
#include "papers/refined_grid.h"
#include "support/test.h"
#include "support/zoo.h"

// MacCracken & Joy 1996, sections 4 and 6: accuracy of the deformation, and convex combinations.
namespace espalier::stencils {
namespace {

using Eigen::Vector3d;

/// Returns the weights of points 0 to n of a polygon in the cubic B-spline with phantom points 2P0
/// − P1 at both ends, at x from 0 to n.
Row clampedSpline(double x, Index n) {
    Row row;
    const Row extended = splineAt(x + 1, n + 2);
    for (const auto& [i, weight] : extended.weights) {
        if (i == 0)
            row = row + weight * (2 * test::point(0) - test::point(1));
        else if (i == n + 2)
            row = row + weight * (2 * test::point(n) - test::point(n - 1));
        else
            row = row + weight * test::point(i - 1);
    }
    return row;
}

// Section 4: "whereas this is an approximation, it can be made arbitrarily close to the actual
// deformation". For a box the deformation is known: it is the tricubic B-spline with a phantom
// layer, whose parameter is the position at rest. Trilinear pieces between control points differ
// from a spline by the square of their size, so the error falls fourfold with each level.
TEST(Deformation, ApproximationConvergesToTheDeformation) {
    const std::array<Index, 3> cells = {3, 2, 4};
    const Lattice box = shapes::box({.cells = {3, 2, 4}, .max = {3, 2, 4}});
    const RefinedGrid grid({3, 2, 4}, 0, Boundary::Sharp);
    const std::size_t count = 400;
    std::vector<Point3> points, pose = box.positions;
    const auto random = randomValues(3 * count, 1), noise = randomValues(3 * pose.size(), 2);
    for (std::size_t i = 0; i < pose.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) pose[i][c] += 0.4 * noise[3 * i + c];
    std::vector<Vector3d> exact;
    for (std::size_t i = 0; i < count; ++i) {
        Point3 p;
        for (std::size_t c = 0; c < 3; ++c) p[c] = (1 + random[3 * i + c]) / 2 * cells[c];
        points.push_back(p);
        const Row row = tensorProduct(grid, clampedSpline(p[0], 3), clampedSpline(p[1], 2),
                                      clampedSpline(p[2], 4));
        exact.push_back(Vector3d::Zero());
        for (const auto& [vertex, weight] : row.weights) exact.back() += weight * vec(pose[vertex]);
    }
    double before = 0;
    for (int level = 1; level <= 4; ++level) {
        const std::vector<Point3> posed = Frozen(box, level, points).posed(pose);
        double squares = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
            squares += (vec(posed[i]) - exact[i]).squaredNorm();
        const double error = std::sqrt(squares / count);
        if (level > 1) {
            // The remaining error is of higher order: it falls faster, and is visible on coarse
            // levels.
            EXPECT_NEAR(before / error, 4, std::ldexp(2.4, -level)) << level;
        }
        before = error;
    }
    EXPECT_LT(before, 1e-3);
}

// Section 6: places in hexahedra, and in tetrahedra around the average of the cell's vertices, have
// no negative weights of the vertices of their cell, so that a point in a cell stays in its hull.
// If inner edges and surface vertices have three faces or more, no rule has negative weights, so
// that points stay in the hull of the lattice.
TEST(Deformation, PointsInsideAreConvexCombinations) {
    for (const auto& [name, lattice] : zoo()) {
        const TopologyRefiner refiner = refined(lattice, 2);
        const auto& complex = refiner.level(2).complex;
        const auto positions = positionsAt(lattice, refiner, 2);
        std::vector<Point3> points;
        for (Index cell = 0; cell < complex.count(3); cell += 7) {
            Vector3d sum = Vector3d::Zero();
            double total = 0, weight = 1;
            for (const Index vertex : complex.relation(3, 0)[cell]) {
                weight = std::fmod(weight * 1.7, 1.3) + 0.1;
                sum += weight * vec(positions[vertex]);
                total += weight;
            }
            points.push_back({sum[0] / total, sum[1] / total, sum[2] / total});
        }
        const embed::Embedding embedding = embed::embedPoints(complex, positions, points);
        const auto inCell = embed::buildEmbeddingTable(complex, embedding);
        const auto inLattice = embed::buildDeformationTable(refiner, 2, embedding);
        for (Index i = 0; i < inCell.rowCount(); ++i) {
            const auto& located = embedding.points[i];
            // A point in a gap between cells has a place slightly outside of one.
            if (located.place && located.place->offset != std::array<double, 3>{}) continue;
            for (const auto* table : {&inCell, &inLattice})
                for (const double w : table->weights(i)) {
                    // Rounding may put a place outside its cell.
                    ASSERT_GE(w, -1e-12) << name;
                    ASSERT_LE(w, 1 + 1e-12) << name;
                }
        }
    }
}

}  // namespace
}  // namespace espalier::stencils
