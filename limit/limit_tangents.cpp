// SPDX-License-Identifier: Apache-2.0
#include "limit_tangents.h"

#include <espalier/limit/vertex_ring.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/surroundings.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace espalier::limit {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Three edges at a vertex, by their positions among all edges at the vertex.
using EdgePlaces = std::array<Index, 3>;

/// Returns the first three edges of a cell at a corner. (Any three edges of a convex cell that meet
/// in a vertex are linearly independent.)
EdgePlaces edgesAt(const far::CellComplex& complex, const CellCorner& corner) {
    const auto around = complex.relation(0, 1)[corner.vertex];
    EdgePlaces places = {};
    std::size_t count = 0;
    for (const Index edge : complex.relation(3, 1)[corner.cell]) {
        const auto found = std::find(around.begin(), around.end(), edge);
        if (found != around.end() && count < places.size())
            places[count++] = static_cast<Index>(found - around.begin());
    }
    return places;
}

/// Applies one level. Then corrects the sum of each column to 0, since the rounding of the sum
/// would not shrink with the columns.
MatrixXd stepped(const Eigen::SparseMatrix<double>& transposed, const MatrixXd& columns) {
    MatrixXd next = transposed * columns;
    next.row(0) -= next.colwise().sum();
    return next;
}

/// Returns the functionals of three edges, one in each column, the slowest to shrink first.
MatrixXd sortedEdges(const Eigen::SparseMatrix<double>& transposed, const EdgePlaces& places) {
    // Rates of shrinking that differ by less than a tenth do not matter.
    constexpr int kSteps = 16;
    MatrixXd edges = MatrixXd::Zero(transposed.rows(), 3);
    for (Eigen::Index k = 0; k < 3; ++k) {
        edges(0, k) = -1;  // The ring has the vertex first, then its edges.
        edges(1 + places[k], k) = 1;
    }
    MatrixXd later = edges;
    for (int step = 0; step < kSteps; ++step) later = stepped(transposed, later);
    std::array<Eigen::Index, 3> order = {0, 1, 2};
    std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
        return later.col(a).squaredNorm() > later.col(b).squaredNorm();
    });
    return edges(Eigen::all, order);
}

/// Returns the direction that a functional converges to, modulo the space `known`.
///
/// Rounding may add a direction that shrinks more slowly than the functional itself, and so grows
/// relative to it (along an edge of 16 cells by 1.22 per level, while the functional converges by
/// 0.6). So the result is the iterate that changes least, before changes increase again.
/// \param known an orthonormal basis of a space that is invariant under the matrix
/// \return nullopt if the direction does not converge
std::optional<VectorXd> limitOf(const Eigen::SparseMatrix<double>& transposed, VectorXd functional,
                                const MatrixXd& known) {
    // Around an edge of 16 cells, directions converge by 0.95 per step.
    constexpr int kMaxSteps = 2048;
    constexpr double kSettled = 1e-15, kConverged = 1e-11, kRising = 100;
    const auto normalized = [&](const VectorXd& vector) -> VectorXd {
        return (vector - known * (known.transpose() * vector)).normalized();
    };
    double least = std::numeric_limits<double>::infinity();
    VectorXd best, now = normalized(functional);
    for (int step = 0; step < kMaxSteps; ++step) {
        VectorXd next = normalized(stepped(transposed, now));
        const double change = (next - now.dot(next) * now).norm();
        if (change < least) {
            least = change;
            best = next;
        }
        if (least <= kSettled || (least <= kConverged && change > kRising * least)) break;
        now = std::move(next);
    }
    if (!(least <= kConverged)) return std::nullopt;
    return best;
}

/// Returns an orthonormal basis of the space that the functionals of three edges converge to, over
/// the points of the ring. Computes one direction after the other; where a direction does not
/// converge, all three at once.
MatrixXd directionsOf(const VertexRing& ring, const EdgePlaces& places) {
    const Eigen::SparseMatrix<double> transposed = ring.subdivision.transpose();
    const MatrixXd edges = sortedEdges(transposed, places);
    MatrixXd known(edges.rows(), 0);
    while (known.cols() < 3) {
        const auto limit = limitOf(transposed, edges.col(known.cols()), known);
        if (!limit) break;
        known.conservativeResize(Eigen::NoChange, known.cols() + 1);
        known.rightCols(1) = *limit;
    }
    if (known.cols() == 3) return known;
    // A direction that rotates or converges slowly stays in the space of the three functionals.
    constexpr int kSteps = 128;
    MatrixXd basis = stencils::orthonormalBasis(edges);
    for (int step = 0; step < kSteps; ++step)
        basis = stencils::orthonormalBasis(stepped(transposed, basis));
    return basis;
}

}  // namespace

stencils::StencilTable<double> buildTangentTable(const far::TopologyRefiner& refiner, int level,
                                                 std::span<const CellCorner> corners) {
    const far::Level& here = refiner.level(level);
    std::vector<Index> vertices;
    for (const CellCorner& corner : corners) vertices.push_back(corner.vertex);
    const stencils::ShapeGroups groups = stencils::groupByShape(refiner, here, vertices);

    // For each distinct ring, the triples of edges that are needed there.
    std::vector<std::map<EdgePlaces, MatrixXd>> directions(groups.representatives.size());
    const auto directionsAt = [&](const CellCorner& corner) -> MatrixXd& {
        return directions[groups.groupOf.at(corner.vertex)][edgesAt(here.complex, corner)];
    };
    for (const CellCorner& corner : corners) directionsAt(corner);
    parallelFor(std::ssize(groups.representatives), 1, [&](Offset first, Offset last) {
        for (Offset group = first; group < last; ++group) {
            const VertexRing ring = ringOf(here, refiner.options(), groups.representatives[group]);
            for (auto& [places, columns] : directions[group])
                columns = ring.start.transpose() * directionsOf(ring, places);
        }
    });
    return stencils::buildTable(
        static_cast<Index>(3 * corners.size()), here.complex.count(0),
        [&](Index row, stencils::RowAccumulator& accumulator) {
            const CellCorner& corner = corners[row / 3];
            const MatrixXd& columns =
                directions[groups.groupOf.at(corner.vertex)].at(edgesAt(here.complex, corner));
            const std::vector<Index> around = verticesAround(here.complex, corner.vertex);
            for (std::size_t i = 0; i < around.size(); ++i)
                accumulator.add(around[i], columns(static_cast<Eigen::Index>(i), row % 3));
            accumulator.makeSumZero();
        });
}

}  // namespace espalier::limit
