// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/cell_place.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/validity.h>

#include <Eigen/LU>
#include <numbers>

#include "poses.h"
#include "solve/validity_pieces.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::solve {
namespace {

const CellComplex& cube() {
    static const CellComplex complex = shapes::box().complex;
    return complex;
}

template <class Change>
Positions changed(Positions positions, Change change) {
    for (Point3& p : positions) p = change(p);
    return positions;
}

Eigen::Vector3d positionOf(const Positions& positions, Index vertex) {
    return vec(positions[vertex]);
}

/// Returns determinants sampled over a cell: for a type-3 cell on a grid of its trilinear map, for
/// a type-n cell in its tetrahedra around the mean of its vertices.
std::vector<double> sampleDeterminants(const CellComplex& complex, Index cell,
                                       const Positions& positions, int parts) {
    std::vector<double> samples;
    if (const auto vertices = far::hexahedronVertices(complex, CellId(cell))) {
        embed::Trilinear::Corners corners;
        for (std::size_t i = 0; i < 8; ++i) corners[i] = positionOf(positions, (*vertices)[i]);
        const embed::Trilinear map(corners);
        for (int i = 0; i <= parts; ++i)
            for (int j = 0; j <= parts; ++j)
                for (int k = 0; k <= parts; ++k)
                    samples.push_back(map.jacobian(Eigen::Vector3d(i, j, k) / parts).determinant());
        return samples;
    }
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    const auto vertices = complex.relation(3, 0)[cell];
    for (const Index vertex : vertices)
        centre += positionOf(positions, vertex) / double(vertices.size());
    for (Index t = 0; t < embed::tetrahedronCount(complex, CellId(cell)); ++t) {
        const auto base = embed::tetrahedronBase(complex, CellId(cell), t);
        Eigen::Matrix3d edges;
        for (Eigen::Index i = 0; i < 3; ++i) edges.col(i) = positionOf(positions, base[i]) - centre;
        samples.push_back(edges.determinant());
    }
    return samples;
}

/// Returns the smallest quotient of samples of a pose and of the rest.
double sampledRatio(const CellComplex& complex, Index cell, const Positions& rest,
                    const Positions& pose, int parts) {
    const auto before = sampleDeterminants(complex, cell, rest, parts);
    const auto now = sampleDeterminants(complex, cell, pose, parts);
    double least = kInfinity;
    for (std::size_t i = 0; i < now.size(); ++i) least = std::min(least, now[i] / before[i]);
    return least;
}

// One vertex is moved along the diagonal: X = x − a uvw (1, 1, 1), with determinant 1 − a (vw + uw
// + uv). It is smallest at that vertex, 1 − 3a. With a = 3t it is 0 at t = 1/9.
TEST(Validity, VertexPulledThroughACube) {
    const Positions rest = shapes::box().positions;
    Positions pose = rest;
    pose[7] = {-2, -2, -2};
    const ValidityCheck validity(cube(), rest);
    EXPECT_THAT(validity.badAtRest(), IsEmpty());
    const PoseValidity folded = validity.check(pose);
    EXPECT_THAT(folded.inverted, ElementsAre(0));
    EXPECT_NEAR(folded.smallest->value, -8, 8e-3);  // Within a thousandth.
    const LargestStep step = validity.largestStep(pose);
    EXPECT_LE(step.length, 1.0 / 9);
    EXPECT_GE(step.length, 1.0 / 9 * (1 - 1.1e-6));
    EXPECT_EQ(step.limitingCell, 0);
    // Half of this step.
    const PoseValidity half = validity.check(moved(rest, pose, 1.0 / 18));
    EXPECT_THAT(half.inverted, IsEmpty());
    EXPECT_NEAR(half.smallest->value, 0.5, 1e-12);  // At a corner: rounding only.
    // A smaller maximum step; then the opposite direction, where the determinant grows.
    EXPECT_EQ(validity.largestStep(pose, 0.1).length, 0.1);
    EXPECT_EQ(validity.largestStep(pose, 0.1).limitingCell, std::nullopt);
    EXPECT_EQ(validity.largestStep(moved(rest, pose, -1), 3).length, 3);
}

TEST(Validity, RatiosAreOneAtRest) {
    for (const auto& [name, lattice] : zoo()) {
        const Refined refined(lattice, 1);
        const ValidityCheck validity(refined.complex(), refined.positions);
        EXPECT_THAT(validity.badAtRest(), IsEmpty()) << name;
        const PoseValidity same = validity.check(refined.positions);
        EXPECT_THAT(same.inverted, IsEmpty()) << name;
        // The floor, relative to a determinant of at least a hundredth of the lengths, is
        // subtracted.
        EXPECT_NEAR(same.smallest->value, 1, 1e-11) << name;
        const LargestStep step = validity.largestStep(refined.positions, 5);
        EXPECT_EQ(step.length, 5) << name;
    }
}

// A cell that was found by trial, in a cube of side 10 with determinant 1000.
TEST(Validity, FoldedInsideOnly) {
    const Positions rest = changed(shapes::box().positions, [](Point3 p) {
        return Point3{10 * p[0], 10 * p[1], 10 * p[2]};
    });
    const Positions pose = {{1, -2, -7}, {8, 5, 6},   {4, 11, 7}, {9, 16, 5},
                            {-6, 7, 4},  {4, -3, 15}, {7, 7, 12}, {14, 5, 10}};
    constexpr int kParts = 10;
    const auto samples = sampleDeterminants(cube(), 0, pose, kParts);
    double onEdges = 1000, inside = 1000;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const std::array<std::size_t, 3> place = {i / 121, i / 11 % 11, i % 11};
        const auto ends =
            std::count_if(place.begin(), place.end(), [](auto at) { return at % 10 == 0; });
        (ends >= 2 ? onEdges : inside) = std::min(ends >= 2 ? onEdges : inside, samples[i]);
    }
    ASSERT_GT(onEdges, 60);
    ASSERT_LT(inside, -30);
    const ValidityCheck validity(cube(), rest);
    const PoseValidity folded = validity.check(pose);
    EXPECT_THAT(folded.inverted, ElementsAre(0));
    EXPECT_LE(folded.smallest->value, inside / 1000);
    // The step ends where the smallest determinant inside is 0.
    const LargestStep step = validity.largestStep(pose);
    EXPECT_EQ(step.limitingCell, 0);
    EXPECT_GT(sampledRatio(cube(), 0, rest, moved(rest, pose, step.length), kParts), 0);
    EXPECT_THAT(validity.check(moved(rest, pose, step.length * (1 + 1e-4))).inverted,
                ElementsAre(0));
}

