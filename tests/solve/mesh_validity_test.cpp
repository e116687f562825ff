// SPDX-License-Identifier: Apache-2.0
// The checks of volume meshes: ValidityCheck(VolumeMesh, …).
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/solids.h>
#include <espalier/solve/validity.h>

#include <Eigen/Core>
#include <Eigen/LU>

#include "poses.h"
#include "solve/mesh_centres.h"
#include "support/complexes.h"
#include "support/skew_boxes.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/volume_meshes.h"

namespace espalier::solve {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using far::StandardCell;
using far::VolumeMesh;

constexpr StandardCell kKinds[] = {StandardCell::Tetrahedron, StandardCell::Pyramid,
                                   StandardCell::Wedge, StandardCell::Hexahedron};

Vector3d at(const Positions& positions, Index point) {
    return Vector3d(positions[point].data());
}

/// Returns the corners of a standard cell of size 1, in VTK's order.
Positions unitCell(StandardCell kind) {
    switch (kind) {
        case StandardCell::Tetrahedron:
            return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        case StandardCell::Pyramid:
            return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};
        case StandardCell::Wedge:
            return {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
        case StandardCell::Hexahedron:
            break;
    }
    return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
}

VolumeMesh singleCellMesh(StandardCell kind) {
    far::VolumeMeshBuilder builder(far::vertexCount(kind));
    std::vector<Index> corners(far::vertexCount(kind));
    std::iota(corners.begin(), corners.end(), 0);
    builder.addCell(kind, corners);
    return builder.build();
}

/// The shape functions of the cells, as textbooks write them: the weight of each corner at (u, v,
/// w).
std::vector<double> shapeFunctions(StandardCell kind, const Vector3d& place) {
    const double u = place[0], v = place[1], w = place[2];
    switch (kind) {
        case StandardCell::Tetrahedron:
            return {1 - u - v - w, u, v, w};
        case StandardCell::Pyramid:  // The base shrinks to the apex.
            return {(1 - u) * (1 - v) * (1 - w), u * (1 - v) * (1 - w), u * v * (1 - w),
                    (1 - u) * v * (1 - w), w};
        case StandardCell::Wedge:  // Corners 1 and 2 are the ends of v and u.
            return {(1 - u - v) * (1 - w), v * (1 - w), u * (1 - w), (1 - u - v) * w, v * w, u * w};
        case StandardCell::Hexahedron:
            break;
    }
    return {
        (1 - u) * (1 - v) * (1 - w), u * (1 - v) * (1 - w), u * v * (1 - w), (1 - u) * v * (1 - w),
        (1 - u) * (1 - v) * w,       u * (1 - v) * w,       u * v * w,       (1 - u) * v * w};
}

/// Returns the determinant of the Jacobian by central differences, which are exact for polynomials
/// of degree 2 in each variable. For a pyramid it is divided by (1 − w)², its factor.
double determinantAt(StandardCell kind, const Positions& corners, const Vector3d& place) {
    const auto map = [&](const Vector3d& uvw) {
        Vector3d sum = Vector3d::Zero();
        const auto weights = shapeFunctions(kind, uvw);
        for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * at(corners, Index(i));
        return sum;
    };
    constexpr double kStep = 0.5;
    Matrix3d jacobian;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        jacobian.col(axis) = (map(place + kStep * Vector3d::Unit(axis)) -
                              map(place - kStep * Vector3d::Unit(axis))) /
                             (2 * kStep);
    const double shrunk = kind == StandardCell::Pyramid ? (1 - place[2]) * (1 - place[2]) : 1;
    return jacobian.determinant() / shrunk;
}

/// Returns the smallest determinant on a grid over the cell.
double sampledDeterminant(StandardCell kind, const Positions& corners, int parts) {
    double least = kInfinity;
    const bool isTriangle = kind == StandardCell::Wedge || kind == StandardCell::Tetrahedron;
    for (int i = 0; i <= parts; ++i)
        for (int j = 0; j <= (isTriangle ? parts - i : parts); ++j)
            for (int k = 0; k < parts + (kind == StandardCell::Pyramid ? 0 : 1); ++k) {
                if (kind == StandardCell::Tetrahedron && i + j + k > parts) continue;
                least = std::min(least,
                                 determinantAt(kind, corners, Vector3d(i, j, k) / double(parts)));
            }
    return least;
}

// The reference samples the determinants of the textbook maps on a grid. Samples miss the smallest
// value by less than the square of their distance times a second derivative below 100, so cells are
// only compared with it if it is outside ±100 / 12² / 8.
TEST(MeshValidity, AgreesWithSampledDeterminants) {
    constexpr int kParts = 12;
    constexpr double kMiss = 100.0 / kParts / kParts / 8;
    for (const StandardCell kind : kKinds) {
        const Positions rest = unitCell(kind);
        const ValidityCheck validity(singleCellMesh(kind), rest);
        EXPECT_THAT(validity.badAtRest(), IsEmpty());
        int valid = 0, inverted = 0;
        for (unsigned seed = 0; seed < 60; ++seed) {
            const Positions pose = shaken(rest, seed, 0.25 + 0.02 * seed);
            const double least = sampledDeterminant(kind, pose, kParts);
            const bool isInverted = !validity.check(pose).inverted.empty();
            if (least <= 0 || least > kMiss) {
                EXPECT_EQ(isInverted, least <= 0) << int(kind) << " " << seed;
            }
            (isInverted ? inverted : valid)++;
            // The step ends where the smallest determinant becomes 0.
            const LargestStep step = validity.largestStep(pose);
            if (isInverted) {
                EXPECT_LT(step.length, 1);
            }
            EXPECT_GT(sampledDeterminant(kind, moved(rest, pose, step.length), kParts), 0);
            if (step.length == 1) continue;
            EXPECT_EQ(step.limitingCell, 0);
            EXPECT_THAT(validity.check(moved(rest, pose, step.length * (1 + 3e-6))).inverted,
                        ElementsAre(0));
        }
        EXPECT_GT(valid, 10) << int(kind);
        EXPECT_GT(inverted, 10) << int(kind);
    }
}

// The theorems of MeshPieces: without the factor (1 − w)², the determinant of a pyramid is bilinear
// in (u, v); that of a wedge is linear over the triangle.
TEST(MeshValidity, DeterminantsOfPyramidsAndWedgesAreSmallestAtCornersAndEdges) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Positions pyramid = shaken(unitCell(StandardCell::Pyramid), seed, 0.5);
        const Positions wedge = shaken(unitCell(StandardCell::Wedge), seed, 0.5);
        const auto values = randomValues(3, seed);
        const double u = (1 + values[0]) / 2, v = (1 + values[1]) / 2, w = (1 + values[2]) / 4;
        const auto ofPyramid = [&](double a, double b) {
            return determinantAt(StandardCell::Pyramid, pyramid, {a, b, w});
        };
        EXPECT_NEAR(ofPyramid(u, v),
                    (1 - u) * (1 - v) * ofPyramid(0, 0) + u * (1 - v) * ofPyramid(1, 0) +
                        (1 - u) * v * ofPyramid(0, 1) + u * v * ofPyramid(1, 1),
                    1e-12);  // Rounding.
        const auto ofWedge = [&](double a, double b) {
            return determinantAt(StandardCell::Wedge, wedge, {a, b, w});
        };
        EXPECT_NEAR(ofWedge(u, v),
                    (1 - u - v) * ofWedge(0, 0) + u * ofWedge(1, 0) + v * ofWedge(0, 1), 1e-12);
    }
}

