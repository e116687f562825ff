// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/embedding.h>
#include <espalier/far/standard_cells.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "support/refined_lattice.h"
#include "support/rows.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

// D = W · S: the deformed points are at their places in the refined pose.
TEST(Embedding, DeformationTableGivesPlacesInTheRefinedPose) {
    for (const auto& [name, lattice] : zoo()) {
        const Refined refined(lattice, 2);
        const auto points = pointsIn(refined, 50, 2);
        const Embedding embedding = refined.embed(points);
        const auto pose = shaken(refined.base, 3, 0.3);
        const auto level = refined.pose(pose);
        const auto direct = times(buildEmbeddingTable(refined.complex(), embedding), level);
        const auto composed = times(refined.table(embedding), pose);
        // Sums of products of size 1 to 4.
        EXPECT_LT(largestDistance(direct, composed), 1e-13) << name;
    }
}

// Every vertex, edge midpoint and face point of the refined lattice is inside the lattice, and in
// the lowest cell that it belongs to.
TEST(Embedding, PointsOnVerticesEdgesAndFacesBelongToTheLowestCell) {
    for (const auto& [name, lattice] : zoo()) {
        const Refined refined(lattice, 1);
        const CellComplex& complex = refined.complex();
        for (int d = 0; d <= 2; ++d) {
            std::vector<Point3> points;
            for (Index i = 0; i < complex.count(d); ++i) {
                std::vector<Index> vertices = {i};
                if (d == 1) vertices = {complex.relation(1, 0)[i][0], complex.relation(1, 0)[i][1]};
                // A face that is not flat is bilinear in a hexahedron, and folded along its cut in
                // a type-n cell: take the middle as the lowest cell has it.
                if (d == 2) {
                    const auto loop = complex.relation(2, 0)[i];
                    const CellId lowest(complex.relation(2, 3)[i].front());
                    vertices = {loop[0], loop[2]};
                    if (far::hexahedronVertices(complex, lowest))
                        vertices.assign(loop.begin(), loop.end());
                }
                Eigen::Vector3d sum = Eigen::Vector3d::Zero();
                for (const Index v : vertices) sum += vec(refined.positions[v]);
                sum /= double(vertices.size());
                points.push_back({sum[0], sum[1], sum[2]});
            }
            const Embedding embedding = refined.embed(points);
            for (Index i = 0; i < complex.count(d); ++i) {
                const LocatedPoint& located = embedding.points[i];
                ASSERT_EQ(located.status, PointStatus::Inside) << name << " " << d << " " << i;
                ASSERT_EQ(located.place->cell.value, complex.relation(d, 3)[i].front())
                    << name << " " << d << " " << i;
            }
        }
    }
}

TEST(Embedding, TrilinearPlacesInACube) {
    const Refined refined(shapes::box(), 1);
    // Eight cells with sides of 1/2: (0.3, 0.2, 0.1) is in the cell at the origin, at 3/5, 2/5 and
    // 1/5 of its sides.
    const Embedding embedding = refined.embed({{0.3, 0.2, 0.1}});
    const CellPlace& place = *embedding.points[0].place;
    const auto corners = *far::hexahedronVertices(refined.complex(), place.cell);
    const Eigen::Vector3d origin = vec(refined.positions[corners[0]]);
    Eigen::Matrix3d axes;
    for (const auto& [column, corner] : {std::pair{0, 1}, {1, 3}, {2, 4}})
        axes.col(column) = vec(refined.positions[corners[corner]]) - origin;
    EXPECT_LT((origin + axes * vec(place.uvw) - Eigen::Vector3d(0.3, 0.2, 0.1)).norm(), 1e-15);
    EXPECT_GT(axes.determinant(), 0) << "right-handed";
    EXPECT_EQ(place.offset, (std::array<double, 3>{}));
}