TEST(Validity, PositiveWithNegativeCoefficients) {
    const Positions rest = changed(shapes::box().positions, [](Point3 p) {
        return Point3{10 * p[0], 10 * p[1], 10 * p[2]};
    });
    const Positions pose = {{4, -1, 3}, {8, -2, -7}, {-4, 12, 7}, {11, 10, 3},
                            {3, 7, 9},  {5, -3, 8},  {7, 16, 13}, {16, 16, 14}};
    double least = 1000;
    for (const auto& lanes : determinant(CellPieces(cube(), 0).hexahedron(pose).derivatives))
        least = std::min(least, lanes[0]);
    ASSERT_LT(least, -290);
    const PoseValidity valid = ValidityCheck(cube(), rest).check(pose);
    EXPECT_THAT(valid.inverted, IsEmpty());
    const double sampled = sampledRatio(cube(), 0, rest, pose, 40);
    EXPECT_LE(valid.smallest->value, sampled);
    // A thousandth, and the error of samples that are 1/80 away from a minimum with curvature of at
    // most 10.
    EXPECT_GE(valid.smallest->value, sampled * (1 - 1e-3) - 3 * 10 / 2.0 / 6400);
    // The same cell at rest is valid.
    const ValidityCheck bent(cube(), pose);
    EXPECT_THAT(bent.badAtRest(), IsEmpty());
    EXPECT_NEAR(bent.check(pose).smallest->value, 1, 1e-3);
}

