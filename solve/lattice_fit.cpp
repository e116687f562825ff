// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/progress.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/stencils/sparse_matrix.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cancellable_ldlt.h"

namespace espalier::solve {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::MatrixX3d;
using stencils::StencilTable;

/// Evaluates an expression into a matrix. It does not use a constructor, because Eigen's
/// constructors leak memory if an allocation throws, and copy where a move is possible.
template <class Expression>
Matrix evaluated(const Expression& expression) {
    Matrix result;
    result = expression;
    return result;
}

/// Directions in which the squared matrix is below this fraction of its largest eigenvalue count as
/// undetermined.
constexpr double kOpen = 1e-10;

void check(const StencilTable<double>& deformation, std::span<const Point3> misses,
           const far::CellComplex& base, const FitOptions& options) {
    if (deformation.columnCount() != base.count(0))
        throw Error(concat("the points are bound to ", deformation.columnCount(),
                           " vertices; the lattice has ", base.count(0)));
    if (std::ssize(misses) != deformation.rowCount())
        throw Error(
            concat("got ", misses.size(), " targets for ", deformation.rowCount(), " points"));
    if (misses.empty()) throw Error("there are no targets");
    for (std::size_t i = 0; i < misses.size(); ++i) {
        for (const double coordinate : misses[i])
            if (!std::isfinite(coordinate))
                throw TargetError(static_cast<Index>(i),
                                  concat("the target of point ", i, " is not finite"));
        for (const double weight : deformation.weights(static_cast<Index>(i)))
            if (!std::isfinite(weight))
                throw Error(concat("point ", i, " has a weight that is not finite"));
        if (deformation.columns(static_cast<Index>(i)).empty())
            throw Error(concat("point ", i, " has a target, but lies outside the lattice"));
    }
    for (std::size_t i = 0; i < options.frozen.size(); ++i)
        if (const Index vertex = options.frozen[i]; vertex < 0 || vertex >= base.count(0))
            throw ArgumentError("", concat("frozen[", i, "]"), std::to_string(vertex),
                                concat("a vertex, 0 to ", base.count(0) - 1));
    constexpr double kLeast = 1e-4, kMax = 1e4;
    if (!(options.strength >= kLeast && options.strength <= kMax))
        throw ArgumentError("", "strength", textOf(options.strength), "0.0001 to 10000");
}

/// Throws an error that names the target farthest from its point.
[[noreturn]] void refuseFarTargets(std::span<const Point3> misses) {
    const auto size = [](const Point3& miss) {
        // Halved, since the distance itself may overflow.
        return length({miss[0] / 2, miss[1] / 2, miss[2] / 2});
    };
    const auto farthest = std::ranges::max_element(misses, {}, size);
    const auto row = static_cast<Index>(farthest - misses.begin());
    throw TargetError(row,
                      concat("the target of point ", row,
                             " is too far from the point: the square of the distance overflows"));
}

/// The vertices that may move.
struct FreeVertices {
    std::vector<Index> vertices;

    FreeVertices(Index count, std::span<const Index> frozen) {
        std::vector<char> isFree(count, 1);
        for (const Index vertex : frozen) isFree[vertex] = 0;
        for (Index vertex = 0; vertex < count; ++vertex)
            if (isFree[vertex]) vertices.push_back(vertex);
        if (vertices.empty()) throw Error("all vertices are frozen: no vertex is left to move");
    }

    Index count() const { return static_cast<Index>(vertices.size()); }

    /// Returns the columns of the free vertices.
    Matrix columnsOf(const Matrix& matrix) const {
        Matrix selection(matrix.cols(), count());
        selection.reserve(Eigen::VectorXi::Constant(count(), 1));
        for (Index i = 0; i < count(); ++i) selection.insert(vertices[i], i) = 1;
        return evaluated(matrix * selection);
    }
};

/// Returns R.
Matrix smoothing(const far::CellComplex& base, Smoothing kind) {
    const Index count = base.count(0);
    Matrix result(count, count);
    if (kind == Smoothing::None) return result;
    result.setIdentity();
    if (kind == Smoothing::Tikhonov) return result;
    std::vector<Eigen::Triplet<double>> entries;
    for (Index vertex = 0; vertex < count; ++vertex) {
        const auto edges = base.relation(0, 1)[vertex];
        for (const Index edge : edges)
            for (const Index end : base.relation(1, 0)[edge])
                if (end != vertex)
                    entries.emplace_back(vertex, end, -1.0 / static_cast<double>(edges.size()));
    }
    Matrix neighbours(count, count);
    neighbours.setFromTriplets(entries.begin(), entries.end());
    return evaluated(result + neighbours);
}

/// The normal equations of the free vertices. A small multiple of the identity is added, so that
/// they can be factored even if displacements are undetermined.
class NormalEquations {
public:
    /// \param matrix, smooth are moved from
    NormalEquations(Matrix&& matrix, Matrix&& smooth, double strength) {
        matrix_.swap(matrix);
        smooth_.swap(smooth);
        square_ = squareOf(matrix_);
        smooth_ *= strength * std::sqrt(square_.diagonal().mean());
        square_ += squareOf(smooth_);
        largest_ = largestEigenvalue();
        if (!(largest_ > 0)) throw Error("no target depends on a vertex that may move");
        Matrix identity(square_.rows(), square_.cols());
        identity.setIdentity();
        factor_.compute(evaluated(square_ + kOpen * largest_ * identity));
        if (factor_.info() != Eigen::Success)
            throw Error("the normal equations of the fit cannot be factored");
    }