// Figure 6: 4n tetrahedra around the cell point fill a type-n cell.
TEST(Embedding, TypeNCellIsFilledByFourNTetrahedra) {
    for (const int n : {4, 5, 6}) {
        const Refined refined(shapes::bipyramid({.sides = n}), 1);
        const CellComplex& complex = refined.complex();
        for (Index cell = 0; cell < complex.count(3); ++cell) {
            if (far::hexahedronVertices(complex, CellId(cell))) continue;
            const Index count = tetrahedronCount(complex, CellId(cell));
            const auto vertices = complex.relation(3, 0)[cell];
            EXPECT_EQ(count, 2 * Index(vertices.size()) - 4);  // 4n of 2n + 2
            for (Index t = 0; t < count; ++t) {
                const CellPlace place{CellId(cell), t, {0.2, 0.3, 0.1}, {}};
                Eigen::Vector3d position = Eigen::Vector3d::Zero();
                for (const auto& [vertex, weight] : placeWeights(complex, place))
                    position += weight * vec(refined.positions[vertex]);
                const Embedding found = refined.embed({{position[0], position[1], position[2]}});
                ASSERT_TRUE(found.points[0].place);
                EXPECT_EQ(found.points[0].place->cell.value, cell);
                EXPECT_EQ(found.points[0].place->tetrahedron, t);
                EXPECT_LT((vec(found.points[0].place->uvw) - vec(place.uvw)).norm(), 1e-14);
            }
        }
    }
}

TEST(Embedding, PointsOutside) {
    const Refined refined(shapes::box(), 2);
    const std::vector<Point3> points = {
        {2, 0.5, 0.5}, {0.5, 0.5, 0.5}, {1 + 1e-7, 0.5, 0.5}, {1 + 1e-5, 0.5, 0.5}};
    // Keep: no place, and an empty row.
    const Embedding kept = refined.embed(points);
    const auto statusOf = [&](const Embedding& e, std::size_t i) { return e.points[i].status; };
    EXPECT_EQ(statusOf(kept, 0), PointStatus::Outside);
    EXPECT_EQ(statusOf(kept, 1), PointStatus::Inside);
    EXPECT_EQ(statusOf(kept, 2), PointStatus::Inside) << "within the tolerance of 1e-6 × √3";
    EXPECT_EQ(statusOf(kept, 3), PointStatus::Outside);
    EXPECT_FALSE(kept.points[0].place);
    EXPECT_TRUE(refined.table(kept).columns(0).empty());
    // Nearest: the nearest cell carries the point, at distance 1 from the middle of the side x = 1.
    const Embedding nearest = refined.embed(points, {.outside = OutsidePolicy::Nearest});
    EXPECT_EQ(statusOf(nearest, 0), PointStatus::Outside);
    EXPECT_NEAR(nearest.points[0].distance, 1, 1e-14);
    ASSERT_TRUE(nearest.points[0].place);
    // Error.
    EXPECT_THAT(messageOf([&] { refined.embed(points, {.outside = OutsidePolicy::Error}); }),
                AllOf(HasSubstr("point 0 at (2, 0.5, 0.5) "), HasSubstr("outside the lattice")));
}

/// Returns how far a point is outside a convex lattice with flat sides: its largest distance from
/// the plane of a face, or 0 inside.
double distanceOutside(const Lattice& lattice, const Eigen::Vector3d& point) {
    double farthest = 0;
    for (Index face = 0; face < lattice.complex.count(2); ++face) {
        const auto loop = lattice.complex.relation(2, 0)[face];
        const auto at = [&](std::size_t i) { return vec(lattice.positions[loop[i]]); };
        Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
        if (normal.dot(at(0)) < 0) normal = -normal;
        farthest = std::max(farthest, normal.dot(point - at(0)));
    }
    return farthest;
}

// Refinement does not change single cells around the origin with flat sides, so half-spaces tell
// which points are outside, near cells of types 3, 4, 5 and 6.
TEST(Embedding, HalfSpacesTellWhatIsOutside) {
    for (const Lattice& solid :
         {shapes::cube(), shapes::octahedron(), shapes::icosahedron(), shapes::dodecahedron(),
          shapes::bipyramid({.sides = 6}), shapes::prism({.sides = 5})})
        for (const int level : {1, 2}) {
            const Refined refined(solid, level);
            const auto points = randomPoints(300, 9, 1.3);
            for (const OutsidePolicy policy : {OutsidePolicy::Keep, OutsidePolicy::Nearest}) {
                const Embedding embedding = refined.embed(points, {.outside = policy});
                for (std::size_t i = 0; i < points.size(); ++i) {
                    const double outside = distanceOutside(solid, vec(points[i]));
                    // Within the tolerance, both answers are correct.
                    if (outside > 0 && outside < 1e-5) continue;
                    ASSERT_EQ(embedding.points[i].status,
                              outside > 0 ? PointStatus::Outside : PointStatus::Inside)
                        << outside;
                }
            }
        }
}