Positions twistedBy(double angle, const Positions& rest) {
    return changed(rest, [&](Point3 p) {
        const double c = std::cos(angle * p[2]), s = std::sin(angle * p[2]);
        return Point3{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    });
}

// The top is turned by θ around the axis, along straight lines. At height w and time t, the section
// is multiplied by the complex number 1 + w t (e^iθ − 1), so the determinant is its squared
// modulus. It is 0 only for θ = π, first at w = 1, t = 1/2.
TEST(Validity, TwistedColumn) {
    const Positions rest = shapes::box({.min = {-1, -1, 0}, .max = {1, 1, 1}}).positions;
    const ValidityCheck validity(cube(), rest);
    const auto twisted = [&](double angle) { return twistedBy(angle, rest); };
    const LargestStep half = validity.largestStep(twisted(std::numbers::pi));
    EXPECT_LE(half.length, 0.5);
    // (1 − 2t)² is below the floor, 6e-14 · 10², for 2e-6 on either side.
    EXPECT_GE(half.length, 0.5 - 5e-6);
    EXPECT_EQ(half.limitingCell, 0);
    EXPECT_EQ(validity.largestStep(twisted(std::numbers::pi / 2), 2).length, 2);
    // |1 + w (i − 1)|² is 1/2 at w = 1/2, a value inside the cell.
    EXPECT_NEAR(validity.check(twisted(std::numbers::pi / 2)).smallest->value, 0.5, 1e-3);
}

// Near half a turn the smallest determinant is 4 cos²(θ/2), 3e-4 for 179°, all along w t = 1/2. The
// closer it is to 0, the more parts the proof needs. If the bound on work ends the proof, the
// result says so.
TEST(Validity, AlmostHalfATurn) {
    const Positions rest = shapes::box({.min = {-1, -1, 0}, .max = {1, 1, 1}}).positions;
    const ValidityCheck validity(cube(), rest);
    const auto turned = [&](double degrees) {
        return twistedBy(degrees * std::numbers::pi / 180, rest);
    };
    EXPECT_EQ(validity.largestStep(turned(179)).length, 1);
    for (const double degrees : {179.9, 179.99, 179.999}) {
        EXPECT_THAT(validity.check(moved(rest, turned(degrees), 0.5)).inverted, IsEmpty())
            << degrees;
        const LargestStep step = validity.largestStep(turned(degrees));
        EXPECT_GT(step.length, 0.5) << degrees;
        EXPECT_LT(step.length, 1) << degrees;
        EXPECT_EQ(step.limitingCell, 0) << degrees;
        EXPECT_FALSE(step.isTight) << degrees;
    }
    EXPECT_TRUE(validity.largestStep(turned(180)).isTight);
}

// Rounding does not end a step in which nothing moves, or everything shrinks.
TEST(Validity, LongStepsAreProved) {
    const Positions rest = shapes::box().positions;
    const ValidityCheck validity(cube(), rest);
    EXPECT_EQ(validity.largestStep(rest, 1e6).length, 1e6);
    const auto scaled = [&](double factor) {
        return changed(rest, [&](Point3 p) {
            return Point3{factor * p[0], factor * p[1], factor * p[2]};
        });
    };
    for (const double factor : {1e-3, 3e-5, 1e-8}) {
        EXPECT_THAT(validity.check(scaled(factor)).inverted, IsEmpty()) << factor;
        EXPECT_EQ(validity.largestStep(scaled(factor), 1).length, 1) << factor;
    }
    // A million times the distance to collapse. (1 − t)³ is below the floor of about 1e-12 from 1 −
    // 2e-4 on.
    EXPECT_NEAR(validity.largestStep(scaled(0), 1e6).length, 1, 2e-4);
    // Ratios that overflow: the largest double is a lower bound, too.
    const Positions tiny = scaled(1e-80);
    EXPECT_EQ(ValidityCheck(cube(), tiny).check(scaled(1e80)).smallest->value,
              std::numeric_limits<double>::max());
    // The pose turns the lattice inside out, by the same factor.
    const Positions mirrored = changed(rest, [](Point3 p) {
        return Point3{-1e80 * p[0], 1e80 * p[1], 1e80 * p[2]};
    });
    const auto inverted80 = ValidityCheck(cube(), tiny).check(mirrored);
    EXPECT_EQ(inverted80.smallest->value, std::numeric_limits<double>::lowest());
    EXPECT_THAT(inverted80.inverted, ElementsAre(0));
}

TEST(Validity, LeftHandedLatticesAreValid) {
    const Refined refined(shapes::octahedron(), 2);
    const auto mirrored = [](const Positions& positions) {
        return changed(positions, [](Point3 p) { return Point3{p[0], p[1], -p[2]}; });
    };
    const Positions pose = refined.pose(shaken(refined.base, 4, 1));
    const ValidityCheck right(refined.complex(), refined.positions);
    const ValidityCheck left(refined.complex(), mirrored(refined.positions));
    EXPECT_THAT(left.badAtRest(), IsEmpty());
    const auto expected = right.check(pose), got = left.check(mirrored(pose));
    EXPECT_FALSE(expected.inverted.empty());
    EXPECT_EQ(got.inverted, expected.inverted);
    EXPECT_EQ(got.ratios, expected.ratios);
    EXPECT_EQ(left.largestStep(mirrored(pose)).length, right.largestStep(pose).length);
    // Mirroring a pose, however, turns all cells inside out.
    const PoseValidity turned = right.check(mirrored(refined.positions));
    EXPECT_EQ(turned.inverted.size(), turned.ratios.size());
}

// A vertex of a type-4 cell moves across the cell's centre: some tetrahedra turn, others do not.
TEST(Validity, SomeTetrahedraOfATypeFourCell) {
    const Refined refined(shapes::octahedron(), 1);
    Index cell = 0;
    while (far::hexahedronVertices(refined.complex(), CellId(cell))) ++cell;
    const Index vertex = refined.complex().relation(3, 0)[cell].front();
    Positions pose = refined.positions;
    Point3 centre{};
    const auto vertices = refined.complex().relation(3, 0)[cell];
    for (const Index other : vertices)
        for (std::size_t c = 0; c < 3; ++c) centre[c] += pose[other][c] / double(vertices.size());
    const auto samplesOf = [&](Index of, const Positions& positions) {
        return sampleDeterminants(refined.complex(), of, positions, 4);
    };
    const auto before = samplesOf(cell, pose);
    Point3& moving = pose[vertex];
    for (std::size_t c = 0; c < 3; ++c) moving[c] = 1.5 * centre[c] - 0.5 * moving[c];
    const auto now = samplesOf(cell, pose);
    double least = 1;
    std::ptrdiff_t turned = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        least = std::min(least, now[i] / before[i]);
        turned += now[i] * before[i] < 0;
    }
    ASSERT_GT(turned, 0);
    ASSERT_LT(turned, std::ptrdiff_t(now.size()));
    const PoseValidity folded = ValidityCheck(refined.complex(), refined.positions).check(pose);
    EXPECT_THAT(folded.inverted, Contains(cell));
    EXPECT_NEAR(*folded.ratios[cell], least, 1e-12);  // Exact except for rounding.
}

