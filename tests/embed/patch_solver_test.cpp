// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/patch_solver.h>
#include <espalier/stencils/composition.h>

#include "support/complexes.h"
#include "support/refined_lattice.h"
#include "support/test.h"

namespace espalier::embed {
namespace {

using Eigen::Vector3d;
using Answer = PatchSolver::Answer;

/// Returns the patch of the middle cell of 3 × 3 × 3, with vertices displaced from the grid by up
/// to `bend`.
TricubicPatch::ControlPoints bentPatch(double bend, std::mt19937& random) {
    const std::array<Index, 3> n = {3, 3, 3};
    const TopologyRefiner refiner(test::grid(n));
    std::uniform_real_distribution<double> off(-bend, bend);
    std::vector<Point3> positions;
    for (Index k = 0; k <= 3; ++k)
        for (Index j = 0; j <= 3; ++j)
            for (Index i = 0; i <= 3; ++i) {
                const double x = off(random), y = off(random), z = off(random);
                positions.push_back({i + x, j + y, k + z});
            }
    const auto frame = frameOf(refiner.level(0).complex, 13);
    return TricubicPatch(refiner.level(0), *frame).controlPoints(positions);
}

// No point of a patch is ever proved to be outside, however bent the patch is.
TEST(PatchSolver, NeverExcludesPointsInside) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const double bend : {0.0, 0.2, 0.5, 1.0, 3.0}) {
        int found = 0;
        for (int patch = 0; patch < 40; ++patch) {
            const PatchSolver solver(bentPatch(bend, random));
            for (int i = 0; i < 25; ++i) {
                Vector3d uvw(unit(random), unit(random), unit(random));
                if (i % 5 == 0) uvw[i % 3] = i % 2;  // On a face.
                const Vector3d point = solver.position(uvw);
                const auto result = solver.find(point);
                ASSERT_NE(result.answer, Answer::Outside) << bend;
                if (result.answer != Answer::Inside) continue;
                ++found;
                // Newton's method has converged to the rounding of coordinates up to 6.
                ASSERT_LT((solver.position(result.uvw) - point).norm(), 1e-14);
            }
        }
        if (bend <= 0.2) {
            EXPECT_EQ(found, 1000);
        }
    }
}

// Where the map is nearly linear, every point outside is proved to be outside.
TEST(PatchSolver, ExcludesPointsOutside) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int patch = 0; patch < 40; ++patch) {
        const PatchSolver solver(bentPatch(0.05, random));
        ASSERT_TRUE(solver.isNearlyLinear());
        for (int i = 0; i < 25; ++i) {
            Vector3d uvw(unit(random), unit(random), unit(random));
            // The polynomial extends beyond the patch, and is injective a little further.
            uvw[i % 3] = i % 2 == 0 ? -0.2 * unit(random) - 1e-6 : 1 + 0.2 * unit(random) + 1e-6;
            ASSERT_EQ(solver.find(solver.position(uvw)).answer, Answer::Outside);
        }
    }
}

/// Returns a patch whose x-coordinates are squares of the distance from the middle along u.
TricubicPatch::ControlPoints foldedPatch() {
    TricubicPatch::ControlPoints points;
    for (std::size_t i = 0; i < 64; ++i) {
        const double u = double(i % 4) - 1.5;
        points[i] = {u * u, double(i / 4 % 4), double(i / 16)};
    }
    return points;
}