// The tip of a tetrahedron with corners (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1) moves to
// (0, 0, −2): its determinant is 1 − 3t. Then all edges shrink to a third and turn by half a turn
// about z: (1 − 4t/3)² (1 − 2t/3), with the double root 3/4, which the determinant only touches.
TEST(MeshValidity, StepsOfTetrahedraAreRootsOfCubics) {
    const Positions rest = unitCell(StandardCell::Tetrahedron);
    const ValidityCheck validity(singleCellMesh(StandardCell::Tetrahedron), rest);
    Positions pose = rest;
    pose[3] = {0, 0, -2};
    // The floor, 1e-13 of the lengths, ends the step before the root.
    EXPECT_NEAR(validity.largestStep(pose).length, 1.0 / 3, 1e-12);
    EXPECT_LE(validity.largestStep(pose).length, 1.0 / 3);
    EXPECT_NEAR(validity.check(pose).smallest->value, -2, 1e-11);
    pose = {{0, 0, 0}, {-1.0 / 3, 0, 0}, {0, -1.0 / 3, 0}, {0, 0, 1.0 / 3}};
    const LargestStep touching = validity.largestStep(pose);
    EXPECT_EQ(touching.limitingCell, 0);
    EXPECT_LT(touching.length, 0.75);
    EXPECT_NEAR(touching.length, 0.75, 1e-6);  // The root of the floor: 3/4 − √1e-13.
    EXPECT_THAT(validity.check(pose).inverted, IsEmpty());
}

