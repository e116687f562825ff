// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/complex_builder.h>
#include <espalier/far/standard_cells.h>
#include <espalier/shapes/lattice.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <random>
#include <vector>

namespace espalier::test {

/// Returns the Delaunay tetrahedra of random points in the unit cube: those whose circumscribed
/// sphere contains no other point. Tests every four points, O(n⁵).
inline Lattice delaunayLattice(Index pointCount, unsigned seed) {
    using Eigen::Vector3d;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<Point3> points(pointCount);
    for (Point3& point : points)
        for (double& coordinate : point) coordinate = uniform(random);
    const auto at = [&](Index i) { return Vector3d(points[i].data()); };
    far::ComplexBuilder builder(3, pointCount);
    const auto addIfEmpty = [&](std::array<Index, 4> corners) {
        Eigen::Matrix3d edges;
        for (int i = 0; i < 3; ++i) edges.row(i) = (at(corners[i + 1]) - at(corners[0]));
        const Vector3d centre = edges.inverse() * edges.rowwise().squaredNorm() / 2;
        for (Index other = 0; other < pointCount; ++other)
            if (std::find(corners.begin(), corners.end(), other) == corners.end() &&
                (at(other) - at(corners[0]) - centre).squaredNorm() < centre.squaredNorm())
                return;
        if (edges.determinant() < 0) std::swap(corners[2], corners[3]);
        builder.addCell(far::StandardCell::Tetrahedron, corners);
    };
    for (Index a = 0; a < pointCount; ++a)
        for (Index b = a + 1; b < pointCount; ++b)
            for (Index c = b + 1; c < pointCount; ++c)
                for (Index d = c + 1; d < pointCount; ++d) addIfEmpty({a, b, c, d});
    return {builder.build(), points, {}, {}};
}

}  // namespace espalier::test