// Where isOneToOne() is true, different places have different positions: as in a patch with little
// bend, and not in one that folds.
TEST(PatchSolver, TellsWhetherTheMapIsOneToOne) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const double spacing : {kLimitSpacing, spacingOf(1), spacingOf(3)}) {
        EXPECT_TRUE(PatchSolver(bentPatch(0.1, random), spacing).isOneToOne());
        // Long cells, in a shear: the Jacobian changes by more than 1 in the directions of the
        // axes.
        TricubicPatch::ControlPoints sheared;
        for (std::size_t i = 0; i < 64; ++i) {
            const double u = double(i % 4), v = double(i / 4 % 4);
            sheared[i] = {u + v * v, v, double(i / 16)};
        }
        EXPECT_TRUE(PatchSolver(sheared, spacing).isOneToOne());
        EXPECT_FALSE(PatchSolver(foldedPatch(), spacing).isOneToOne());
        auto flat = bentPatch(0, random);
        for (Vector3d& point : flat) point[2] = 0;
        EXPECT_FALSE(PatchSolver(flat, spacing).isOneToOne());
        int count = 0;
        for (int patch = 0; patch < 100; ++patch) {
            const PatchSolver solver(bentPatch(0.4, random), spacing);
            if (!solver.isOneToOne()) continue;
            ++count;
            // A one-to-one map has one orientation: steps along the axes span no negative volume.
            const double step = spacing > 0 ? spacing : 1e-3;
            const auto orientation = [&](const Vector3d& uvw) {
                Eigen::Matrix3d steps;
                for (Eigen::Index axis = 0; axis < 3; ++axis)
                    steps.col(axis) =
                        solver.position(uvw + step * Vector3d::Unit(axis)) - solver.position(uvw);
                return steps.determinant() > 0;
            };
            for (int i = 0; i < 30; ++i) {
                const Vector3d uvw(unit(random), unit(random), unit(random));
                ASSERT_TRUE(orientation(uvw * (1 - step)));
            }
        }
        EXPECT_GT(count, 10) << "else nothing was tested";
    }
}

TEST(PatchSolver, NearestPlace) {
    std::mt19937 random(3);
    const PatchSolver solver(bentPatch(0, random));
    // The patch is a unit cube with its lowest corner at (1, 1, 1).
    const Vector3d nearest = solver.position(solver.nearest({5, 1.5, 0}));
    EXPECT_LT((nearest - Vector3d(2, 1.5, 1)).norm(), 1e-12);
}

TEST(PatchSolver, FindsPointsOfFlatPatches) {
    std::mt19937 random(4);
    auto points = bentPatch(0, random);
    for (Vector3d& point : points) point[2] = 0;
    const PatchSolver solver(points);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 20; ++i) {
        const Vector3d point = solver.position({unit(random), unit(random), unit(random)});
        const auto found = solver.find(point);
        ASSERT_EQ(found.answer, Answer::Inside);
        // About ten units in the last place of coordinates of size 3.
        EXPECT_LT((solver.position(found.uvw) - point).norm(), 2e-14);
        EXPECT_EQ(solver.find(point + Vector3d(0, 0, 1e-9)).answer, Answer::Outside);
    }
}

// The weights and the control points tell of the same map, phantoms included.
TEST(TricubicPatch, WeightsAndControlPointsAgree) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    const std::array<Index, 3> n = {3, 1, 2};
    const TopologyRefiner refiner(test::grid(n));
    const far::Level& level = refiner.level(0);
    std::vector<Point3> positions;
    for (Index v = 0; v < level.complex.count(0); ++v)
        positions.push_back({unit(random), unit(random), unit(random)});
    for (Index cell = 0; cell < level.complex.count(3); ++cell) {
        const TricubicPatch patch(level, *frameOf(level.complex, cell));
        const TricubicMap map(patch.controlPoints(positions));
        const Vector3d uvw(unit(random), unit(random), unit(random));
        const auto tangent = map.tangent(uvw);
        const auto sum = [&](const std::array<int, 3>& orders) {
            Vector3d result = Vector3d::Zero();
            for (const auto& [vertex, weight] : patch.weights(uvw, orders))
                result += weight * Vector3d(positions[vertex].data());
            return result;
        };
        EXPECT_LT((sum({0, 0, 0}) - tangent.position).norm(), 1e-14);
        EXPECT_LT((sum({1, 0, 0}) - tangent.jacobian.col(0)).norm(), 1e-14);
        EXPECT_LT((sum({0, 1, 0}) - tangent.jacobian.col(1)).norm(), 1e-14);
        EXPECT_LT((sum({0, 0, 1}) - tangent.jacobian.col(2)).norm(), 1e-14);
    }
}

