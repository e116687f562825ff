// SPDX-License-Identifier: Apache-2.0
// Values derived by hand; tests/hosts compares with checkMesh itself.
#include <espalier/base/vector3.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/solids.h>
#include <espalier/solve/mesh_quality.h>

#include <numbers>

#include "poses.h"
#include "solve/mesh_centres.h"
#include "solve/validity_pieces.h"
#include "support/complexes.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/volume_meshes.h"

namespace espalier::solve {
namespace {

using far::StandardCell;
using std::numbers::pi;

double jacobianOf(StandardCell kind, const Positions& corners) {
    std::vector<Index> numbers(corners.size());
    std::iota(numbers.begin(), numbers.end(), 0);
    return scaledJacobian(kind, numbers, corners);
}

TEST(MeshQuality, ACubeIsPerfect) {
    const Lattice box = shapes::box({.cells = {3, 2, 2}, .max = {6, 4, 4}});
    for (const bool arePolyhedra : {false, true}) {
        const MeshQuality quality =
            meshQuality(volumeMeshOf(box.complex, arePolyhedra), box.positions);
        EXPECT_EQ(quality.smallestScaledJacobian.has_value(), !arePolyhedra);
        EXPECT_EQ(quality.smallestScaledJacobian.value_or(CellValue{0, 1}).value, 1);
        EXPECT_NEAR(quality.smallestVolume->value, 8, 1e-14);
        EXPECT_NEAR(quality.largestNonOrthogonality->value, 0, 1e-6);  // acos(1 − ε) is √(2ε).
        EXPECT_NEAR(quality.meanNonOrthogonality, 0, 1e-6);
        EXPECT_NEAR(quality.largestSkewness->value, 0, 1e-14);
        EXPECT_TRUE(quality.nonPositiveVolumes.empty());
        EXPECT_EQ(quality.negativePyramids, 0);
        EXPECT_EQ(quality.severelyNonOrthogonal, 0);
    }
}

// Two unit cubes side by side along x, sheared: x goes to x, y to y + s x. The centres are (1, s)
// apart, and the face between them is perpendicular to x: tan φ = s. Its centre is on the line of
// the centres. On the boundary y = 0 the normal is (−s, 1) / √(1 + s²), and the centre of the cell
// is ½ (1, 1 + s); the centre of the face ½ (1, s). They are ½ apart in y, that is s/2 √(1 + s²)⁻¹
// along the face from the normal. The face is √(1 + s²) long: half of it is the size in this
// direction. So the skewness is s / (1 + s²). On x = 0, the normal is x, the centres (½, ½ + s/2)
// and (0, ½), s/2 apart along the face of size ½: s.
TEST(MeshQuality, OfShearedCubes) {
    for (const double s : {0.25, 1.0, 3.0}) {
        const Lattice box = shapes::box({.cells = {2, 1, 1}, .max = {2, 1, 1}});
        Positions sheared = box.positions;
        for (Point3& p : sheared) p[1] += s * p[0];
        const MeshQuality quality = meshQuality(volumeMeshOf(box.complex), sheared);
        EXPECT_NEAR(quality.largestNonOrthogonality->value, std::atan(s) * 180 / pi, 1e-9);
        EXPECT_NEAR(quality.meanNonOrthogonality, std::atan(s) * 180 / pi, 1e-9);
        EXPECT_EQ(quality.severelyNonOrthogonal, s > 2.75 ? 1 : 0);  // tan 70°
        EXPECT_NEAR(quality.largestSkewness->value, s, 1e-12);
        EXPECT_NEAR(quality.smallestVolume->value, 1, 1e-12);
        EXPECT_NEAR(quality.smallestScaledJacobian->value, 1 / std::sqrt(1 + s * s), 1e-12);
    }
}

// Two cubes that meet in the square x = 1. The far end of the second one is moved by s along y, the
// near end stays: its centre is at (1.5, 0.5 + s/2). The line from (0.5, 0.5) passes the face at
// y = 0.5 + s/4, and the face extends by ½ from its centre: skewness s/2. On the ends x = 0 and x =
// 2, and on the sides, it is at most s: on x = 2 the centre of the face is at 0.5 + s.
TEST(MeshQuality, OfABentBar) {
    const double s = 0.6;
    const Lattice box = shapes::box({.cells = {2, 1, 1}, .max = {2, 1, 1}});
    Positions bent = box.positions;
    for (Point3& p : bent) p[1] += p[0] == 2 ? s : 0;
    const far::VolumeMesh mesh = volumeMeshOf(box.complex);
    const MeshQuality quality = meshQuality(mesh, bent);
    EXPECT_NEAR(quality.largestNonOrthogonality->value, std::atan(s / 2) * 180 / pi, 1e-9);
    EXPECT_NEAR(quality.largestSkewness->value, s, 1e-12);  // On x = 2: s/2 over ½.
    EXPECT_GE(quality.largestSkewness->face, mesh.internalFaceCount());
}

/// Returns the face of a boundary whose centre is at a place.
Index faceAt(const far::VolumeMesh& mesh, const Positions& positions, const Point3& place) {
    for (Index face = mesh.internalFaceCount(); face < mesh.faceCount(); ++face)
        if (length(difference(faceCentre(mesh.face(face), positions).centre, place)) < 1e-9)
            return face;
    throw Error("no face there");
}

// The bars above, periodic along x. The face at x = 0 of the sheared one is then as the face at x =
// 1, and so the skewness is that of the sides. The ends of the bent one are s apart: the line from
// the centre of the second cube, (1.5, 0.5 + s/2), goes to (2.5, 0.5 + s), and passes the end x = 2
// at 0.5 + 3/4 s, where its centre is at 0.5 + s: skewness s/2.
TEST(MeshQuality, OfPeriodicPatches) {
    for (const double s : {0.25, 1.0, 3.0}) {
        const Lattice box = shapes::box({.cells = {2, 1, 1}, .max = {2, 1, 1}});
        Positions sheared = box.positions;
        for (Point3& p : sheared) p[1] += s * p[0];
        const far::VolumeMesh mesh = volumeMeshOf(box.complex);
        const Index first = faceAt(mesh, sheared, {0, 0.5, 0.5}),
                    last = faceAt(mesh, sheared, {2, 0.5 + 2 * s, 0.5});
        const CoupledFace coupled[] = {{first, last}, {last, first}};
        const MeshQuality quality = meshQuality(mesh, sheared, coupled);
        EXPECT_NEAR(quality.largestNonOrthogonality->value, std::atan(s) * 180 / pi, 1e-9);
        EXPECT_NEAR(quality.meanNonOrthogonality, std::atan(s) * 180 / pi, 1e-9);
        EXPECT_EQ(quality.severelyNonOrthogonal, s > 2.75 ? 3 : 0);
        EXPECT_NEAR(quality.largestSkewness->value, s / (1 + s * s), 1e-12);

        Positions bent = box.positions;
        for (Point3& p : bent) p[1] += p[0] == 2 ? s : 0;
        const MeshQuality ofBent = meshQuality(mesh, bent, coupled);
        EXPECT_NEAR(ofBent.largestNonOrthogonality->value, std::atan(s / 2) * 180 / pi, 1e-9);
        // The sides of the second cube are sheared as above.
        EXPECT_NEAR(ofBent.largestSkewness->value, std::max(s / 2, s / (1 + s * s)), 1e-12);
        const CoupledFace inside[] = {{0, last}};
        EXPECT_REFUSED(Error, "a coupled face is 0; the faces of the boundary are 1 to 10",
                       meshQuality(mesh, bent, inside));
    }
}

// A quarter of a ring of one cell, with the corners (1, 0), (2, 0), (0, 2) and (0, 1). Its centre
// is at x = y = (2 · 2/3 − ½ · 1/3) / 1.5 = 7/9. The next cell is this one, turned by −90 degrees:
// its centre is below at (7/9, −7/9), straight across the face y = 0, whose centre is at 1.5 and
// which extends by ½. The skewness is (1.5 − 7/9) / ½ = 13/9.
TEST(MeshQuality, OfPatchesThatAreTurned) {
    const Lattice box = shapes::box({.cells = {1, 1, 1}});
    Positions ring = box.positions;
    for (Point3& p : ring) p = p[1] == 0 ? Point3{1 + p[0], 0, p[2]} : Point3{0, 1 + p[0], p[2]};
    const far::VolumeMesh mesh = volumeMeshOf(box.complex);
    const Index first = faceAt(mesh, ring, {1.5, 0, 0.5}), last = faceAt(mesh, ring, {0, 1.5, 0.5});
    const CoupledFace coupled[] = {{first, last, {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}}},
                                   {last, first, {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}}};
    EXPECT_FALSE(meshQuality(mesh, ring).largestNonOrthogonality);
    const MeshQuality quality = meshQuality(mesh, ring, coupled);
    EXPECT_NEAR(quality.largestNonOrthogonality->value, 0, 1e-6);
    EXPECT_NEAR(quality.largestSkewness->value, 13.0 / 9, 1e-12);
}

TEST(MeshQuality, CountsCellsThatAreInsideOut) {
    const Lattice box = shapes::box({.cells = {2, 1, 1}, .max = {2, 1, 1}});
    Positions folded = box.positions;
    for (Point3& p : folded)
        if (p[0] == 2) p[0] = 0.5;  // The second cube goes back from 1 to 0.5.
    const MeshQuality quality = meshQuality(volumeMeshOf(box.complex), folded);
    EXPECT_THAT(quality.nonPositiveVolumes, ElementsAre(1));
    EXPECT_EQ(quality.smallestVolume->cell, 1);
    EXPECT_NEAR(quality.smallestVolume->value, -0.5, 1e-14);
    EXPECT_NEAR(quality.smallestScaledJacobian->value, -1, 1e-14);
    // The pyramids of the second cube to all its six faces; the one to the common face is on the
    // side of the neighbour.
    EXPECT_EQ(quality.negativePyramids, 6);
    // Its centre is at 0.75, beyond the centre of the first, which is at 0.5.
    EXPECT_NEAR(quality.largestNonOrthogonality->value, 0, 1e-6);
    for (Point3& p : folded)
        if (p[0] == 0.5) p[0] = -1;  // Now at 0: the line between the centres points backwards.
    EXPECT_NEAR(meshQuality(volumeMeshOf(box.complex), folded).largestNonOrthogonality->value, 180,
                1e-6);
}

TEST(MeshQuality, ScaledJacobiansOfRegularCellsAreOne) {
    const double r3 = std::numbers::sqrt3, r2 = std::numbers::sqrt2;
    EXPECT_NEAR(
        jacobianOf(StandardCell::Tetrahedron, {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}),
        -1, 1e-15);
    EXPECT_NEAR(
        jacobianOf(StandardCell::Tetrahedron, {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}}),
        1, 1e-15);
    EXPECT_NEAR(jacobianOf(StandardCell::Pyramid,
                           {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, r2 / 2}}),
                1, 1e-15);
    EXPECT_NEAR(
        jacobianOf(
            StandardCell::Wedge,
            {{0, 0, 0}, {0.5, r3 / 2, 0}, {1, 0, 0}, {0, 0, 1}, {0.5, r3 / 2, 1}, {1, 0, 1}}),
        1, 1e-15);
    const Positions cube = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                            {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    EXPECT_EQ(jacobianOf(StandardCell::Hexahedron, cube), 1);
    // Each corner counts: pushing it through the cell folds the cell.
    for (const auto& [kind, cell] :
         {std::pair(StandardCell::Hexahedron, cube),
          std::pair(StandardCell::Wedge,
                    Positions{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}})})
        for (std::size_t i = 0; i < cell.size(); ++i) {
            Positions pushed = cell;
            for (std::size_t c = 0; c < 3; ++c) pushed[i][c] = 3 * (0.4 - pushed[i][c]) + 0.4;
            EXPECT_LT(jacobianOf(kind, pushed), -0.2) << i;
        }
    // An edge without length is a flat corner.
    Positions collapsed = cube;
    collapsed[1] = collapsed[0];
    EXPECT_EQ(jacobianOf(StandardCell::Hexahedron, collapsed), 0);
}

