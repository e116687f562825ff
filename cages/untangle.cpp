// SPDX-License-Identifier: Apache-2.0
#include "untangle.h"

#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/far/standard_cells.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "cage_energy.h"

namespace espalier::cages {
namespace {

/// Returns the axis of an edge of a hexahedron, whose vertices are in VTK's order.
std::size_t axisOf(std::size_t corner, std::size_t end) {
    if (corner / 4 != end / 4) return 2;
    // Around a face: 0 and 1, 2 and 3 differ along the first axis.
    return corner % 4 / 2 == end % 4 / 2 ? 0 : 1;
}

/// A corner of a cell of level 1: a vertex, and three neighbours along edges that are right-handed
/// in this order in a valid cell.
struct CellCorner {
    std::array<Index, 4> vertices = {};
    std::array<double, 3> lengths = {};  ///< desired lengths of the three edges
    double weight = 1;
};

using Edges = std::array<Point3, 3>;

Edges edgesOf(const CellCorner& corner, std::span<const Point3> positions) {
    Edges edges;
    for (std::size_t i = 0; i < 3; ++i)
        edges[i] =
            scaled(difference(positions[corner.vertices[i + 1]], positions[corner.vertices[0]]),
                   1 / corner.lengths[i]);
    return edges;
}

/// Returns the corners of the hexahedra of level 1 in examined base cells.
std::vector<CellCorner> cornersOf(const far::TopologyRefiner& refiner, const TangledCells& cells) {
    const far::CellComplex& complex = refiner.level(1).complex;
    const Index vertexCount = refiner.level(0).complex.count(0);
    std::vector<CellCorner> corners;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const double weight = cells.weights[std::size_t(solve::baseCellOf(refiner, 1, cell))];
        if (!(weight > 0)) continue;
        const auto vertices = far::hexahedronVertices(complex, CellId(cell));
        if (!vertices) continue;
        // The vertex of level 0 is the lowest. The other ends of its edges are in the middle of
        // edges of level 0, whose directions the edges of the hexahedron have.
        const auto lowest =
            std::size_t(std::min_element(vertices->begin(), vertices->end()) - vertices->begin());
        std::array<double, 3> byAxis = {};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t end = far::kHexahedronNeighbours[lowest][i];
            byAxis[axisOf(lowest, end)] =
                0.5 * cells.lengths[std::size_t((*vertices)[end] - vertexCount)];
        }
        for (std::size_t corner = 0; corner < 8; ++corner) {
            CellCorner& added = corners.emplace_back();
            added.weight = weight;
            added.vertices[0] = (*vertices)[corner];
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t end = far::kHexahedronNeighbours[corner][i];
                added.vertices[i + 1] = (*vertices)[end];
                added.lengths[i] = byAxis[axisOf(corner, end)];
            }
        }
    }
    return corners;
}

double determinant(const Edges& edges) {
    return dot(edges[0], cross(edges[1], edges[2]));
}

double smallestDeterminant(std::span<const CellCorner> corners, std::span<const Point3> positions) {
    double smallest = std::numeric_limits<double>::max();
    for (const CellCorner& corner : corners)
        smallest = std::min(smallest, determinant(edgesOf(corner, positions)));
    return smallest;
}