// Compares with samples: no valid cell has a sample that is not positive, and steps end where they
// must.
TEST(Validity, AgreesWithSamples) {
    int invertedCount = 0, limitedCount = 0;
    for (const Lattice& lattice :
         {shapes::box({.cells = {2, 1, 1}}), shapes::cylinder({.sectors = 5}), shapes::octahedron(),
          mixedLattice()})
        for (unsigned seed = 0; seed < 3; ++seed) {
            const Refined refined(lattice, 1);
            const CellComplex& complex = refined.complex();
            const Positions& rest = refined.positions;
            // Move base vertices and, by less, each vertex separately, so that more cells fold.
            const Positions pose =
                shaken(refined.pose(shaken(refined.base, seed, 0.3)), seed + 50, 0.1);
            const ValidityCheck validity(complex, rest);
            ASSERT_THAT(validity.badAtRest(), IsEmpty());
            const PoseValidity checked = validity.check(pose);
            for (Index cell = 0; cell < complex.count(3); ++cell) {
                const double ratio = checked.ratios[cell].value();
                EXPECT_LE(ratio, sampledRatio(complex, cell, rest, pose, 4));
                EXPECT_EQ(ratio > 0, !std::binary_search(checked.inverted.begin(),
                                                         checked.inverted.end(), cell));
                EXPECT_GE(ratio, checked.smallest->value);
            }
            invertedCount += !checked.inverted.empty();

            const LargestStep step = validity.largestStep(pose, 1.5);
            for (const double part : {0.2, 0.6, 0.95, 1.0})
                for (Index cell = 0; cell < complex.count(3); ++cell)
                    EXPECT_GT(
                        sampledRatio(complex, cell, rest, moved(rest, pose, part * step.length), 4),
                        0);
            EXPECT_EQ(step.length < 1.5, step.limitingCell.has_value());
            if (!step.limitingCell) continue;
            ++limitedCount;
            // Slightly beyond the step's precision, a determinant that passes through 0, as all of
            // these do, is negative.
            EXPECT_THAT(validity.check(moved(rest, pose, step.length * (1 + 1e-4))).inverted,
                        Contains(*step.limitingCell));
            EXPECT_THAT(validity.check(moved(rest, pose, step.length)).inverted, IsEmpty());
        }
    EXPECT_GT(invertedCount, 3);
    EXPECT_GT(limitedCount, 5);
}