// Tests the corners of the region, in cells of type 5: the tolerance is a distance.
TEST(Embedding, ToleranceAppliesAllAroundTheRegion) {
    const Lattice solid = shapes::icosahedron();
    const Refined refined(solid, 1);
    for (const Point3& corner : solid.positions) {
        const Eigen::Vector3d near = vec(corner) * (1 + 5e-7), far = vec(corner) * (1 + 2e-5);
        const Embedding embedding =
            refined.embed({{near[0], near[1], near[2]}, {far[0], far[1], far[2]}});
        EXPECT_EQ(embedding.points[0].status, PointStatus::Inside);
        EXPECT_EQ(embedding.points[1].status, PointStatus::Outside);
    }
}

// Without boundary control, the region is the part of the lattice that remains.
TEST(Embedding, OpenLattice) {
    const Lattice box = shapes::box({.cells = {4, 4, 4}, .max = {4, 4, 4}});
    TopologyRefiner refiner = test::refined(box.complex, 2, {.boundary = Boundary::Open});
    const auto positions = stencils::refinePositions(refiner, 2, box.positions);
    // Level 1 extends from 1/2 to 7/2, and level 2 from 3/4 to 13/4.
    const std::vector<Point3> points = {{0.8, 2, 3.2}, {0.7, 2, 2}, {2, 2, 3.3}};
    const Embedding embedding = embedPoints(refiner.level(2).complex, positions, points);
    EXPECT_EQ(embedding.points[0].status, PointStatus::Inside);
    EXPECT_EQ(embedding.points[1].status, PointStatus::Outside);
    EXPECT_EQ(embedding.points[2].status, PointStatus::Outside);
    const auto table = buildDeformationTable(refiner, 2, embedding);
    EXPECT_LT((times(table, box.positions).row(0).transpose() - vec(points[0])).norm(), 4e-12);
}

// Points of a curved boundary, rounded to single precision as in files of floats, are inside, and D
// reproduces them within that precision.
TEST(Embedding, BoundaryPointsInSinglePrecisionAreInside) {
    for (const Lattice& lattice :
         {shapes::torus(), shapes::cylinder({.sectors = 5}), shapes::barbell()}) {
        const Refined refined(lattice, 2);
        std::vector<Point3> points;
        for (Index v = 0; v < refined.complex().count(0); ++v) {
            if (refined.refiner.level(2).strata.of({0, v}) == 3) continue;
            Point3 p = refined.positions[v];
            for (double& x : p) x = double(float(x));
            points.push_back(p);
        }
        const Embedding embedding = refined.embed(points);
        EXPECT_EQ(embedding.count(PointStatus::Inside), Index(points.size()));
        const auto table = refined.table(embedding);
        EXPECT_LT(largestDistance(times(table, refined.base), asMatrix(points)), 4e-12);
    }
}

TEST(Embedding, NearestCellMatchesBruteForce) {
    const Refined refined(shapes::cylinder({.sectors = 5, .layers = 2}), 1);
    const CellComplex& complex = refined.complex();
    for (const Point3& point : randomPoints(60, 4, 3)) {
        const Embedding found = refined.embed({point}, {.outside = OutsidePolicy::Nearest});
        if (found.points[0].status == PointStatus::Inside) continue;
        // The lattice is convex up to rounding, so the distance to a fine sample of its boundary is
        // hardly smaller and not much larger.
        double sampled = 1e9;
        for (Index face = 0; face < complex.count(2); ++face) {
            if (complex.relation(2, 3)[face].size() != 1) continue;
            const auto loop = complex.relation(2, 0)[face];
            for (int a = 0; a <= 20; ++a)
                for (int b = 0; b <= 20; ++b) {
                    const double u = a / 20., v = b / 20.;
                    const auto at = [&](std::size_t k) { return vec(refined.positions[loop[k]]); };
                    const Eigen::Vector3d q = (1 - u) * (1 - v) * at(0) + u * (1 - v) * at(1) +
                                              u * v * at(2) + (1 - u) * v * at(3);
                    sampled = std::min(sampled, (q - vec(point)).norm());
                }
        }
        // A sample is at most half of a fortieth of a face's diagonal, about 0.03, from the nearest
        // point, and the distance grows by less than that.
        EXPECT_NEAR(found.points[0].distance, sampled, 0.02);
    }
}