/// Returns the energy of the corners and adds its gradient.
double energyOf(std::span<const CellCorner> corners, double epsilon,
                std::span<const Point3> positions, std::span<Point3> gradient) {
    double total = 0;
    for (const CellCorner& corner : corners) {
        const Edges edges = edgesOf(corner, positions);
        const Edges cofactors = {cross(edges[1], edges[2]), cross(edges[2], edges[0]),
                                 cross(edges[0], edges[1])};
        const double d = dot(edges[0], cofactors[0]);
        const double root = std::sqrt(epsilon * epsilon + d * d);
        // For negative d, the sum would cancel.
        const double chi = d >= 0 ? 0.5 * (d + root) : 0.5 * epsilon * epsilon / (root - d);
        const double slope = root > 0 ? chi / root : 0.5;
        const double stretch =
            dot(edges[0], edges[0]) + dot(edges[1], edges[1]) + dot(edges[2], edges[2]);
        const double shrink = dot(cofactors[0], cofactors[0]) + dot(cofactors[1], cofactors[1]) +
                              dot(cofactors[2], cofactors[2]);
        const double inverse = 1 / (chi * chi);
        const double energy = stretch + shrink * inverse;
        // The square makes the worst corners count most.
        total += corner.weight * energy * energy;
        const double byEnergy = corner.weight * 2 * energy;
        const double byDeterminant = -2 * shrink * inverse / chi * slope;
        for (std::size_t i = 0; i < 3; ++i) {
            // Cofactor i is edge i + 1 times edge i + 2.
            const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
            const Point3 byCofactors =
                sum(cross(edges[next], cofactors[last]), cross(cofactors[next], edges[last]));
            const Point3 byEdge = scaled(sum(scaled(sum(edges[i], scaled(byCofactors, inverse)), 2),
                                             scaled(cofactors[i], byDeterminant)),
                                         byEnergy / corner.lengths[i]);
            Point3& end = gradient[corner.vertices[i + 1]];
            Point3& start = gradient[corner.vertices[0]];
            end = sum(end, byEdge);
            start = difference(start, byEdge);
        }
    }
    return total;
}

/// Returns the energy of a vertex on a tether and adds its gradient.
double tetherEnergy(const Point3& way, double tether, Point3& gradient) {
    // A corner without distortion has the energy 36; a vertex of a grid is in 64 corners of level 1
    // near it. At the length of the tether, the vertex costs as much as all of them.
    constexpr double kWeight = 36 * 64;
    const double square = dot(way, way) / (tether * tether);
    gradient = sum(gradient, scaled(way, 4 * kWeight * square / (tether * tether)));
    return kWeight * square * square;
}

}  // namespace

bool untangle(std::vector<Point3>& positions, const TangledCells& cells) {
    constexpr int kRounds = 60;
    constexpr int kIterations = 60;
    constexpr int kPolish = 6;  // rounds after the last fold is gone
    far::TopologyRefiner refiner = cells.base;
    refiner.refineUniform(1);
    const std::vector<CellCorner> corners = cornersOf(refiner, cells);
    if (corners.empty()) return true;
    const auto table = stencils::buildLevelTable(refiner, 1);
    const auto refined = [&](std::span<const Point3> at) {
        return stencils::applyLevelTable(table, at);
    };
    double edge = std::numeric_limits<double>::max();
    for (const CellCorner& corner : corners)
        edge = std::min(edge, *std::min_element(corner.lengths.begin(), corner.lengths.end()));
    std::vector<Point3> slopes(std::size_t(table.rowCount()));
    int polished = 0;
    for (int round = 0; round < kRounds && polished < kPolish; ++round) {
        checkCancelled();
        const double smallest = smallestDeterminant(corners, refined(positions));
        const double below = std::min(smallest, 0.0);
        const double epsilon = std::sqrt(1e-12 + 0.04 * below * below);
        if (smallest > 0) ++polished;
        const Energy energy = [&](std::span<const Point3> at, std::span<Point3> gradient) {
            std::fill(slopes.begin(), slopes.end(), Point3{0, 0, 0});
            double total = energyOf(corners, epsilon, refined(at), slopes);
            std::fill(gradient.begin(), gradient.end(), Point3{0, 0, 0});
            for (Index row = 0; row < table.rowCount(); ++row) {
                const auto columns = table.columns(row);
                const auto weights = table.weights(row);
                for (std::size_t i = 0; i < columns.size(); ++i) {
                    Point3& slope = gradient[std::size_t(columns[i])];
                    slope = sum(slope, scaled(slopes[std::size_t(row)], weights[i]));
                }
            }
            for (std::size_t v = 0; v < gradient.size(); ++v) {
                const VertexFreedom& freedom = cells.freedoms[v];
                if (freedom.tether > 0)
                    total +=
                        tetherEnergy(difference(at[v], freedom.home), freedom.tether, gradient[v]);
                gradient[v] =
                    freedom.isFree ? freedom.planes.inPlanes(gradient[v]) : Point3{0, 0, 0};
            }
            return total;
        };
        positions = minimise(energy, std::move(positions), kIterations, edge);
    }
    return smallestDeterminant(corners, refined(positions)) > 0;
}

}  // namespace espalier::cages
