// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "layered_edge.h"

namespace espalier::limit {

/// Finds points on the limits of the irregular edges of some cells: the edges inside the lattice
/// that have other than four cells around them.
///
/// An edge belongs to the first of the cells around it, among all cells of the level. So each edge
/// is tested once for a point on it, which has all these cells as candidates, and the result does
/// not depend on other points.
class EdgeSearch {
public:
    /// \param level, positions, refinements must outlive this
    /// \param positions of the vertices of the level
    /// \param distance within which a point counts as on the limit of an edge
    EdgeSearch(const far::Level& level, std::span<const Point3> positions,
               const EdgeRefinements& refinements, double distance)
        : level_(level), positions_(positions), refinements_(refinements), distance_(distance) {}

    /// Adds an irregular cell.
    /// \param i number of the cell in find(), larger than the numbers of the cells before
    void add(std::size_t i, Index cell);

    /// Returns the rows of the place of a point on an edge of cell i. Null if the point is not on
    /// the limit of an edge of the cell, the edge is not layered, or its limit is so far from its
    /// vertices that the search misses it.
    std::shared_ptr<const EdgeRows> find(std::size_t i, const Eigen::Vector3d& point) {
        if (i + 1 >= starts_.size()) return nullptr;
        for (std::size_t k = starts_[i]; k < starts_[i + 1]; ++k)
            if (edges_[k].isNear(point))
                if (auto rows = findOn(edges_[k].edge, point)) return rows;
        return nullptr;
    }

private:
    class Chord {
    public:
        Chord(Index number, const Eigen::Vector3d& from, const Eigen::Vector3d& to)
            : edge(number),
              middle_((from + to) / 2),
              direction_((to - from).normalized()),
              length_((to - from).norm()) {}

        /// True if the limit of the edge may pass through a point. The limit may be farther from
        /// the edge than a fraction of its length; the edges of further levels are nearer to it.
        bool isNear(const Eigen::Vector3d& point) const {
            constexpr double kNear = 0.25;
            const Eigen::Vector3d away = point - middle_;
            const double along = away.dot(direction_), reach = kNear * length_;
            return away.squaredNorm() - along * along <= reach * reach &&
                   std::abs(along) <= length_ / 2 + reach;
        }

        Index edge;

    private:
        Eigen::Vector3d middle_, direction_;
        double length_;
    };

    struct LayeredEdge {
        const EdgeRefinement* refinement;
        std::vector<Index> layers;
        EdgeRefinement::ControlPoints points;
    };

    std::shared_ptr<const EdgeRows> findOn(Index edge, const Eigen::Vector3d& point);
    std::optional<LayeredEdge> layered(Index edge) const;

    const far::Level& level_;
    std::span<const Point3> positions_;
    const EdgeRefinements& refinements_;
    double distance_;
    std::vector<std::size_t> starts_;  ///< edges starts_[i] to starts_[i + 1] − 1 belong to cell i
    std::vector<Chord> edges_;
    std::map<Index, std::optional<LayeredEdge>> layered_;  ///< the edges that some point is near
};

}  // namespace espalier::limit
