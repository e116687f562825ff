// SPDX-License-Identifier: Apache-2.0
#include <espalier/limit/limit_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <Eigen/LU>

#include "poses.h"
#include "solve/validity_pieces.h"
#include "support/random_lattices.h"
#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::solve {
namespace {

using limit::LimitParts;
using limit::LimitPositions;

LimitParts partsOf(const Lattice& lattice, int level) {
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    return LimitParts(base, level);
}

/// Positions of a bar of three cells along x, with vertices at 0, 1 + a, 2 − a, 3.
Positions pinched(const Lattice& bar, double a) {
    Positions result = bar.positions;
    for (Point3& p : result)
        if (p[0] == 1 || p[0] == 2) p[0] += p[0] == 1 ? a : -a;
    return result;
}

const Lattice& bar() {
    static const Lattice lattice = shapes::box({.cells = {3, 1, 1}, .max = {3, 1, 1}});
    return lattice;
}

// The spline has the differences 1 + a, 1 − 2a, 1 + a. Its derivative is a quadratic spline of
// these, and smallest in the middle: (1 + a + 6 (1 − 2a) + 1 + a) / 8 = 1 − 5a/4. At the ends it is
// 1 + a, since the phantom has the same difference.
TEST(LimitValidity, PinchedBar) {
    const ValidityCheck validity(partsOf(bar(), 1), bar().positions);
    EXPECT_THAT(validity.badAtRest(), IsEmpty());
    const PoseValidity half = validity.check(pinched(bar(), 0.4));
    EXPECT_THAT(half.inverted, IsEmpty());
    EXPECT_EQ(half.smallest->cell, 1);
    EXPECT_LE(half.smallest->value, 0.5);
    EXPECT_GE(half.smallest->value, 0.5 * (1 - 1.1e-3));
    const PoseValidity folded = validity.check(pinched(bar(), 1));
    EXPECT_THAT(folded.inverted, ElementsAre(1));
    EXPECT_NEAR(folded.smallest->value, -0.25, 1e-3);
    const LargestStep step = validity.largestStep(pinched(bar(), 1), 3);
    EXPECT_LE(step.length, 0.8);
    EXPECT_GE(step.length, 0.8 * (1 - 2e-6));
    EXPECT_EQ(step.limitingCell, 1);
    EXPECT_TRUE(step.isTight);
    // The cells of level 0 fold where 1 − 2a = 0.
    EXPECT_NEAR(ValidityCheck(bar().complex, bar().positions).largestStep(pinched(bar(), 1)).length,
                0.5, 1e-6);
}

// The limit of a single cell is its trilinear map, since a spline of two points is linear.
TEST(LimitValidity, OneCellIsTrilinear) {
    const Lattice cube = shapes::box();
    Positions pose = cube.positions;
    pose[7] = {-2, -2, -2};  // Its determinant is 1 − 3 (vw + uw + uv): see Validity.
    const ValidityCheck validity(partsOf(cube, 1), cube.positions);
    EXPECT_NEAR(validity.check(pose).smallest->value, -8, 8e-3);
    EXPECT_NEAR(validity.largestStep(pose).length, 1.0 / 9, 1e-6);
}

// Compares with the determinant of the deformation gradient of a binding, which is an independent
// computation: by weights of derivatives, and Newton's method.
TEST(LimitValidity, AgreesWithSampledGradients) {
    int invertedCount = 0, limitedCount = 0;
    for (const Lattice& lattice :
         {shapes::box({.cells = {3, 2, 2}, .max = {3, 2, 2}}), shapes::cylinder({.sectors = 5}),
          shapes::octahedron(), mixedLattice()}) {
        const Refined refined(lattice, 1);
        limit::LimitOptions options;
        options.gradients = true;
        const auto points = pointsIn(refined, kIsSlow ? 20 : 100, 3);
        const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
        const auto bound = limit::bindLimit({base, lattice.positions}, points, options);
        const auto tables =
            embed::gradientTables(*bound.gradients, lattice.positions, bound.table.rowCount());
        /// Returns the smallest determinant of the points in cells.
        const auto sampled = [&](const Positions& pose) {
            std::array<Positions, 3> columns;
            for (std::size_t c = 0; c < 3; ++c)
                columns[c] = stencils::applyLevelTable(tables[c], pose);
            double least = kInfinity;
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (bound.statuses[i] != embed::PointStatus::Inside) continue;
                Eigen::Matrix3d gradient;
                for (std::size_t c = 0; c < 3; ++c)
                    gradient.col(Eigen::Index(c)) = vec(columns[c][i]);
                least = std::min(least, gradient.determinant());
            }
            return least;
        };
        ASSERT_LT(sampled(lattice.positions), 2);  // There are some.
        const ValidityCheck validity(partsOf(lattice, 3), lattice.positions);
        ASSERT_THAT(validity.badAtRest(), IsEmpty());
        for (unsigned seed = 0; seed < (kIsSlow ? 2 : 4); ++seed) {
            const Positions pose = shaken(lattice.positions, seed, 0.8);
            const PoseValidity checked = validity.check(pose);
            // Blends of level 3 differ by a tenth from the blends of a binding, which are of size
            // 1e-6.
            const double least = sampled(pose);
            EXPECT_LE(checked.smallest->value, least + 0.1 * std::abs(least));
            invertedCount += !checked.inverted.empty();
            const LargestStep step = validity.largestStep(pose, 1.5);
            for (const double part : {0.2, 0.6, 0.95})
                EXPECT_GT(sampled(moved(lattice.positions, pose, part * step.length)), 0);
            if (!step.limitingCell) continue;
            ++limitedCount;
            EXPECT_THAT(
                validity.check(moved(lattice.positions, pose, step.length * (1 + 1e-4))).inverted,
                Contains(*step.limitingCell));
            EXPECT_THAT(validity.check(moved(lattice.positions, pose, step.length)).inverted,
                        IsEmpty());
        }
    }
    EXPECT_GT(invertedCount, 1);
    EXPECT_GT(limitedCount, 4);
}

