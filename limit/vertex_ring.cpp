// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/star.h>
#include <espalier/limit/vertex_ring.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/levels.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

namespace espalier::limit {
namespace {

using Extent = far::TopologyRefiner::Extent;

/// Returns the entities that contain a vertex, by dimension and number. Children [v, x] have the
/// same order as their parents x, so the order is the same on the next level.
std::vector<Entity> entitiesAt(const far::CellComplex& complex, Index vertex) {
    std::vector<Entity> entities;
    for (int d = 0; d <= complex.dimension(); ++d)
        for (const Index index : complex.relation(0, d)[vertex]) entities.push_back({d, index});
    return entities;
}

bool hasSemiSharp(const far::Level& level, Index vertex) {
    const auto edges = level.complex.relation(0, 1)[vertex];
    return far::isSemiSharp(level.strata.sharpness({0, vertex})) ||
           std::any_of(edges.begin(), edges.end(), [&](Index edge) {
               return far::isSemiSharp(level.strata.sharpness({1, edge}));
           });
}

/// Returns the eigenvalues of a matrix, from its real Schur form T: T has the eigenvalues on its
/// diagonal, and for a pair of conjugate ones a block of 2 × 2 there. (Eigen's EigenSolver also
/// computes vectors. It takes seconds to compile even if no vectors are wanted.)
std::vector<std::complex<double>> eigenvaluesOf(const Eigen::MatrixXd& matrix) {
    using Eigen::MatrixXd;
    const MatrixXd hessenberg = Eigen::HessenbergDecomposition<MatrixXd>(matrix).matrixH();
    Eigen::RealSchur<MatrixXd> schur(matrix.rows());
    schur.computeFromHessenberg(hessenberg, MatrixXd(), false);
    if (schur.info() != Eigen::Success)
        throw Error("the eigenvalues of a matrix of " + std::to_string(matrix.rows()) +
                    " rows do not converge");
    const MatrixXd& t = schur.matrixT();
    std::vector<std::complex<double>> values;
    for (Eigen::Index i = 0; i < t.rows(); ++i) {
        if (i + 1 == t.rows() || t(i + 1, i) == 0) {
            values.emplace_back(t(i, i));
        } else {
            const double half = (t(i, i) - t(i + 1, i + 1)) / 2, middle = t(i + 1, i + 1) + half;
            const double imaginary = std::sqrt(std::abs(half * half + t(i + 1, i) * t(i, i + 1)));
            values.emplace_back(middle, imaginary);
            values.emplace_back(middle, -imaginary);
            ++i;
        }
    }
    return values;
}

/// A star that is refined around its vertex.
struct Chain {
    stencils::Levels levels;
    Index vertex;  ///< child of the vertex of the first level

    const far::Level& level() const { return levels.finestLevel(); }
    const far::Refinement& refinement() const {
        return levels.refiner().refinement(levels.finest());
    }

    void refine(Extent extent) {
        const far::CellComplex complex = level().complex;
        levels.refineAround(complex.relation(0, complex.dimension())[vertex], extent);
        const Entity parent{0, vertex};
        vertex = refinement().childOf({parent, parent})->index;
    }