// Where a bilinear face of a hexahedron meets the folded face of a type-n cell, there is a gap.
// Points in the gap are inside, and D reproduces them.
TEST(Embedding, PointsInGapsAreInside) {
    const Refined refined(mixedLattice(), 1);
    const CellComplex& complex = refined.complex();
    std::vector<Point3> points;
    for (Index face = 0; face < complex.count(2); ++face) {
        const auto cells = complex.relation(2, 3)[face];
        if (cells.size() != 2) continue;
        const bool first = far::hexahedronVertices(complex, CellId(cells[0])).has_value();
        const bool second = far::hexahedronVertices(complex, CellId(cells[1])).has_value();
        if (first == second) continue;
        // Take the point halfway between the bilinear centre and the middle of the cut.
        const auto loop = complex.relation(2, 0)[face];
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        for (const Index v : loop) centre += vec(refined.positions[v]) / 4;
        const Eigen::Vector3d cut =
            (vec(refined.positions[loop[0]]) + vec(refined.positions[loop[2]])) / 2;
        const Eigen::Vector3d between = (centre + cut) / 2;
        points.push_back({between[0], between[1], between[2]});
    }
    ASSERT_GE(points.size(), 4u);
    const Embedding embedding = refined.embed(points);
    Index inGap = 0;
    for (const LocatedPoint& located : embedding.points) {
        EXPECT_EQ(located.status, PointStatus::Inside);
        inGap += located.distance > 1e-6;
    }
    EXPECT_GT(inGap, 0) << "the test is about gaps, so there must be one";
    const auto table = refined.table(embedding);
    EXPECT_LT(largestDistance(times(table, refined.base), asMatrix(points)), 1e-13);
}

TEST(Embedding, DoesNotDependOnTheNumberOfThreads) {
    const Refined refined(shapes::torus(), 2);
    const auto points = pointsIn(refined, 5000, 7);
    const auto bind = [&](int threads) {
        return withThreads(threads, [&] { return refined.table(refined.embed(points)); });
    };
    const auto one = bind(1);
    EXPECT_EQ(one, bind(2));
    EXPECT_EQ(one, bind(8));
}

// Points are located in an internal order; the results, and the point that an error names, do not
// depend on it.
TEST(Embedding, DoesNotDependOnTheOrderOfThePoints) {
    const Refined refined(shapes::torus(), 2);
    auto points = pointsIn(refined, 5000, 8);
    const Embedding embedding = refined.embed(points);
    const auto forwards = buildEmbeddingTable(refined.complex(), embedding);
    std::reverse(points.begin(), points.end());
    const auto backwards = buildEmbeddingTable(refined.complex(), refined.embed(points));
    const Index last = forwards.rowCount() - 1;
    for (Index row = 0; row <= last; ++row) {
        ASSERT_TRUE(std::ranges::equal(forwards.columns(row), backwards.columns(last - row)));
        ASSERT_TRUE(std::ranges::equal(forwards.weights(row), backwards.weights(last - row)));
    }
    points[3000] = {9, 9, 9};
    points[4000] = {-9, -9, -9};
    EXPECT_REFUSED(Error, "point 3000 at (9, 9, 9) ",
                   refined.embed(points, {.outside = OutsidePolicy::Error}));
}

// A few points in many cells take a separate code path, with the same rows.
TEST(Embedding, RowsDoNotDependOnTheNumberOfPoints) {
    const Refined refined(mixedLattice(), 2);
    const auto points = pointsIn(refined, 2000, 9);
    const auto all = buildEmbeddingTable(refined.complex(), refined.embed(points));
    for (std::size_t i = 0; i < points.size(); i += 50) {
        const auto one = buildEmbeddingTable(refined.complex(), refined.embed({points[i]}));
        ASSERT_TRUE(std::ranges::equal(all.columns(Index(i)), one.columns(0)));
        ASSERT_TRUE(std::ranges::equal(all.weights(Index(i)), one.weights(0)));
    }
}

// Tests W against its definition: the sums of the weights of a place.
TEST(Embedding, RowsAreTheWeightsOfThePlaces) {
    for (const auto& [name, lattice] : zoo()) {
        const Refined refined(lattice, 1);
        auto points = pointsIn(refined, 100, 10);
        points.push_back({3.5, 0.3, 0.2});
        const Embedding embedding = refined.embed(points, {.outside = OutsidePolicy::Nearest});
        const auto table = buildEmbeddingTable(refined.complex(), embedding);
        for (std::size_t i = 0; i < points.size(); ++i) {
            std::map<Index, double> expected;
            for (const auto& [vertex, weight] :
                 placeWeights(refined.complex(), *embedding.points[i].place))
                expected[vertex] += weight;
            std::erase_if(expected, [](const auto& entry) { return entry.second == 0; });
            ASSERT_EQ(rowOf(table, Index(i)).weights, expected) << name << " " << i;
        }
    }
}

