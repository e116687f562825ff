// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/composition.h>

#include "support/test.h"

// Writes the papers' formulas as they are printed. A point is a row of weights over the old
// vertices, so that (F0 + F1 + P0 + P1) / 4 is the row of an edge point.
namespace espalier::test {

using far::CellComplex;
using stencils::StencilTable;

/// A point as an affine combination of old vertices: the weight of each vertex.
struct Row {
    std::map<Index, double> weights;

    friend Row operator+(Row a, const Row& b) {
        for (const auto& [vertex, weight] : b.weights) a.weights[vertex] += weight;
        return a;
    }
    friend Row operator*(double factor, Row a) {
        for (auto& [vertex, weight] : a.weights) weight *= factor;
        return a;
    }
    friend Row operator/(Row a, double divisor) {
        for (auto& [vertex, weight] : a.weights) weight /= divisor;
        return a;
    }
    friend Row operator-(const Row& a, const Row& b) { return a + -1 * b; }
};

inline Row point(Index vertex) {
    return {{{vertex, 1}}};
}

inline Row average(const std::vector<Row>& rows) {
    Row sum;
    for (const Row& row : rows) sum = sum + row;
    return sum / double(rows.size());
}

/// Returns the average of the vertices of an entity: P, M, A or C in the papers.
inline Row centroid(const CellComplex& complex, Entity entity) {
    std::vector<Row> points;
    for (const Index vertex : complex.relation(entity.dimension, 0)[entity.index])
        points.push_back(point(vertex));
    return average(points);
}

inline Row rowOf(const stencils::StencilTable<double>& table, Index index) {
    Row row;
    for (std::size_t k = 0; k < table.columns(index).size(); ++k)
        row.weights[table.columns(index)[k]] = table.weights(index)[k];
    return row;
}

/// Substitutes the rows of the level before into a row over that level.
inline Row substituted(const Row& row, const std::vector<Row>& before) {
    Row sum;
    for (const auto& [vertex, weight] : row.weights) sum = sum + weight * before[vertex];
    return sum;
}

/// Returns the largest difference between two weights of the same vertex.
inline double difference(const Row& a, const Row& b) {
    double largest = 0;
    for (const auto& [vertex, weight] : (a - b).weights)
        largest = std::max(largest, std::abs(weight));
    return largest;
}

/// Expects that each row sums to 1, up to 1e-14 times the sum of the sizes of its weights.
inline void expectRowsSumToOne(const StencilTable<double>& table) {
    for (Index row = 0; row < table.rowCount(); ++row) {
        double sum = 0, sizes = 0;
        for (const double weight : table.weights(row)) {
            sum += weight;
            sizes += std::abs(weight);
        }
        EXPECT_NEAR(sum, 1, 1e-14 * sizes) << "row " << row;
    }
}

inline void expectRow(const Row& row, const std::map<Index, double>& expected) {
    EXPECT_EQ(row.weights.size(), expected.size());
    // The tolerance allows for about twenty rounded operations on numbers up to 1.
    EXPECT_LE(difference(row, {expected}), 1e-15);
}

/// Returns the new point of an entity of the level before.
inline Index pointOf(const far::TopologyRefiner& refiner, int level, Entity entity) {
    return refiner.refinement(level).childOf({entity, entity}).value().index;
}

/// Returns the entity of the level before whose new point is this vertex.
inline Entity parentOf(const far::TopologyRefiner& refiner, int level, Index vertex) {
    return refiner.refinement(level).parentOf({0, vertex}).upper;
}

}  // namespace espalier::test
