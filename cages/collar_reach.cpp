// SPDX-License-Identifier: Apache-2.0
#include "collar_reach.h"

#include <espalier/base/vector3.h>
#include <espalier/embed/box_tree.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/simplex.h>

#include <algorithm>

namespace espalier::cages {
namespace {

/// Returns the triangles between the edges and the mean of each face of the lattice under a prism.
std::vector<embed::Triangle> coveredTriangles(std::span<const Point3> positions,
                                              const CollarCells& cells) {
    const auto vectorOf = [](const Point3& point) { return Eigen::Vector3d(point.data()); };
    std::vector<embed::Triangle> triangles;
    for (const CollarPrism& prism : cells.prisms) {
        if (std::ranges::max(prism.bottom) >= std::ssize(positions)) continue;
        std::vector<Point3> corners;
        for (const Index vertex : prism.bottom) corners.push_back(positions[vertex]);
        const auto middle = vectorOf(mean(corners));
        for (std::size_t i = 0; i < corners.size(); ++i)
            triangles.push_back(
                {middle, vectorOf(corners[i]), vectorOf(corners[(i + 1) % corners.size()])});
    }
    return triangles;
}

double distanceFrom(const embed::Triangle& triangle, const Eigen::Vector3d& point) {
    const embed::Triangle around = {triangle[0] - point, triangle[1] - point, triangle[2] - point};
    const Eigen::Vector3d weights = embed::nearestToOrigin(around);
    return (weights[0] * around[0] + weights[1] * around[1] + weights[2] * around[2]).norm();
}

}  // namespace

std::vector<double> distancesFromLattice(const Lattice& lattice, const CollarCells& cells,
                                         int layers) {
    const embed::LengthUnit unit(lattice.positions);
    const auto triangles = coveredTriangles(unit.toUnits(lattice.positions), cells);
    std::vector<embed::BoxTree::Box> boxes;
    for (const embed::Triangle& triangle : triangles) {
        embed::BoxTree::Box& box = boxes.emplace_back();
        for (const Eigen::Vector3d& corner : triangle) box.extend(corner);
    }
    const embed::BoxTree tree(boxes);
    std::vector<double> distances(cells.vertices.size(), 0.0);
    for (std::size_t v = 0; v < cells.vertices.size(); ++v) {
        if (cells.vertices[v].layer != layers) continue;
        const Point3 position = unit.toUnits(cells.vertices[v].position);
        const Eigen::Vector3d point(position.data());
        const auto nearest = tree.findNearest(
            point, [&](Index item) { return distanceFrom(triangles[item], point); });
        distances[v] = unit.fromUnits(nearest.distance);
    }
    return distances;
}

}  // namespace espalier::cages
