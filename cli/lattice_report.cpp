// SPDX-License-Identifier: Apache-2.0
#include "lattice_report.h"

#include <espalier/far/standard_cells.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace espalier::cli {
namespace {

using Eigen::Vector3d;
using far::CellComplex;

Vector3d at(const std::vector<Point3>& positions, Index vertex) {
    return Vector3d(positions[vertex].data());
}

Vector3d mean(const std::vector<Point3>& positions, std::span<const Index> vertices) {
    Vector3d sum = Vector3d::Zero();
    for (const Index vertex : vertices) sum += at(positions, vertex);
    return sum / static_cast<double>(vertices.size());
}

/// The signed volume of a cell whose faces are fans of triangles about their centroids.
double cellVolume(const CellComplex& complex, const std::vector<Point3>& positions, Index cell) {
    // Measured from the cell's own centroid, so that far-off lattices lose no digits.
    const Vector3d origin = mean(positions, complex.relation(3, 0)[cell]);
    const auto faces = complex.relation(3, 2)[cell];
    double volume = 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto loop = complex.relation(2, 0)[faces[f]];
        const Vector3d centre = mean(positions, loop) - origin;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vector3d a = at(positions, loop[i]) - origin;
            const Vector3d b = at(positions, loop[(i + 1) % loop.size()]) - origin;
            volume += complex.boundary(3).signs(cell)[f] * centre.dot(a.cross(b)) / 6;
        }
    }
    return volume;
}

/// The smallest determinant of the three unit edges at a corner of a hexahedron.
double scaledJacobian(const std::array<Index, 8>& corners, const std::vector<Point3>& positions) {
    constexpr std::size_t kNeighbours[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                               {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};
    double smallest = 1;
    for (std::size_t i = 0; i < 8; ++i) {
        Vector3d edges[3];
        for (std::size_t k = 0; k < 3; ++k)
            edges[k] = (at(positions, corners[kNeighbours[i][k]]) - at(positions, corners[i]))
                           .normalized();
        smallest = std::min(smallest, edges[0].dot(edges[1].cross(edges[2])));
    }
    return smallest;
}

/// n of each cell: of the vertices in their cells for a base lattice, of the cells themselves
/// above.
Histogram cellTypes(const CellComplex& complex, bool isBase) {
    Histogram types;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        if (!isBase) {
            ++types[static_cast<Index>(complex.relation(3, 2)[cell].size()) / 2];
            continue;
        }
        Histogram valence;
        for (const Index edge : complex.relation(3, 1)[cell])
            for (const Index end : complex.relation(1, 0)[edge]) ++valence[end];
        for (const auto& [vertex, n] : valence) ++types[n];
    }
    return types;
}

LevelReport reportLevel(const far::Level& level, const std::vector<Point3>& positions,
                        bool isBase) {
    const CellComplex& complex = level.complex;
    LevelReport report{};
    for (int d = 0; d <= 3; ++d) {
        report.counts[d] = complex.count(d);
        for (int s = 0; s <= 3; ++s) report.strata[d][s] = level.strata.count(d, s);
    }
    report.eulerCharacteristic = complex.eulerCharacteristic();
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        ++report.vertexValences[static_cast<Index>(complex.relation(0, 1)[vertex].size())];
    for (Index edge = 0; edge < complex.count(1); ++edge)
        if (level.strata.of({1, edge}) == 3)
            ++report.edgeValences[static_cast<Index>(complex.relation(1, 2)[edge].size())];
    report.cellTypes = cellTypes(complex, isBase);

    report.smallestVolume = std::numeric_limits<double>::infinity();
    report.largestVolume = -report.smallestVolume;
    report.smallestScaledJacobian = 1;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const double volume = cellVolume(complex, positions, cell);
        report.smallestVolume = std::min(report.smallestVolume, volume);
        report.largestVolume = std::max(report.largestVolume, volume);
        report.invertedCells += !(volume > 0);
        if (const auto corners = far::hexahedronVertices(complex, CellId(cell)))
            report.smallestScaledJacobian =
                std::min(report.smallestScaledJacobian, scaledJacobian(*corners, positions));
    }
    return report;
}

}  // namespace

LatticeReport reportLattice(const Lattice& lattice, const far::TopologyRefiner& refiner,
                            const std::vector<std::vector<Point3>>& positions) {
    LatticeReport report{};
    report.boundsMin = report.boundsMax = lattice.positions.front();
    for (const Point3& position : lattice.positions)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            report.boundsMin[axis] = std::min(report.boundsMin[axis], position[axis]);
            report.boundsMax[axis] = std::max(report.boundsMax[axis], position[axis]);
        }
    report.marks = lattice.marks.edges.size() + lattice.marks.vertices.size();
    for (const VertexAttribute& attribute : lattice.attributes)
        report.attributes.push_back(attribute.name);
    for (const VertexIntegers& integers : lattice.integers)
        report.attributes.push_back(integers.name);
    for (int level = 0; level <= refiner.maxLevel(); ++level)
        report.levels.push_back(reportLevel(refiner.level(level), positions[level], level == 0));
    const auto& valences = report.levels.front().edgeValences;
    report.edgesOfTwoFaces = valences.count(2) > 0 ? valences.at(2) : 0;
    return report;
}

}  // namespace espalier::cli