// A corner of a cube goes through the opposite faces: at the corner the determinant is 1 − 9t (see
// Validity.VertexPulledThroughACube). Steps that a corner ends are roots of its cubic.
TEST(MeshValidity, StepsThatACornerOfAHexahedronEndsAreRootsOfCubics) {
    const Positions rest = unitCell(StandardCell::Hexahedron);
    Positions pose = rest;
    pose[6] = {-2, -2, -2};
    const ValidityCheck validity(singleCellMesh(StandardCell::Hexahedron), rest);
    EXPECT_NEAR(validity.largestStep(pose).length, 1.0 / 9, 1e-12);
    EXPECT_LE(validity.largestStep(pose).length, 1.0 / 9);
}

/// The decomposition of a polyhedron at rest, and its determinants in a pose, by definition: each
/// centre moves as the same mean of points.
///
/// \returns the smallest quotient of determinants
double polyhedronRatio(const VolumeMesh& mesh, Index cell, const Positions& rest,
                       const Positions& pose) {
    std::map<Index, std::vector<double>> weights;
    std::vector<Point3> centres(mesh.faceCount()), areas(mesh.faceCount());
    for (Index face = 0; face < mesh.faceCount(); ++face) {
        const FaceCentre centre = faceCentre(mesh.face(face), rest, &weights[face]);
        centres[face] = centre.centre;
        areas[face] = centre.area;
    }
    std::vector<double> ofFaces;
    cellCentre(mesh, cell, centres, areas, &ofFaces);
    double least = kInfinity;
    const auto faceMean = [&](Index face, const Positions& positions) {
        Vector3d sum = Vector3d::Zero();
        for (std::size_t i = 0; i < mesh.face(face).size(); ++i)
            sum += weights[face][i] * at(positions, mesh.face(face)[i]);
        return sum;
    };
    const auto cellMean = [&](const Positions& positions) {
        Vector3d sum = Vector3d::Zero();
        for (std::size_t i = 0; i < ofFaces.size(); ++i)
            sum += ofFaces[i] * faceMean(mesh.faces(cell)[i], positions);
        return sum;
    };
    for (const Index face : mesh.faces(cell)) {
        const auto loop = mesh.face(face);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const auto determinant = [&](const Positions& positions) {
                const Vector3d apex = cellMean(positions);
                Matrix3d edges;
                edges << faceMean(face, positions) - apex, at(positions, loop[i]) - apex,
                    at(positions, loop[(i + 1) % loop.size()]) - apex;
                return edges.determinant();
            };
            least = std::min(least, determinant(pose) / determinant(rest));
        }
    }
    return least;
}

