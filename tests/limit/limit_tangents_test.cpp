// SPDX-License-Identifier: Apache-2.0
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/limit/vertex_ring.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <Eigen/LU>

#include "support/random_lattices.h"
#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/tables.h"
#include "support/tangent_weights.h"
#include "support/test.h"
#include "support/zoo.h"

// Tests the gradients of bindLimit() at irregular features, where no polynomial gives them.
namespace espalier::limit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Bound = embed::BoundRows<>;

/// Returns the limits of the vertices of a level at rest: they cover every kind of feature of the
/// lattice.
std::vector<Point3> limitsOfLevel(const Lattice& lattice, int level) {
    TopologyRefiner refiner = refined(lattice.complex, level, refinerOptions(lattice));
    return stencils::applyLevelTable(buildVertexLimits(refiner, level), lattice.positions);
}

/// Returns F at point i in a pose.
Matrix3d gradientAt(const Bound& result, Index i, const Lattice& lattice,
                    const std::vector<Point3>& pose) {
    const auto tables =
        embed::gradientTables(*result.gradients, lattice.positions, result.table.rowCount());
    Matrix3d f;
    for (std::size_t axis = 0; axis < 3; ++axis)
        f.col(Eigen::Index(axis)) = times(tables[axis], pose).row(i).transpose();
    return f;
}

// In an affine pose F is the matrix of the map, however small the cells are that the tolerance
// requires.
TEST(LimitGradients, AffinePosesAreExactAtAnyTolerance) {
    Matrix3d map;
    map << 1.2, 0.3, -0.1, 0.2, 0.8, 0.4, -0.3, 0.1, 1.1;
    std::vector<NamedLattice> lattices = {
        {"seven sectors", shapes::cylinder({.sectors = 7, .layers = 2})}};
    if (!kIsSlow)
        for (auto& named : zoo()) lattices.push_back(std::move(named));
    for (const auto& [name, lattice] : lattices) {
        auto points = limitsOfLevel(lattice, 1);
        points.resize(std::min<std::size_t>(points.size(), 6));
        auto pose = lattice.positions;
        for (Point3& p : pose) p = toPoint(map * vec(p) + Vector3d(0.3, -0.7, 0.2));
        const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
        for (const double tolerance : {1e-2, 1e-6, 1e-8, 1e-9, 1e-12, 1e-14}) {
            const Bound result = bindLimit({base, lattice.positions}, points,
                                           {.tolerance = tolerance, .gradients = true});
            const auto tables = embed::gradientTables(*result.gradients, lattice.positions,
                                                      result.table.rowCount());
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto& rows = tables[axis];
                const auto column = times(rows, pose);
                for (Index i = 0; i < rows.rowCount(); ++i) {
                    if (rows.columns(i).empty()) continue;  // The lattice has no volume there.
                    // The rounding of the rows of directions at rest, divided by the thinness of
                    // the cells that they span: 1 to about 10,000 here.
                    EXPECT_LT((column.row(i).transpose() - map.col(Eigen::Index(axis))).norm(),
                              1e-11)
                        << name << " point " << i << " tolerance " << tolerance;
                }
            }
        }
    }
}