// The weights of the centres reproduce the centres; and by definition, with the formula of a
// quadrilateral that is bent: (0,0,0), (2,0,0), (2,2,h), (0,2,0).
TEST(MeshCentres, WeightsGiveTheCentres) {
    const Lattice solid = shapes::dodecahedron();
    Positions positions = solid.positions;
    const auto noise = randomValues(3 * positions.size(), 3);
    for (std::size_t i = 0; i < noise.size(); ++i) positions[i / 3][i % 3] += 5 + 0.2 * noise[i];
    const far::VolumeMesh mesh = volumeMeshOf(solid.complex);
    Positions centres, areas;
    std::vector<double> weights;
    for (Index face = 0; face < mesh.faceCount(); ++face) {
        const FaceCentre centre = faceCentre(mesh.face(face), positions, &weights);
        centres.push_back(centre.centre);
        areas.push_back(centre.area);
        EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-15);
        for (std::size_t c = 0; c < 3; ++c) {
            double sum = 0;
            for (std::size_t i = 0; i < weights.size(); ++i)
                sum += weights[i] * positions[mesh.face(face)[i]][c];
            EXPECT_NEAR(sum, centre.centre[c], 1e-14);
        }
    }
    const CellCentre cell = cellCentre(mesh, 0, centres, areas, &weights);
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-15);
    for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (std::size_t i = 0; i < weights.size(); ++i)
            sum += weights[i] * centres[mesh.faces(0)[i]][c];
        EXPECT_NEAR(sum, cell.centre[c], 1e-14);
    }
    const std::vector<Index> loop = {0, 1, 2, 3};
    // Without bend: the middle, and the area 4. The flat cell around it has no volume.
    const FaceCentre flat = faceCentre(loop, Positions{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
    EXPECT_EQ(flat.centre, (Point3{1, 1, 0}));
    EXPECT_EQ(flat.area, (Point3{0, 0, 4}));
    EXPECT_EQ(faceCentre(loop, Positions(4, {1, 2, 3})).centre, (Point3{1, 2, 3}));
    EXPECT_EQ(faceCentre(loop, Positions(4, {1, 2, 3})).area, (Point3{0, 0, 0}));
}

// In OpenFOAM, the volume of a standard cell is the integral of the determinant of its map: for a
// bent quadrilateral m + u b + v c + u v d, all triangles of the face have their centroids in the
// plane of b and c through m, to which the area vector is perpendicular. So a cell that is valid
// has a positive volume. The integral is the mean of the Bernstein coefficients, times the volume
// of the domain: 1, 1/6 for a tetrahedron, 1/2 for a wedge, whose polynomials are those at its
// three edges, and 1/3 for a pyramid, where the factor (1 − w)² is left out.
TEST(MeshQuality, VolumesAreIntegralsOfDeterminants) {
    for (const auto& [kind, domain] :
         {std::pair(StandardCell::Tetrahedron, 1.0 / 6), std::pair(StandardCell::Pyramid, 1.0 / 3),
          std::pair(StandardCell::Wedge, 0.5), std::pair(StandardCell::Hexahedron, 1.0)}) {
        const Index count = far::vertexCount(kind);
        far::VolumeMeshBuilder builder(count);
        std::vector<Index> corners(count);
        std::iota(corners.begin(), corners.end(), 0);
        builder.addCell(kind, corners);
        const far::VolumeMesh mesh = builder.build();
        for (unsigned seed = 0; seed < 20; ++seed) {
            const auto values = randomValues(3 * corners.size(), seed);
            Positions positions(corners.size());
            for (std::size_t i = 0; i < values.size(); ++i) positions[i / 3][i % 3] = values[i];
            double sum = 0;
            int pieces = 0;
            MeshPieces(mesh, positions)
                .forEach(
                    0,
                    [&](const auto& piece) {
                        const auto polynomial = determinant(piece.derivatives);
                        for (const auto& lanes : polynomial)
                            sum += lanes[0] / double(polynomial.size());
                        ++pieces;
                    },
                    std::span<const Point3>(positions));
            EXPECT_NEAR(meshQuality(mesh, positions).smallestVolume->value, domain * sum / pieces,
                        1e-14);
        }
    }
}

TEST(MeshQuality, DoesNotDependOnThreads) {
    const Lattice box = shapes::box({.cells = {20, 20, 20}});
    Positions positions = box.positions;
    const auto noise = randomValues(3 * positions.size(), 1);
    for (std::size_t i = 0; i < noise.size(); ++i) positions[i / 3][i % 3] += 0.02 * noise[i];
    const far::VolumeMesh mesh = volumeMeshOf(box.complex);
    const auto run = [&] { return meshQuality(mesh, positions); };
    const MeshQuality one = withThreads(1, run), other = withThreads(4, run);
    EXPECT_EQ(one.largestSkewness, other.largestSkewness);
    EXPECT_EQ(one.largestNonOrthogonality, other.largestNonOrthogonality);
    EXPECT_EQ(one.meanNonOrthogonality, other.meanNonOrthogonality);
    EXPECT_EQ(one.smallestVolume->cell, other.smallestVolume->cell);
}

TEST(MeshQuality, OfNothing) {
    const MeshQuality quality = meshQuality(far::VolumeMesh(), {});
    EXPECT_FALSE(quality.smallestVolume);
    EXPECT_FALSE(quality.largestSkewness);
    EXPECT_FALSE(quality.largestNonOrthogonality);
    EXPECT_REFUSED(Error, "got 1 positions for a mesh of 0 points",
                   meshQuality(far::VolumeMesh(), Positions(1)));
}

// A crescent: a triangle with corners (0, 0), (1, 0) and (0, 1) whose edges are parabolas. An edge
// whose middle moves by d adds two thirds of its length times d across it.
TEST(MeshQuality, AreasAndVolumesOfSecondOrderAreThoseOfTheCurvedCell) {
    Positions points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0, 0}, {0.5, 0.5, 0}, {0, 0.5, 0}};
    far::SurfaceMesh surface(6);
    surface.addFace(std::vector<Index>{0, 1, 2, 3, 4, 5});
    EXPECT_NEAR(surfaceQuality(surface, points, points).smallestVolume->value, 0.5, 1e-15);
    Positions curved = points;
    curved[3][1] = -0.3;
    EXPECT_NEAR(surfaceQuality(surface, points, curved).smallestVolume->value, 0.5 + 0.2, 1e-15);
    // The corners alone are the wrong way around, and the cell is not.
    curved[1] = {1, 0.5, 0};
    curved[2] = {0.9, 0.3, 0};
    curved[4] = {1.2, 0.45, 0};
    EXPECT_LT(areaVector(std::vector<Point3>{curved[0], curved[1], curved[2]})[2], 0);
    // Two thirds of the offset of each middle, across the edge.
    const auto bulge = [&](std::size_t a, std::size_t b, std::size_t middle) {
        const Point3 edge = difference(curved[b], curved[a]);
        const Point3 offset = difference(curved[middle], scaled(sum(curved[a], curved[b]), 0.5));
        return 2.0 / 3 * (edge[1] * offset[0] - edge[0] * offset[1]);
    };
    const double area = areaVector(std::vector<Point3>{curved[0], curved[1], curved[2]})[2] +
                        bulge(0, 1, 3) + bulge(1, 2, 4) + bulge(2, 0, 5);
    EXPECT_NEAR(surfaceQuality(surface, points, curved).smallestVolume->value, area, 1e-15);
    // A wedge over the curved triangle, of height 2.
    Positions prism;
    far::VolumeMeshBuilder builder(15);
    std::vector<Index> all(15);
    std::iota(all.begin(), all.end(), 0);
    const auto at = [&](std::size_t point, double z) {
        prism.push_back({curved[point][0], curved[point][1], z});
    };
    // VTK's first triangle is clockwise seen from the other one.
    for (const double z : {0.0, 2.0})
        for (const std::size_t point : {0, 2, 1}) at(point, z);
    for (const double z : {0.0, 2.0})
        for (const std::size_t point : {5, 4, 3}) at(point, z);
    for (const std::size_t point : {0, 2, 1}) at(point, 1);
    builder.addCell(far::StandardCell::Wedge, all);
    EXPECT_NEAR(meshQuality(builder.build(), prism).smallestVolume->value, 2 * area, 1e-14);
}

}  // namespace
}  // namespace espalier::solve