    /// Solves by iterated Tikhonov regularisation: each step corrects the effect of the added
    /// identity. The residual is computed from the matrices themselves, so that squaring them costs
    /// no digits. Each change is a product with `square_`, so it has no component in undetermined
    /// directions, except by rounding. Therefore the result is the smallest solution.
    Columns solve(const Columns& right) const {
        constexpr int kMaxSteps = 100;
        Columns solution = Columns::Zero(square_.rows(), 3);
        for (int step = 0; step < kMaxSteps; ++step) {
            checkCancelled();
            const Columns left = matrix_.transpose() * (right - matrix_ * solution) -
                                 smooth_.transpose() * (smooth_ * solution);
            const Columns change = square_ * Columns(factor_.solve(Columns(factor_.solve(left))));
            solution += change;
            if (change.norm() <= std::numeric_limits<double>::epsilon() * solution.norm()) break;
        }
        return solution;
    }

    /// Approximation of the smallest eigenvalue, and its direction.
    struct SmallestEigenvalue {
        double value;
        Eigen::VectorXd direction;
    };
    SmallestEigenvalue least() const {
        Eigen::VectorXd vector = start();
        for (int step = 0; step < kPowerSteps; ++step) {
            checkCancelled();
            vector = Eigen::VectorXd(factor_.solve(vector)).normalized();
        }
        return {vector.dot(square_ * vector), vector};
    }
    double largest() const { return largest_; }

private:
    static constexpr int kPowerSteps = 200;

    /// A vector without any symmetry that could make it orthogonal to an eigenvector.
    Eigen::VectorXd start() const {
        Eigen::VectorXd vector(square_.rows());
        for (Eigen::Index i = 0; i < vector.size(); ++i)
            vector[i] = 1 + 0.5 * std::sin(static_cast<double>(i) * 1.7);
        return vector.normalized();
    }
    double largestEigenvalue() const {
        Eigen::VectorXd vector = start();
        double value = 0;
        for (int step = 0; step < kPowerSteps; ++step) {
            checkCancelled();
            vector = square_ * vector;
            value = vector.norm();
            if (value == 0) break;
            vector /= value;
        }
        return value;
    }

    Matrix matrix_, smooth_;  ///< D, and R times the strength
    Matrix square_;           ///< matrix_ᵀ matrix_ + smooth_ᵀ smooth_
    double largest_ = 0;
    CancellableLdlt factor_;
};

}  // namespace

LatticeFit fitLattice(const StencilTable<double>& deformation, std::span<const Point3> misses,
                      const far::CellComplex& base, const FitOptions& options) {
    check(deformation, misses, base, options);
    const FreeVertices free(base.count(0), options.frozen);
    const stencils::SparseView<double> view(deformation);
    const NormalEquations equations(free.columnsOf(evaluated(view.matrix())),
                                    free.columnsOf(smoothing(base, options.smoothing)),
                                    options.strength);
    LatticeFit fit;
    const auto least = equations.least();
    fit.condition = least.value > kOpen * equations.largest()
                        ? std::sqrt(equations.largest() / least.value)
                        : std::numeric_limits<double>::infinity();
    if (std::isinf(fit.condition) && options.undetermined == Undetermined::Refuse) {
        Eigen::Index most = 0;
        least.direction.cwiseAbs().maxCoeff(&most);
        throw Error(concat("the targets leave vertex ", free.vertices[static_cast<Index>(most)],
                           " of the lattice undetermined; add targets or smoothing, or take "
                           "the smallest displacements"));
    }

    Columns wanted(deformation.rowCount(), 3);
    for (std::size_t i = 0; i < misses.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            wanted(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = misses[i][c];
    const Columns solution = equations.solve(wanted);
    fit.displacements.assign(base.count(0), Point3{});
    Columns all = Columns::Zero(base.count(0), 3);
    for (Index i = 0; i < free.count(); ++i) {
        all.row(free.vertices[i]) = solution.row(i);
        for (std::size_t c = 0; c < 3; ++c)
            fit.displacements[free.vertices[i]][c] = solution(i, static_cast<Eigen::Index>(c));
    }
    const Eigen::VectorXd distances = (view.matrix() * all - wanted).rowwise().norm();
    fit.largestMiss = distances.maxCoeff();
    fit.rmsMiss = distances.norm() / std::sqrt(static_cast<double>(distances.size()));
    if (!all.allFinite() || !std::isfinite(fit.rmsMiss)) refuseFarTargets(misses);
    return fit;
}

}  // namespace espalier::solve