// On a level the map is trilinear between the vertices that refinement makes.
TEST(TricubicPatch, LevelsAreTrilinearBetweenRefinedVertices) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    const std::array<Index, 3> n = {3, 1, 2};
    for (const int level : {1, 2, 3}) {
        TopologyRefiner refiner(test::grid(n));
        std::vector<Point3> positions;
        for (Index v = 0; v < refiner.level(0).complex.count(0); ++v)
            positions.push_back({unit(random), unit(random), unit(random)});
        refiner.refineUniform(level);
        const auto refined = stencils::refinePositions(refiner, level, positions);
        for (Index cell = 0; cell < refiner.level(0).complex.count(3); ++cell) {
            const TricubicPatch patch(refiner.level(0), *frameOf(refiner.level(0).complex, cell));
            const TricubicMap map(patch.controlPoints(positions), spacingOf(level));
            // The child cell that has a random place, by its corners nearest to the place.
            Vector3d uvw(unit(random), unit(random), unit(random));
            CellFrame frame = *frameOf(refiner.level(0).complex, cell);
            Vector3d inChild = uvw;
            for (int k = 0; k < level; ++k) {
                std::size_t corner = 0;
                for (Eigen::Index axis = 0; axis < 3; ++axis) {
                    const bool isHigh = inChild[axis] >= 0.5;
                    corner += std::size_t{isHigh} << axis;
                    inChild[axis] = 2 * inChild[axis] - (isHigh ? 1 : 0);
                }
                frame =
                    *childOf(refiner.level(k).complex, refiner.refinement(k + 1), frame, corner);
            }
            Vector3d expected = Vector3d::Zero();
            for (std::size_t corner = 0; corner < 8; ++corner) {
                double weight = 1;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double t = inChild[Eigen::Index(axis)];
                    weight *= bitOf(corner, axis) != 0 ? t : 1 - t;
                }
                expected += weight * vec(refined[frame.corners[corner]]);
            }
            EXPECT_LT((map.position(uvw) - expected).norm(), 1e-14);
            Vector3d sum = Vector3d::Zero();
            const auto along = patch.axisWeights(uvw, spacingOf(level));
            std::vector<Index> vertices(TricubicPatch::rowLength(along));
            std::vector<double> weights(vertices.size());
            patch.writeRow(along, vertices.data(), weights.data());
            for (std::size_t k = 0; k < vertices.size(); ++k)
                sum += weights[k] * vec(positions[vertices[k]]);
            EXPECT_LT((sum - expected).norm(), 1e-14);
            // The map is linear along an axis for less than a step, so a difference is the slope.
            const double step = 1e-6;
            if (inChild[0] > 0.9) continue;
            EXPECT_LT((map.tangent(uvw).jacobian.col(0) -
                       (map.position(uvw + step * Vector3d::UnitX()) - map.position(uvw)) / step)
                          .norm(),
                      1e-8);
        }
    }
}

// The axes of a cell continue into its neighbours and its children.
TEST(CellFrame, NeighboursAndChildrenKeepTheAxes) {
    const std::array<Index, 3> n = {2, 2, 2};
    TopologyRefiner refiner = refined(test::grid(n), 1);
    const CellComplex& complex = refiner.level(0).complex;
    const auto frame = *frameOf(complex, 0);
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const std::size_t side : {0U, 1U}) {
            const auto neighbour = neighbourOf(complex, frame, axis, side);
            if (!neighbour) continue;
            const std::size_t step = std::size_t{1} << axis;
            for (std::size_t corner = 0; corner < 8; ++corner)
                if (bitOf(corner, axis) == side) {
                    EXPECT_EQ(neighbour->corners[corner ^ step], frame.corners[corner]);
                }
            // The neighbour's neighbour is the cell itself.
            EXPECT_EQ(neighbourOf(complex, *neighbour, axis, 1 - side)->corners, frame.corners);
        }
    for (std::size_t corner = 0; corner < 8; ++corner) {
        const auto child = childOf(complex, refiner.refinement(1), frame, corner);
        ASSERT_TRUE(child);
        // The child has vertex v as its corner, and the point of the cell opposite to it.
        const auto point = [&](Entity entity) {
            return refiner.refinement(1).childOf({entity, entity})->index;
        };
        EXPECT_EQ(child->corners[corner], point({0, frame.corners[corner]}));
        EXPECT_EQ(child->corners[7 - corner], point({3, 0}));
    }
}

}  // namespace
}  // namespace espalier::embed
