// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/deformer.h>

#include "sums.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::osd {
namespace {

/// A model in a lattice whose axis is irregular. Point 7 is far outside. With factors, many points
/// share each cell; without, few do, and D takes many numbers for each point.
struct Scene {
    Lattice lattice;
    std::vector<Point3> points;
    bind::Binding binding;

    explicit Scene(bool hasFactors)
        : lattice(hasFactors
                      ? shapes::cylinder({.sectors = 5})
                      : shapes::cylinder({.sectors = 8, .pattern = {.rings = 3}, .layers = 6})),
          points(pointsIn(Refined(lattice, 2), hasFactors ? 3000 : 300, 4)) {
        points[7] = {30, -4, 5};
        binding = bind::bindPoints({TopologyRefiner(lattice.complex), lattice.positions}, points,
                                   bind::Level{hasFactors ? 2 : 3, hasFactors});
    }

    std::vector<Point3> pose(int number) const {
        std::vector<Point3> result = lattice.positions;
        for (Point3& p : result) p = {p[0] + 0.1 * number * p[2], p[1] * (1 + 0.2 * number), p[2]};
        return result;
    }
};

template <class Real>
std::vector<Real> numbersOf(const std::vector<Point3>& positions) {
    std::vector<Real> result;
    for (const Point3& p : positions)
        for (const double x : p) result.push_back(static_cast<Real>(x));
    return result;
}

template <class Real>
std::vector<Real> deformed(const Deformer<Real>& deformer, const std::vector<Real>& poses) {
    std::vector<Real> result(
        poses.size() / (3 * deformer.vertexCount()) * 3 * deformer.pointCount(), 99);
    deformer.deform(poses, result);
    return result;
}

template <class Real>
class DeformerTest : public ::testing::Test {};
TYPED_TEST_SUITE(DeformerTest, Reals);

// From D and from its factors; one to nine poses in one call, so that there are groups of four
// poses and parts of a group. The plain evaluation is the witness.
TYPED_TEST(DeformerTest, AgreesWithThePlainEvaluation) {
    using Real = TypeParam;
    for (const bool hasFactors : {false, true}) {
        const Scene scene(hasFactors);
        ASSERT_EQ(scene.binding.factors.has_value(), hasFactors);
        const Deformer<Real> deformer(scene.binding);
        const std::size_t size = 3 * scene.points.size();
        EXPECT_EQ(deformer.pointCount(), std::ssize(scene.points));
        EXPECT_EQ(deformer.vertexCount(), std::ssize(scene.lattice.positions));
        // So D itself is evaluated for four poses at once, and the factors for one.
        EXPECT_EQ(deformer.byteCount() > (24 + 4) * sizeof(Real) * scene.points.size(),
                  !hasFactors);
        std::vector<Real> poses;
        for (int count = 1; count <= 9; ++count) {
            const auto pose = numbersOf<Real>(scene.pose(count));
            poses.insert(poses.end(), pose.begin(), pose.end());
            const auto moved = deformed(deformer, poses);
            const auto expected = evaluateBinding(scene.binding, scene.pose(count));
            const Real* const last = moved.data() + moved.size() - size;
            for (std::size_t i = 0; i < size; ++i)
                // Up to 64 products of weights below 1 and displacements below 2, and x below 2,
                // each rounded; and the roundings of the poses.
                ASSERT_NEAR(last[i], expected[i / 3][i % 3],
                            i / 3 == 7 ? 0 : 200 * std::numeric_limits<Real>::epsilon())
                    << count << " poses, number " << i;
        }
    }
}

// Where nothing moves, each point is exactly at x, rounded to Real.
TYPED_TEST(DeformerTest, AtRestNothingMoves) {
    using Real = TypeParam;
    for (const bool hasFactors : {false, true}) {
        const Scene scene(hasFactors);
        const Deformer<Real> deformer(scene.binding);
        EXPECT_EQ(deformed(deformer, numbersOf<Real>(scene.lattice.positions)),
                  numbersOf<Real>(scene.points));
    }
}

TYPED_TEST(DeformerTest, ChangesLeadToTheSamePoints) {
    using Real = TypeParam;
    for (const bool hasFactors : {false, true}) {
        const Scene scene(hasFactors);
        const Deformer<Real> deformer(scene.binding);
        auto pose = numbersOf<Real>(scene.pose(1));
        auto points = deformed(deformer, pose);
        for (const std::vector<Index>& changed : {std::vector<Index>{3}, {9, 0, 9}, {}}) {
            for (const Index vertex : changed) pose[3 * vertex + 1] += Real(0.25);
            deformer.deformChanged(pose, changed, points);
            EXPECT_EQ(points, deformed(deformer, pose));
        }
        const Index count = scene.binding.table.columnCount();
        for (const Index none : {count, -1})
            EXPECT_REFUSED(Error,
                           concat("vertex ", none, " is not in the lattice, which has ", count),
                           deformer.deformChanged(pose, std::vector<Index>{none}, points));
    }
}

// 1000 units from the origin, the error in float is half a unit in the last place: x is rounded
// once, and the displacement is small. D · p' in float would be off by three units.
TEST(Deformer, KeepsDigitsFarFromTheOrigin) {
    Lattice box = shapes::box({.cells = {3, 3, 3}});
    std::vector<Point3> points;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> part(0, 1);
    for (int i = 0; i < 2000; ++i) points.push_back({part(random), part(random), part(random)});
    for (auto* positions : {&box.positions, &points})
        for (Point3& p : *positions) p[0] += 1000;
    const auto binding =
        bind::bindPoints({TopologyRefiner(box.complex), box.positions}, points, bind::Level{2});
    auto pose = box.positions;
    for (Point3& p : pose) p[0] += 0.125 * std::round(p[1] * p[2] * 8);  // exact in float
    const auto expected = evaluateBinding(binding, pose);
    const auto moved = deformed(Deformer<float>(binding), numbersOf<float>(pose));
    double error = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        // Relative to the rounded points and vertices at rest, which no evaluation can improve.
        const double target = expected[i][0] - points[i][0] + double(float(points[i][0]));
        error = std::max(error, std::abs(double(moved[3 * i]) - target));
    }
    constexpr double kUnit = 6.1e-5;  // of floats from 512 to 1024
    EXPECT_LT(error, 0.51 * kUnit);
}