    /// Returns the ring of the vertex: the new points of `entities`, which contain the vertex of
    /// the level before.
    std::vector<Index> ring(const std::vector<Entity>& entities) const {
        std::vector<Index> points;
        for (const Entity& entity : entities)
            points.push_back(refinement().childOf({entity, entity})->index);
        return points;
    }
};

/// Converts a table to a matrix with `columnCount` columns; placeOf(column) maps columns.
template <class PlaceOf>
Eigen::SparseMatrix<double> matrixOf(const stencils::StencilTable<double>& rows,
                                     Eigen::Index columnCount, PlaceOf placeOf) {
    std::vector<Eigen::Triplet<double>> entries;
    for (Index row = 0; row < rows.rowCount(); ++row)
        for (std::size_t k = 0; k < rows.columns(row).size(); ++k)
            entries.emplace_back(row, placeOf(rows.columns(row)[k]), rows.weights(row)[k]);
    Eigen::SparseMatrix<double> matrix(rows.rowCount(), columnCount);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

/// The ring of a vertex that no other entity contains: the vertex does not move.
VertexRing loneRing(Index vertex) {
    VertexRing ring{{{0, vertex}}, Eigen::SparseMatrix<double>(1, 1), {vertex}, {}};
    ring.subdivision.insert(0, 0) = 1;
    ring.start = ring.subdivision;
    return ring;
}

}  // namespace

std::vector<Index> verticesAround(const far::CellComplex& complex, Index vertex) {
    std::vector<Index> vertices;
    for (const Entity& entity : entitiesAt(complex, vertex)) {
        const auto corners = complex.relation(entity.dimension, 0)[entity.index];
        vertices.insert(vertices.end(), corners.begin(), corners.end());
    }
    sortUnique(vertices);
    return vertices;
}

VertexRing ringOf(const far::Level& level, const far::RefinerOptions& options, Index vertex) {
    if (options.rules == far::Rules::Rats)
        throw Error(
            "limits are not known under the rules of RATS, which look beyond the ring of a vertex");
    const far::Star star =
        far::starOf(level, {&vertex, 1}, far::ringsAround(level, options.creasing));
    if (level.strata.isOpen({0, vertex}))
        throw Error("vertex " + std::to_string(vertex) +
                    " is on the open boundary, and has no limit");
    const int dimension = level.complex.dimension();
    if (level.complex.relation(0, dimension)[vertex].empty()) return loneRing(vertex);

    Chain chain{stencils::Levels(far::TopologyRefiner(star.level, options)),
                indexIn(star.entities[0], vertex)};
    std::vector<Entity> entities;
    do {
        entities = entitiesAt(chain.level().complex, chain.vertex);
        chain.refine(Extent::Ring);
    } while (hasSemiSharp(chain.level(), chain.vertex));
    const std::vector<Index> first = chain.ring(entities);

    VertexRing ring;
    ring.entities = entitiesAt(level.complex, vertex);
    ring.vertices = verticesAround(level.complex, vertex);
    ring.levels = chain.levels.finest();
    const auto rows = chain.levels.stencils(first);
    ring.start = matrixOf(rows, std::ssize(ring.vertices), [&](Index column) {
        return indexIn(ring.vertices, star.entities[0][column]);
    });

    entities = entitiesAt(chain.level().complex, chain.vertex);
    chain.refine(Extent::Cells);
    const auto next = stencils::selectRows(chain.levels.tables().back(), chain.ring(entities));
    // New points are numbered by the dimension and number of their entities, so the ring is
    // ascending.
    ring.subdivision =
        matrixOf(next, std::ssize(first), [&](Index column) { return indexIn(first, column); });
    return ring;
}

Eigen::VectorXd limitMask(const VertexRing& ring) {
    // Under Catmull-Clark rules the second eigenvalue is at most about 0.65, so that 90 steps
    // converge to rounding. After many more steps the eigenvalue must be 1.
    constexpr int kMaxSteps = 4096;
    constexpr double kNearlySettled = 1e-12;
    const Eigen::SparseMatrix<double> transposed = ring.subdivision.transpose();
    Eigen::VectorXd mask = Eigen::VectorXd::Unit(transposed.rows(), 0);
    int last = kMaxSteps;
    for (int step = 0; step < last; ++step) {
        Eigen::VectorXd next = transposed * mask;
        next /= next.sum();
        // The same number of steps again squares the remaining error.
        if (last == kMaxSteps && (next - mask).lpNorm<Eigen::Infinity>() <= kNearlySettled)
            last = std::min(2 * step + 1, kMaxSteps - 1);
        mask = std::move(next);
    }
    // At a corner or a sharp edge, the weights of other vertices converge to 0 without reaching it.
    constexpr double kNothing = 1e-20;
    if (last < kMaxSteps) return (mask.array().abs() < kNothing).select(0, mask);
    throw Error("the rules do not converge at vertex " +
                std::to_string(ring.entities.front().index));
}

std::vector<std::complex<double>> eigenvalues(const VertexRing& ring) {
    if (ring.subdivision.rows() > kMaxEigenvalues)
        throw Error("the ring of vertex " + std::to_string(ring.entities.front().index) + " has " +
                    std::to_string(ring.subdivision.rows()) +
                    " points; eigenvalues are computed of at most " +
                    std::to_string(kMaxEigenvalues));
    std::vector<std::complex<double>> values = eigenvaluesOf(Eigen::MatrixXd(ring.subdivision));
    std::stable_sort(values.begin(), values.end(),
                     [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
    return values;
}

}  // namespace espalier::limit
