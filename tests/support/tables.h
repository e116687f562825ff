// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/tensor_product.h>
#include <espalier/stencils/sparse_matrix.h>

#include <Eigen/Core>
#include <random>
#include <utility>
#include <vector>

namespace espalier::test {

using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

inline Positions asMatrix(const std::vector<Point3>& points) {
    return Eigen::Map<const Positions>(points.data()->data(),
                                       static_cast<Eigen::Index>(points.size()), 3);
}

/// Table times points.
inline Positions times(const stencils::StencilTable<double>& table,
                       const std::vector<Point3>& points) {
    return stencils::SparseView(table).matrix() * asMatrix(points);
}

inline double largestDistance(const Positions& a, const Positions& b) {
    return (a - b).rowwise().norm().maxCoeff();
}

/// Points moved by up to `size` in each coordinate.
inline std::vector<Point3> shaken(std::vector<Point3> points, unsigned seed, double size = 0.5) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> move(-size, size);
    for (Point3& point : points)
        for (double& coordinate : point) coordinate += move(random);
    return points;
}

/// A table of long rows: the first two thirds share their `length` columns, each row of the rest
/// has its own.
/// \param weightOf a weight by the number of the entry
template <class Real, class WeightOf>
stencils::StencilTable<Real> tableOfLongRows(Index rowCount, Index length, WeightOf weightOf) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < rowCount; ++row) {
        for (Index k = 0; k < length; ++k) {
            weights.push_back(static_cast<Real>(weightOf(columns.size())));
            columns.push_back(k + (3 * row < 2 * rowCount ? 0 : row));
        }
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return {length + rowCount, std::move(offsets), std::move(columns), std::move(weights)};
}

/// D of a box lattice.
inline stencils::StencilTable<double> tableOf(const embed::TensorLattice& lattice,
                                              const std::vector<Point3>& points,
                                              const embed::EmbeddingOptions& options = {}) {
    return embed::buildDeformationTable(lattice, embed::embedPoints(lattice, points, options));
}

}  // namespace espalier::test