TEST(MeshValidity, PolyhedraAreSplitIntoTetrahedra) {
    const Lattice lattice = shapes::dodecahedron();
    const VolumeMesh mesh = volumeMeshOf(lattice.complex);
    const ValidityCheck validity(mesh, lattice.positions);
    EXPECT_THAT(validity.badAtRest(), IsEmpty());
    int inverted = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        const Positions pose = shaken(lattice.positions, seed, 0.02 * seed);
        const double ratio = polyhedronRatio(mesh, 0, lattice.positions, pose);
        const PoseValidity found = validity.check(pose);
        // The floor, 1e-13, is relative to lengths: the tetrahedra have a tenth of their product.
        EXPECT_NEAR(found.smallest->value, ratio, 1e-11);
        EXPECT_EQ(found.inverted.empty(), ratio > 0);
        inverted += ratio > 0 ? 0 : 1;
        const LargestStep step = validity.largestStep(pose);
        EXPECT_EQ(step.length == 1, ratio > 0);
        if (ratio > 0) continue;
        const auto ratioAfter = [&](double t) {
            return polyhedronRatio(mesh, 0, lattice.positions, moved(lattice.positions, pose, t));
        };
        EXPECT_GT(ratioAfter(step.length), 0);
        EXPECT_LT(ratioAfter(step.length * (1 + 1e-9)), 0);
    }
    EXPECT_GT(inverted, 10);
    EXPECT_LT(inverted, 35);
}

// Maps are reproduced by affine maps, so all ratios are their determinant.
TEST(MeshValidity, RatiosOfAffinePosesAreTheDeterminant) {
    const Skew skew;
    const double determinant = skew.axes.determinant();
    std::vector<Lattice> lattices = {shapes::dodecahedron(), shapes::cylinder({.sectors = 5}),
                                     shapes::pyramid({.sides = 4})};
    lattices.push_back(shapes::box({.cells = {2, 2, 1}}));
    for (const Lattice& lattice : lattices) {
        for (const bool arePolyhedra : {false, true}) {
            const VolumeMesh mesh = volumeMeshOf(lattice.complex, arePolyhedra);
            const ValidityCheck validity(mesh, lattice.positions);
            EXPECT_THAT(validity.badAtRest(), IsEmpty());
            const PoseValidity posed = validity.check(skew(lattice.positions));
            for (const auto& ratio : posed.ratios) EXPECT_NEAR(*ratio, determinant, 1e-9);
            EXPECT_THAT(posed.inverted, IsEmpty());
            EXPECT_EQ(validity.largestStep(skew(lattice.positions)).length, 1);
        }
    }
}

