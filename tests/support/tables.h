// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/tensor_product.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/sparse_matrix.h>

#include <Eigen/Core>
#include <random>
#include <utility>
#include <vector>

namespace espalier::test {

using stencils::StencilTable;

using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

inline Positions asMatrix(const std::vector<Point3>& points) {
    return Eigen::Map<const Positions>(points.data()->data(), Eigen::Index(points.size()), 3);
}

/// Returns the product of a table and points.
inline Positions times(const stencils::StencilTable<double>& table,
                       const std::vector<Point3>& points) {
    return stencils::SparseView(table).matrix() * asMatrix(points);
}

inline double largestDistance(const Positions& a, const Positions& b) {
    return (a - b).rowwise().norm().maxCoeff();
}

/// Returns a table with rows of 0 to 20 entries in random columns, and with different weights.
template <class Real = double>
stencils::StencilTable<Real> randomTable(Index rowCount, Index columnCount, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<Real> weight(-1, 1);
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < rowCount; ++row) {
        std::bernoulli_distribution isThere(std::min(double(random() % 21) / columnCount, 1.0));
        for (Index column = 0; column < columnCount; ++column)
            if (isThere(random)) {
                columns.push_back(column);
                weights.push_back(weight(random));
            }
        offsets.push_back(Offset(columns.size()));
    }
    return {columnCount, std::move(offsets), std::move(columns), std::move(weights)};
}

/// Returns a table of long rows. The first two thirds share their `length` columns; each of the
/// other rows has different columns.
/// \param weightOf returns a weight for the number of its entry
template <class Real, class WeightOf>
stencils::StencilTable<Real> tableOfLongRows(Index rowCount, Index length, WeightOf weightOf) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < rowCount; ++row) {
        for (Index k = 0; k < length; ++k) {
            weights.push_back(Real(weightOf(columns.size())));
            columns.push_back(k + (3 * row < 2 * rowCount ? 0 : row));
        }
        offsets.push_back(Offset(columns.size()));
    }
    return {length + rowCount, std::move(offsets), std::move(columns), std::move(weights)};
}

/// Returns D for points in a box lattice.
inline stencils::StencilTable<double> tableOf(const embed::TensorLattice& lattice,
                                              const std::vector<Point3>& points,
                                              const embed::EmbeddingOptions& options = {}) {
    return embed::buildDeformationTable(lattice, embed::embedPoints(lattice, points, options));
}

}  // namespace espalier::test