// A bar of four cells along x, whose last cell is flat, or turned back into its neighbour.
TEST(Validity, CellsBadAtRestAreLeftOut) {
    const Lattice bar = shapes::box({.cells = {4, 1, 1}, .max = {4, 1, 1}});
    const auto withEndAt = [&](double x) {
        return changed(bar.positions, [&](Point3 p) {
            return Point3{p[0] == 4 ? x : p[0], p[1], p[2]};
        });
    };
    for (const double x : {3.0, 2.5}) {
        const Positions rest = withEndAt(x);
        const ValidityCheck validity(bar.complex, rest);
        EXPECT_THAT(validity.badAtRest(), ElementsAre(3)) << x;
        const PoseValidity same = validity.check(rest);
        EXPECT_THAT(same.inverted, IsEmpty());
        EXPECT_EQ(same.ratios[3], std::nullopt);
        EXPECT_EQ(validity.largestStep(rest).length, 1);
        // Even if the pose straightens the last cell, the check has no volume at rest to compare it
        // with.
        EXPECT_THAT(validity.check(bar.positions).inverted, IsEmpty());
    }
    // A thin cell is not flat: here it becomes ten times as thick.
    const ValidityCheck thin(bar.complex, withEndAt(3 + 1e-9));
    EXPECT_THAT(thin.badAtRest(), IsEmpty());
    // 3 + 1e-9 is off by 4e-16, which is 4e-7 of the thickness.
    EXPECT_NEAR(thin.check(withEndAt(3 + 1e-8)).ratios[3].value(), 10, 1e-4);
}

// A cell that is flat within rounding counts as inverted.
TEST(Validity, FlatIsInverted) {
    const Positions rest = shapes::box().positions;
    const auto pressed = [&](double height) {
        return changed(rest, [&](Point3 p) {
            return Point3{p[0] + 0.3 * p[2], p[1], height * p[2] + 0.1 * p[0]};
        });
    };
    const ValidityCheck validity(cube(), rest);
    // The determinant is the height − 0.3 · 0.1.
    EXPECT_THAT(validity.check(pressed(0.03)).inverted, ElementsAre(0));
    EXPECT_THAT(validity.check(pressed(0.03 + 1e-15)).inverted, ElementsAre(0));
    EXPECT_THAT(validity.check(pressed(0.03 + 1e-9)).inverted, IsEmpty());
}

// Cells are pressed into one tilted plane; their deviations from it are rounding.
TEST(Validity, TiltedPlanesAreFlat) {
    const Refined refined(shapes::box({.cells = {2, 2, 2}}), 2);
    const Positions flat = changed(refined.base, [](Point3 p) {
        // The plane of a = (1, 0.3, 0.2) and b = (−0.1, 0.7, 1.1), away from the origin.
        return Point3{3 + p[0] - 0.1 * p[1] + 0.2 * p[2], 1 + 0.3 * p[0] + 0.7 * p[1] - 0.02 * p[2],
                      2 + 0.2 * p[0] + 1.1 * p[1] - 0.14 * p[2]};
    });
    const PoseValidity pressed =
        ValidityCheck(refined.complex(), refined.positions).check(refined.pose(flat));
    EXPECT_EQ(pressed.inverted.size(), pressed.ratios.size());
}

TEST(Validity, DoesNotDependOnThreads) {
    const Refined refined(shapes::cylinder({.sectors = 6, .layers = 6}), 2);
    const Positions pose = refined.pose(shaken(refined.base, 8, 0.5));
    const auto work = [&] {
        const ValidityCheck validity(refined.complex(), refined.positions);
        return std::pair(validity.check(pose), validity.largestStep(pose));
    };
    const auto [one, oneStep] = withThreads(1, work);
    ASSERT_FALSE(one.inverted.empty());
    ASSERT_GT(one.ratios.size(), 1024);  // More than one range.
    for (const int threads : {2, 5}) {
        const auto [other, otherStep] = withThreads(threads, work);
        EXPECT_EQ(other.ratios, one.ratios);
        EXPECT_EQ(other.inverted, one.inverted);
        EXPECT_EQ(otherStep.length, oneStep.length);
        EXPECT_EQ(otherStep.limitingCell, oneStep.limitingCell);
    }
}

// The cubes of these sizes are near the limits of double.
TEST(Validity, IsIndependentOfScale) {
    for (const double size : {1e-80, 1e-6, 1e6, 1e80}) {
        const auto scaled = [&](Positions positions) {
            return changed(std::move(positions), [&](Point3 p) {
                return Point3{size * p[0], size * p[1], size * p[2]};
            });
        };
        Positions pose = shapes::box().positions;
        pose[7] = {-2, -2, -2};
        const ValidityCheck validity(cube(), scaled(shapes::box().positions));
        EXPECT_THAT(validity.badAtRest(), IsEmpty());
        EXPECT_NEAR(validity.largestStep(scaled(pose)).length, 1.0 / 9, 2e-7) << size;
    }
}