/// Returns the volume: the volume of a part is the mean of the coefficients of its determinant.
/// \param lattice a lattice whose cells become hexahedra
double volumeOf(const Lattice& lattice, int level) {
    const CheckedVolume volume(partsOf(lattice, level));
    const LimitPositions positions = volume.place(lattice.positions);
    double sum = 0;
    for (Index part = 0; part < volume.partCount(); ++part) {
        volume.forEachPiece(
            part,
            [&](const auto& piece) {
                const auto polynomial = determinant(piece.derivatives);
                for (const auto& lanes : polynomial) sum += lanes[0] / double(polynomial.size());
            },
            positions);
    }
    return sum;
}

// Parts of all levels fill the limit, without relevant gaps or overlaps: the volume does not depend
// on the level of refinement of features, except for the blended cells. Their volume falls by 4 or
// more per level, and their relative error by 4.
TEST(LimitValidity, PartsFillTheLimit) {
    const Lattice box = shapes::box({.cells = {3, 2, 2}, .max = {3, 2, 2}});
    EXPECT_NEAR(volumeOf(box, 1), 12, 1e-12);
    const Lattice fan = shapes::cylinder({.sectors = 5, .layers = 2});
    double before = 0, difference = 0;
    for (int level = 1; level <= 5; ++level) {
        const double now = volumeOf(fan, level);
        if (level > 2) {
            EXPECT_LT(std::abs(now - before), difference / 4) << level;
        }
        difference = std::abs(now - before);
        before = now;
    }
    EXPECT_LT(difference, 1e-4);
}

TEST(LimitValidity, RatiosAreOneAtRest) {
    for (const auto& [name, lattice] : zoo()) {
        const ValidityCheck validity(partsOf(lattice, 2), lattice.positions);
        if (name == "tripod") continue;  // Its limit is folded.
        EXPECT_THAT(validity.badAtRest(), IsEmpty()) << name;
        const PoseValidity same = validity.check(lattice.positions);
        EXPECT_THAT(same.inverted, IsEmpty()) << name;
        // The floor, relative to a determinant of at least 1e-4 of the lengths, is subtracted.
        EXPECT_NEAR(same.smallest->value, 1, 1e-8) << name;
        EXPECT_EQ(validity.largestStep(lattice.positions, 5).length, 5) << name;
    }
}

// A cell next to a box of three cells along each axis has all its vertices on the boundary.
TEST(LimitValidity, CellsThatShrinkAwayAreNeitherGoodNorBad) {
    const Lattice lattice = carvedGrid(
        {4, 3, 3}, [](Index i, Index j, Index k) { return i < 3 || (j == 1 && k == 1); });
    Index beside = 0;
    const auto isBeside = [&](Index cell) {
        const auto vertices = lattice.complex.relation(3, 0)[cell];
        return std::any_of(vertices.begin(), vertices.end(),
                           [&](Index v) { return lattice.positions[std::size_t(v)][0] == 4; });
    };
    while (!isBeside(beside)) ++beside;
    const TopologyRefiner base(lattice.complex, {.boundary = Boundary::Open});
    const ValidityCheck validity(LimitParts(base, 2), lattice.positions);
    EXPECT_THAT(validity.badAtRest(), IsEmpty());
    Positions pose = lattice.positions;
    for (Point3& p : pose) p[0] *= 2;
    const PoseValidity checked = validity.check(pose);
    ASSERT_THAT(checked.ratios, SizeIs(28));
    for (Index cell = 0; cell < 28; ++cell) {
        const auto& ratio = checked.ratios[std::size_t(cell)];
        ASSERT_EQ(ratio.has_value(), cell != beside) << cell;
        if (ratio) {
            EXPECT_NEAR(*ratio, 2, 1e-9);
        }
    }
    EXPECT_THAT(checked.inverted, IsEmpty());
}

TEST(LimitValidity, DoesNotDependOnThreads) {
    const Lattice lattice = shapes::cylinder({.sectors = 4, .layers = 3});
    const Positions pose = shaken(lattice.positions, 8, 0.4);
    const auto work = [&] {
        const ValidityCheck validity(partsOf(lattice, 3), lattice.positions);
        const LargestStep step = validity.largestStep(pose);
        return std::tuple(validity.check(pose).ratios, step.length, step.limitingCell);
    };
    const auto one = withThreads(1, work);
    for (const int threads : {2, 5}) EXPECT_EQ(withThreads(threads, work), one);
}

TEST(LimitValidity, RefusesBadInputByName) {
    const Lattice cube = shapes::box();
    const Positions few(7);
    EXPECT_REFUSED(Error, "got 7 positions of the rest for 8",
                   ValidityCheck(partsOf(cube, 1), few));
    const ValidityCheck validity(partsOf(cube, 1), cube.positions);
    Positions broken = cube.positions;
    broken[5][1] = kNan;
    EXPECT_REFUSED(Error, "the pose of vertex 5 is not finite", validity.check(broken));
}

}  // namespace
}  // namespace espalier::solve
