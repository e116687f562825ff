// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>

#include <algorithm>
#include <vector>

#include "support/rows.h"

namespace espalier::test {

/// A slow reference for the new points of RATS on a curve or a mesh: one function for each type, in
/// the words of Savva & Clapworthy, section 2, (1) to (10). The border consists of the entities of
/// strata 0 and 1.
class RatsReference {
public:
    explicit RatsReference(const far::Level& level)
        : complex_(level.complex), strata_(level.strata) {
        for (Index vertex = 0; vertex < complex_.count(0); ++vertex)
            vertexPoints_.push_back(vertexPoint(vertex));
    }

    Row newPoint(Entity entity) const {
        if (entity.dimension == 0) return newVertex(entity.index);
        return entity.dimension == 1 ? edgePoint(entity.index) : facePoint(entity.index);
    }

private:
    bool isCorner(Index vertex) const { return strata_.of({0, vertex}) == 0; }
    bool isBorderVertex(Index vertex) const { return strata_.of({0, vertex}) <= 1; }
    bool isBorderEdge(Index edge) const { return strata_.of({1, edge}) <= 1; }

    /// "New points corresponding to the old vertices": V_α at a corner, V_β on the border, V_γ
    /// inside.
    Row vertexPoint(Index vertex) const {
        if (isCorner(vertex)) return point(vertex);
        std::vector<Row> rows;
        if (isBorderVertex(vertex)) {
            for (const Index edge : complex_.relation(0, 1)[vertex])
                if (isBorderEdge(edge)) rows.push_back(centroid(complex_, {1, edge}));
        } else {
            for (const Index face : complex_.relation(0, 2)[vertex])
                rows.push_back(centroid(complex_, {2, face}));
        }
        return average(rows);
    }

    /// E_α and E_β on the border, E_γ and E_δ inside.
    Row edgePoint(Index edge) const {
        const auto ends = complex_.relation(1, 0)[edge];
        const auto meanOfNewEnds = [&] {
            return (newVertex(ends.front()) + newVertex(ends.back())) / 2;
        };
        if (isBorderEdge(edge)) {
            if (isCorner(ends.front()) || isCorner(ends.back()))
                return centroid(complex_, {1, edge});
            return meanOfNewEnds();
        }
        if (!isBorderVertex(ends.front()) && !isBorderVertex(ends.back())) return meanOfNewEnds();
        std::vector<Row> rows;
        for (const Index face : complex_.relation(1, 2)[edge])
            rows.push_back(centroid(complex_, {2, face}));
        return average(rows);
    }

    /// F_α with a corner, F_β with a border edge, otherwise F_γ.
    Row facePoint(Index face) const {
        const auto vertices = complex_.relation(2, 0)[face];
        const auto edges = complex_.relation(2, 1)[face];
        if (std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return isCorner(v); }))
            return centroid(complex_, {2, face});
        const std::size_t n = edges.size();
        std::vector<Row> rows;
        bool isAtBorder = false;
        for (std::size_t i = 0; i < n; ++i) isAtBorder = isAtBorder || isBorderEdge(edges[i]);
        if (isAtBorder) {
            // Inner edges that share a vertex with a border edge: neighbours of one in the loop, or
            // edges that meet it in a vertex that occurs twice in the loop.
            for (const Index edge : edges) {
                if (isBorderEdge(edge)) continue;
                if (std::any_of(edges.begin(), edges.end(), [&](Index other) {
                        return isBorderEdge(other) && shareVertex(edge, other);
                    })) {
                    std::vector<Row> centroids;
                    for (const Index around : complex_.relation(1, 2)[edge])
                        centroids.push_back(centroid(complex_, {2, around}));
                    rows.push_back(average(centroids));
                }
            }
            if (rows.empty()) return centroid(complex_, {2, face});
            return average(rows);
        }
        for (const Index vertex : vertices) rows.push_back(newVertex(vertex));
        return average(rows);
    }

    bool shareVertex(Index a, Index b) const {
        for (const Index end : complex_.relation(1, 0)[a])
            for (const Index other : complex_.relation(1, 0)[b])
                if (end == other) return true;
        return false;
    }

    const Row& newVertex(Index vertex) const { return vertexPoints_[vertex]; }

    const CellComplex& complex_;
    const far::Strata& strata_;
    std::vector<Row> vertexPoints_;
};

}  // namespace espalier::test