/// Returns F at the middle vertex of the axis of a cylinder, computed from eigenvectors. Two
/// eigenvectors of the second eigenvalue give the plane. Along the axis the ring is a product of
/// the ring of the plane and the ring of a line, so the third is the difference of the points above
/// and below, which each level halves.
Matrix3d gradientOnAxis(const Lattice& lattice, Index vertex, const std::vector<Point3>& pose) {
    TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    const far::Level& level = refiner.level(0);
    const VertexRing ring = ringOf(level, refiner.options(), vertex);
    const Eigen::MatrixXd m = Eigen::MatrixXd(ring.subdivision).transpose();
    Eigen::MatrixXd functionals(m.rows(), 3);
    functionals.leftCols(2) = tangentWeights(m.transpose());
    Eigen::VectorXd along = Eigen::VectorXd::Zero(m.rows());
    const auto heightOf = [&](Index v) { return lattice.positions[v][2]; };
    for (std::size_t i = 0; i < ring.entities.size(); ++i) {
        if (ring.entities[i].dimension != 1) continue;
        const auto ends = level.complex.relation(1, 0)[ring.entities[i].index];
        const Index other = ends[0] == vertex ? ends[1] : ends[0];
        const double rise = heightOf(other) - heightOf(vertex);
        if (std::abs(rise) > 1e-6) along[Eigen::Index(i)] = rise > 0 ? 1 : -1;
    }
    EXPECT_EQ(along.cwiseAbs().sum(), 2);
    for (int k = 0; k < 50; ++k) {
        along = 2 * (m * along);
        along[0] -= along.sum();  // The rounding of the sum would double in each step.
    }
    functionals.col(2) = along;
    const Eigen::MatrixXd start(ring.start);
    const auto at = [&](const std::vector<Point3>& positions) -> Matrix3d {
        return functionals.transpose() * start * asMatrix(positions)(ring.vertices, Eigen::all);
    };
    return (at(lattice.positions).inverse() * at(pose)).transpose();
}

// Around edges of many cells, the plane has modes that shrink more slowly than the axis (0.611 for
// 16 cells, against 0.5), and hardly faster than the tangents (0.643).
TEST(LimitGradients, EqualTheEigenvectorsOnIrregularEdges) {
    for (const int sectors : {5, 7, 9, 12, 16}) {
        const Lattice lattice = shapes::cylinder({.sectors = sectors, .layers = 2});
        Index middle = kMaxIndex;
        for (Index v = 0; v < lattice.complex.count(0); ++v)
            if (std::ssize(lattice.complex.relation(0, 3)[v]) == 2 * sectors) middle = v;
        ASSERT_NE(middle, kMaxIndex);
        const auto pose = shaken(lattice.positions, 3);
        const Matrix3d expected = gradientOnAxis(lattice, middle, pose);
        const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
        const std::vector<Index> vertices = {middle};
        const auto point =
            stencils::applyLevelTable(buildVertexLimits(base, 0, vertices), lattice.positions);
        for (const double tolerance : {1e-6, 1e-12}) {
            const Bound result = bindLimit({base, lattice.positions}, point,
                                           {.tolerance = tolerance, .gradients = true});
            // For 16 cells both computations have this accuracy: the eigenvalues are 0.03 apart,
            // and the rounding of the axis grows by 1.22 per level while the axis converges.
            EXPECT_LT((gradientAt(result, 0, lattice, pose) - expected).norm(), 1e-8)
                << sectors << " sectors, tolerance " << tolerance;
        }
    }
}

// F is continuous between a feature and the points beside it, where patches give F.
TEST(LimitGradients, AreContinuousAtFeatures) {
    const Lattice lattice = shapes::cylinder({.sectors = 7, .layers = 2});
    auto pose = lattice.positions;
    for (Point3& p : pose) p = {p[0] + 0.3 * p[2] * p[2], p[1] - 0.2 * p[0] * p[2], p[2]};
    const TopologyRefiner base(lattice.complex);
    double before = 0;
    for (const double step : {1e-2, 1e-4, 1e-6, 1e-8}) {
        const std::vector<Point3> points = {{0, 0, 0.2}, {step, 0.3 * step, 0.2 + 0.5 * step}};
        const Bound result = bindLimit({base, lattice.positions}, points, {.gradients = true});
        ASSERT_EQ(result.count(embed::PointStatus::Inside), 2);
        const double change =
            (gradientAt(result, 1, lattice, pose) - gradientAt(result, 0, lattice, pose)).norm();
        // The change is a power of the distance: each level multiplies the distance by 0.5985 and
        // the change by 0.4619/0.5985. So at a hundredth of the distance the change is a tenth.
        if (before > 0) {
            EXPECT_LT(change, before / 9) << step;
        }
        before = change;
    }
}

}  // namespace
}  // namespace espalier::limit