TEST(Deformer, RefusesOtherSizesAndWritesNothing) {
    const Scene scene(false);
    const Deformer<double> deformer(scene.binding);
    const std::size_t pose = 3 * scene.lattice.positions.size();
    std::vector<double> poses(2 * pose), points(2 * 900, 7);
    EXPECT_REFUSED(Error,
                   concat("each pose of ", pose / 3, " vertices has ", pose, " numbers; got ",
                          pose + 1, " numbers"),
                   deformer.deform(std::span(poses).first(pose + 1), points));
    EXPECT_REFUSED(Error, "the points of 2 poses are 1800 numbers; there is room for 1799",
                   deformer.deform(poses, std::span(points).first(1799)));
    EXPECT_REFUSED(Error, "the points of 1 pose are 900 numbers; there is room for 1800",
                   deformer.deform(std::span(poses).first(pose), points));
    EXPECT_REFUSED(Error, "a change is of one pose; got 2",
                   deformer.deformChanged(poses, std::vector<Index>{0}, points));
    EXPECT_EQ(points, std::vector<double>(2 * 900, 7));
    bind::Binding other = scene.binding;
    other.rest.pop_back();
    EXPECT_REFUSED(Error, concat(pose / 3, " lattice vertices has ", pose / 3 - 1, " vertices"),
                   Deformer<float>{other});
    EXPECT_THROW(evaluateBinding(other, scene.lattice.positions), Error);
    // No pose is fine, and so is a binding without points or without a lattice.
    deformer.deform({}, {});
    Deformer<double>(bind::Binding()).deform({}, {});
}

// A few points use as many vertices of the level as there are points, so D itself is smaller. Of
// many points in each cell, the factors are.
TEST(Deformer, TakesTheFactorsWhereTheyAreSmaller) {
    const auto bytesOf = [](bind::Binding binding, bool withFactors) {
        if (!withFactors) binding.factors.reset();
        return Deformer<float>(binding).byteCount();
    };
    const Lattice lattice = shapes::cylinder({.sectors = 5});
    for (const std::size_t count : {20, 6000}) {
        const auto points = pointsIn(Refined(lattice, 1), count, 4);
        const auto binding = bind::bindPoints({TopologyRefiner(lattice.complex), lattice.positions},
                                              points, bind::Level{.level = 2, .factors = true});
        const auto with = bytesOf(binding, true), without = bytesOf(binding, false);
        if (count == 20) {
            EXPECT_EQ(with, without);
        } else {
            EXPECT_LT(with, without);
        }
    }
}

}  // namespace
}  // namespace espalier::osd
