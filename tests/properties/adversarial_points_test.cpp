// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/standard_cells.h>

#include "support/refined_lattice.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

// Tests points exactly between cells, where rounding decides which cell they seem to be in: every
// point must be found.

namespace espalier::embed {
namespace {

/// Rotates the point at height z by `rate` · z radians.
Lattice twisted(Lattice lattice, double rate) {
    for (Point3& p : lattice.positions) {
        const double c = std::cos(rate * p[2]), s = std::sin(rate * p[2]);
        p = {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    }
    return lattice;
}

/// Moves each vertex by up to `size` along each axis.
Lattice shaken(Lattice lattice, double size, unsigned seed) {
    lattice.positions = test::shaken(lattice.positions, seed, size);
    return lattice;
}

std::vector<NamedLattice> hardLattices() {
    return {
        {"box", shapes::box({.cells = {3, 3, 3}})},
        {"box, 60 degrees a cell", twisted(shapes::box({.cells = {2, 2, 3}, .max = {2, 2, 3}}), 1)},
        {"box, 90 degrees a cell",
         twisted(shapes::box({.cells = {2, 2, 3}, .max = {2, 2, 3}}), 1.57)},
        {"box, shaken", shaken(shapes::box({.cells = {3, 3, 3}, .max = {3, 3, 3}}), 0.3, 1)},
        {"mixed cells", mixedLattice()},
        {"mixed cells, shaken", shaken(mixedLattice(), 0.1, 2)},
        {"icosahedron", shapes::icosahedron()},
        {"icosahedron, shaken", shaken(shapes::icosahedron(), 0.1, 3)},
        {"bipyramid", shapes::bipyramid({.sides = 7})},
        {"torus", shapes::torus()}};
}

/// Returns points on vertices, edges and faces of the cells of a level, the same number of each.
std::vector<Point3> pointsBetweenCells(const Refined& refined, std::size_t count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const CellComplex& complex = refined.complex();
    std::vector<Point3> points;
    while (points.size() < count) {
        CellPlace place;
        place.cell = CellId(Index(random() % std::uint64_t(complex.count(3))));
        const std::size_t dimension = points.size() % 3;  // of the entity that the point is on
        if (far::hexahedronVertices(complex, place.cell)) {
            for (double& coordinate : place.uvw) coordinate = uniform(random);
            const std::size_t first = random() % 3;
            for (std::size_t k = dimension; k < 3; ++k)
                place.uvw[(first + k) % 3] = double(random() % 2);
        } else {
            // On the base of a tetrahedron, which is half a face: u + v + w = 1.
            place.tetrahedron =
                Index(random() % std::uint64_t(tetrahedronCount(complex, place.cell)));
            const std::size_t first = random() % 3;
            double sum = 0;
            for (std::size_t k = 0; k <= dimension; ++k)
                sum += place.uvw[(first + k) % 3] = uniform(random) + 1e-300;
            for (double& coordinate : place.uvw) coordinate /= sum;
        }
        Eigen::Vector3d position = Eigen::Vector3d::Zero();
        for (const auto& [vertex, weight] : placeWeights(complex, place))
            position += weight * vec(refined.positions[vertex]);
        points.push_back({position[0], position[1], position[2]});
    }
    return points;
}

/// \param count number of points for each lattice and level
void expectAllFound(std::size_t count) {
    for (const auto& [name, lattice] : hardLattices()) {
        double size = 0;
        for (const Point3& position : lattice.positions)
            size = std::max(size, 2 * vec(position).norm());
        for (const int level : {1, 2}) {
            const Refined refined(lattice, level);
            constexpr std::size_t kBatch = 250'000;
            std::size_t lost = 0;
            double residual = 0;
            for (std::size_t first = 0; first < count; first += kBatch) {
                const std::size_t batch = std::min(kBatch, count - first);
                const auto points = pointsBetweenCells(refined, batch, unsigned(first) + 7);
                const Embedding found = refined.embed(points);
                lost += batch - std::size_t(found.count(PointStatus::Inside));
                residual = std::max(residual, found.largestResidual());
            }
            EXPECT_EQ(lost, 0u) << name << ", level " << level;
            // The residual of a place that reproduces its point. (A point with a cell that cannot
            // be solved for gets the nearest place, with a residual of up to a millionth.)
            EXPECT_LE(residual, 1e-12 * size) << name << ", level " << level;
            std::printf("%-24s level %d: %zu points, largest residual %.1e of the size\n",
                        name.c_str(), level, count, residual / size);
        }
    }
}

TEST(AdversarialPoints, AreAllFound) {
    expectAllFound(3'000);
}

// Ten million points in total.
TEST(TenMillionAdversarialPoints, AreAllFound) {
    expectAllFound(500'000);
}

}  // namespace
}  // namespace espalier::embed
