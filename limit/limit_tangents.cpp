// SPDX-License-Identifier: Apache-2.0
#include "limit_tangents.h"

#include <espalier/limit/vertex_ring.h>
#include <espalier/stencils/surroundings.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/QR>
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

/// Three edges at a vertex, by their places among all edges there.
using EdgePlaces = std::array<Index, 3>;

/// The first three edges of a cell that leave a corner of it. (Any three edges of a convex cell
/// that meet in a vertex are linearly independent.)
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

/// An orthonormal basis of the columns, the first k of which span the first k of theirs.
MatrixXd orthonormal(const MatrixXd& columns) {
    return Eigen::HouseholderQR<MatrixXd>(columns).householderQ() *
           MatrixXd::Identity(columns.rows(), columns.cols());
}

/// One level further. The sums of columns are put right: their rounding would not shrink.
MatrixXd stepped(const Eigen::SparseMatrix<double>& transposed, const MatrixXd& columns) {
    MatrixXd next = transposed * columns;
    next.row(0) -= next.colwise().sum();
    return next;
}

/// The functionals of three edges, one a column, those that shrink most slowly first.
MatrixXd sortedEdges(const Eigen::SparseMatrix<double>& transposed, const EdgePlaces& places) {
    constexpr int kSteps = 16;  // Rates differ by a tenth at least, or hardly matter.
    MatrixXd edges = MatrixXd::Zero(transposed.rows(), 3);
    for (Eigen::Index k = 0; k < 3; ++k) {
        edges(0, k) = -1;  // The vertex is the first point of its ring, and its edges come next.
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

/// The direction that a functional tends to, but for a space that it has left behind.
///
/// Rounding may lead to directions that shrink more slowly than the functional itself, and grows
/// beside it (along an edge of 16 cells by 1.22 a level, while the functional settles by 0.6). So
/// the direction is taken where it changes least before it changes again.
/// \param known an orthonormal basis of a space that the matrix takes to itself
/// \return nothing if it goes on to turn
std::optional<VectorXd> limitOf(const Eigen::SparseMatrix<double>& transposed, VectorXd functional,
                                const MatrixXd& known) {
    constexpr int kMaxSteps =
        2048;  // Around an edge of 16 cells, directions settle by 0.95 a step.
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

/// An orthonormal basis of the space that the functionals of three edges tend to, over the points
/// of the ring: one after the other, or where one goes on to turn, all at once.
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
    // What turns or settles slowly does so within the space of the three.
    constexpr int kSteps = 128;
    MatrixXd basis = orthonormal(edges);
    for (int step = 0; step < kSteps; ++step) basis = orthonormal(stepped(transposed, basis));
    return basis;
}

}  // namespace

stencils::StencilTable<double> buildTangentTable(const far::TopologyRefiner& refiner, int level,
                                                 std::span<const CellCorner> corners) {
    const far::Level& here = refiner.level(level);
    std::vector<Index> vertices;
    for (const CellCorner& corner : corners) vertices.push_back(corner.vertex);
    const stencils::ShapeGroups groups = stencils::groupByShape(refiner, here, vertices);

    // Each ring that there is, with the edges that are asked for there.
    std::vector<std::map<EdgePlaces, MatrixXd>> directions(groups.firsts.size());
    const auto directionsAt = [&](const CellCorner& corner) -> MatrixXd& {
        return directions[groups.groupOf.at(corner.vertex)][edgesAt(here.complex, corner)];
    };
    for (const CellCorner& corner : corners) directionsAt(corner);
    parallelFor(std::ssize(groups.firsts), 1, [&](Offset first, Offset last) {
        for (auto group = static_cast<std::size_t>(first); std::cmp_less(group, last); ++group) {
            const VertexRing ring = ringOf(here, refiner.options(), groups.firsts[group]);
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