TEST(Embedding, PointsThatAreNotFiniteDoNotConverge) {
    const Refined refined(shapes::box(), 1);
    const Embedding embedding =
        refined.embed({{kNan, 0, 0}, {0.5, kInfinity, 0.5}}, {.outside = OutsidePolicy::Nearest});
    EXPECT_EQ(embedding.count(PointStatus::NotConverged), 2);
}

// A flattened lattice has no volume. A point on it may get a place, but a point beside it cannot be
// carried.
TEST(Embedding, FlatLatticeGivesAStatus) {
    Lattice flat = shapes::box();
    for (Point3& p : flat.positions) p[2] = 0;
    const Refined refined(flat, 1);
    const Embedding embedding =
        refined.embed({{0.5, 0.5, 1}, {0.3, 0.6, 0}}, {.outside = OutsidePolicy::Nearest});
    EXPECT_EQ(embedding.points[0].status, PointStatus::Outside);
    EXPECT_FALSE(embedding.points[0].place);
    if (embedding.points[1].place) {
        EXPECT_LT(embedding.points[1].residual, 1e-14);
    }
}

// An almost flat lattice: a place for a point beside it would need weights of several millions,
// which would move the point wildly in any other pose. Within the tolerance, the point gets the
// nearest place.
TEST(Embedding, ThinLatticesKeepWeightsSmall) {
    Lattice thin = shapes::box();
    for (Point3& p : thin.positions) p[2] *= 1e-14;
    const Refined refined(thin, 1);
    const auto located = refined.embed({{0.1, 0.2, 1e-7}}).points.front();
    ASSERT_EQ(located.status, PointStatus::Inside);
    EXPECT_EQ(located.place->offset, (std::array<double, 3>{}));
    EXPECT_NEAR(located.residual, 1e-7, 1e-13);
}

TEST(Embedding, NeedsARefinedLattice) {
    const Lattice box = shapes::bipyramid({.sides = 5});
    const auto embedAtBase = [&] {
        embedPoints(box.complex, box.positions, std::vector<Point3>{{0, 0, 0}});
    };
    EXPECT_THROW(embedAtBase(), Error);
    const Refined refined(box, 1);
    EXPECT_THROW(embedPoints(refined.complex(), box.positions, std::vector<Point3>{}), Error);
    auto broken = refined.positions;
    broken[3][1] = kNan;
    EXPECT_THROW(embedPoints(refined.complex(), broken, std::vector<Point3>{}), Error);
    for (const double tolerance : {-1e-6, kNan, kInfinity})
        EXPECT_THROW(refined.embed({}, {.tolerance = tolerance}), Error) << tolerance;
    // An embedding belongs to a single level.
    TopologyRefiner finer = refined.refiner;
    finer.refineUniform(2);
    EXPECT_THROW(buildDeformationTable(finer, 2, refined.embed({{0, 0, 0}})), Error);
}

// One vertex far away folds the cells: each point is reproduced, or its status says that it is not.
TEST(Embedding, StatusIsCorrectInATangledLattice) {
    for (const double away : {3.0, 1e6}) {
        Lattice tangled = shapes::box({.cells = {2, 2, 2}});
        tangled.positions[13] = {away, -away, away};
        const Refined refined(tangled, 1);
        const auto points = pointsIn(Refined(shapes::box({.cells = {2, 2, 2}}), 1), 8, 12);
        const Embedding embedding = refined.embed(points, {.outside = OutsidePolicy::Nearest});
        const auto table = refined.table(embedding);
        const auto back = times(table, refined.base);
        for (std::size_t i = 0; i < points.size(); ++i)
            // 1e-12 of the lattice's size, plus the tolerance if a point got the nearest place.
            if (embedding.points[i].place) {
                ASSERT_LE((back.row(Eigen::Index(i)).transpose() - vec(points[i])).norm(),
                          2e-6 * (1 + away));
            }
    }
}

}  // namespace
}  // namespace espalier::embed