TEST(Validity, BaseCellsAreAncestors) {
    const Refined refined(mixedLattice(), 2);
    std::vector<Index> firsts;
    refined.refiner.refinement(1).forEachChild(
        0, 3, [&](Entity, const far::Interval& from) { firsts.push_back(from.upper.index); });
    refined.refiner.refinement(2).forEachChild(0, 3, [&](Entity child, const far::Interval& from) {
        EXPECT_EQ(baseCellOf(refined.refiner, 2, child.index), firsts[from.upper.index]);
    });
    EXPECT_EQ(baseCellOf(refined.refiner, 0, 1), 1);
}

TEST(Validity, RefusesBadInputByName) {
    const Positions rest = shapes::box().positions;
    const ValidityCheck validity(cube(), rest);
    const Positions few(7);
    EXPECT_REFUSED(Error, "got 7 positions of the rest for 8", ValidityCheck(cube(), few));
    EXPECT_REFUSED(Error, "got 7 positions of the pose for 8 vertices", validity.check(few));
    EXPECT_REFUSED(Error, "got 7 positions of the pose", validity.largestStep(few));
    for (const double bad : {kNan, -kInfinity}) {
        Positions broken = rest;
        broken[5][1] = bad;
        EXPECT_REFUSED(Error, "the rest of vertex 5 is not finite", ValidityCheck(cube(), broken));
        EXPECT_REFUSED(Error, "the pose of vertex 5 is not finite", validity.check(broken));
    }
    Positions far = rest;
    far[2][0] = 1e100;
    EXPECT_REFUSED(Error, "the pose of vertex 2 is too far", validity.check(far));
    for (const double most : {0.0, -1.0, 1e7, kNan})
        EXPECT_REFUSED(Error, "expected a number above 0", validity.largestStep(rest, most));
    const Lattice octahedron = shapes::octahedron();
    EXPECT_REFUSED(Error, "is not a quadrilateral",
                   ValidityCheck(octahedron.complex, octahedron.positions));
    EXPECT_REFUSED(Error, "dimension 0", ValidityCheck(CellComplex(), {}));
}

// The planes of a row of three cells are at 0, 1, 2 and 3. With the second at 2.5, the middle cell
// spans −0.5 along the axis, and is inside out among two others.
TEST(CellsBadAtRest, FindFoldsOfAnySize) {
    const Lattice row = shapes::box({.cells = {3, 1, 1}, .max = {3, 1, 1}});
    const far::TopologyRefiner base(row.complex);
    for (const double size : {1e-300, 1.0, 1e200}) {
        const auto at = [&](double second) {
            return changed(row.positions, [&](const Point3& p) {
                return Point3{size * (p[0] == 1 ? second : p[0]), size * p[1], size * p[2]};
            });
        };
        EXPECT_THAT(cellsBadAtRest(base, at(1)), IsEmpty()) << size;
        EXPECT_THAT(cellsBadAtRest(base, at(2.5)), ElementsAre(1)) << size;
        // Refinement gives a flat cell a volume: its planes move to 1.75 and 2.125.
        EXPECT_THAT(cellsBadAtRest(base, at(2)), IsEmpty()) << size;
    }
    // A lattice inside out as a whole is left-handed, not folded.
    EXPECT_THAT(cellsBadAtRest(base, changed(row.positions,
                                             [](const Point3& p) {
                                                 return Point3{-p[0], p[1], p[2]};
                                             })),
                IsEmpty());
}

TEST(CellsBadAtRest, AreNoneWhereRefinementLeavesNoCell) {
    const Lattice thin = shapes::box({.cells = {1, 3, 3}});
    EXPECT_THAT(
        cellsBadAtRest(far::TopologyRefiner(thin.complex, {.boundary = far::Boundary::Open}),
                       thin.positions),
        IsEmpty());
}

// No shape that the program makes has a fold.
TEST(CellsBadAtRest, AreNoneInTheZoo) {
    for (const auto& [name, lattice] : zoo())
        EXPECT_THAT(cellsBadAtRest(far::TopologyRefiner(lattice.complex, {.marks = lattice.marks}),
                                   lattice.positions),
                    IsEmpty())
            << name;
}

}  // namespace
}  // namespace espalier::solve