// Programs order the points of a wedge in two ways, and some meshes are mirror images.
TEST(MeshValidity, TheOrientationOfMostCellsOfAKindIsRight) {
    const Lattice box = shapes::box({.cells = {3, 1, 1}});
    Positions mirrored = box.positions;
    for (Point3& p : mirrored) p[0] = -p[0];
    const VolumeMesh mesh = volumeMeshOf(box.complex);
    const ValidityCheck validity(mesh, mirrored);
    EXPECT_THAT(validity.badAtRest(), IsEmpty());
    EXPECT_NEAR(validity.check(mirrored).smallest->value, 1, 1e-11);
    EXPECT_THAT(validity.check(box.positions).inverted, SizeIs(3));

    // Of three wedges one is inside out; the hexahedron does not count for them.
    far::VolumeMeshBuilder builder(8 + 18);
    Positions positions = unitCell(StandardCell::Hexahedron);
    builder.addCell(StandardCell::Hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
    for (Index i = 0; i < 3; ++i) {
        const Index first = Index(positions.size());
        for (const Point3& p : unitCell(StandardCell::Wedge)) positions.push_back(p);
        std::vector<Index> corners = {first, first + 2, first + 1, first + 3, first + 5, first + 4};
        if (i == 1) std::swap(corners[0], corners[3]);
        if (i == 1) std::swap(corners[1], corners[4]);
        if (i == 1) std::swap(corners[2], corners[5]);
        builder.addCell(StandardCell::Wedge, corners);
    }
    const ValidityCheck wedges(builder.build(), positions);
    EXPECT_THAT(wedges.badAtRest(), ElementsAre(2));
    EXPECT_EQ(wedges.check(positions).ratios[2], std::nullopt);
}

TEST(MeshValidity, DoesNotDependOnThreadsAndOnTheCellsBeside) {
    const Lattice box = shapes::box({.cells = {12, 12, 12}});
    const VolumeMesh mesh = volumeMeshOf(box.complex);
    const Positions pose = shaken(box.positions, 1, 0.06);
    const auto run = [&] {
        const ValidityCheck validity(mesh, box.positions);
        return std::tuple(validity.check(pose), validity.largestStep(pose));
    };
    const auto [all, step] = withThreads(1, run);
    const auto [again, stepAgain] = withThreads(4, run);
    EXPECT_EQ(all.inverted, again.inverted);
    EXPECT_EQ(all.ratios, again.ratios);
    EXPECT_EQ(step.length, stepAgain.length);
    ASSERT_TRUE(step.limitingCell);
    EXPECT_EQ(step.limitingCell, stepAgain.limitingCell);
    // The limiting cell alone has the same step and ratio.
    far::VolumeMeshBuilder builder(mesh.pointCount());
    builder.addCell(StandardCell::Hexahedron, mesh.corners(*step.limitingCell));
    const ValidityCheck single(builder.build(), box.positions);
    EXPECT_NEAR(single.largestStep(pose).length, step.length, 1e-11);
    EXPECT_EQ(single.check(pose).ratios[0], all.ratios[*step.limitingCell]);
}

// A mesh that is thin, as at a wall, and far from the origin. The floor is relative to the edges.
TEST(MeshValidity, ThinCellsAreChecked) {
    const Lattice box = shapes::box({.cells = {2, 2, 2}});
    Positions rest = box.positions;
    for (Point3& p : rest) p = {100 + p[0], p[1], 1e-7 * p[2]};
    const ValidityCheck validity(volumeMeshOf(box.complex), rest);
    EXPECT_THAT(validity.badAtRest(), IsEmpty());
    Positions pose = rest;
    for (Point3& p : pose) p[2] *= p[0] > 100.6 ? -1.0 : 1.0;
    EXPECT_THAT(validity.check(pose).inverted, SizeIs(4));
    // Rounding of coordinates of 100, 2e-14, is 3e-7 of the height of a cell; the floor allows for
    // it with factors of 2 √3 and 2.
    EXPECT_NEAR(validity.largestStep(pose).length, 0.5, 1e-5);
    EXPECT_LT(validity.largestStep(pose).length, 0.5);
}

TEST(MeshValidity, RefusesPositionsThatDoNotFit) {
    const VolumeMesh mesh = singleCellMesh(StandardCell::Tetrahedron);
    Positions rest = unitCell(StandardCell::Tetrahedron);
    const ValidityCheck validity(mesh, rest);
    rest[2][1] = kNan;
    EXPECT_REFUSED(Error, "the rest of vertex 2 is not finite", ValidityCheck(mesh, rest));
    EXPECT_REFUSED(Error, "the pose of vertex 2 is not finite", validity.check(rest));
    rest.pop_back();
    EXPECT_REFUSED(Error, "got 3 positions of the rest for 4 vertices", ValidityCheck(mesh, rest));
    EXPECT_REFUSED(Error, "got 3 positions of the pose", validity.largestStep(rest));
    EXPECT_THAT(ValidityCheck(VolumeMesh(), {}).badAtRest(), IsEmpty());
}

}  // namespace
}  // namespace espalier::solve
