// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>

#include <array>

namespace espalier::stencils {

/// Tells for each vertex of a level which entity of the level before it is the new point of.
class VertexParents {
public:
    /// \param level 1 to refiner.maxLevel()
    VertexParents(const far::TopologyRefiner& refiner, int level)
        : refinement_(refiner.refinement(level)), count_(refinement_.child().count(0)) {
        const far::CellComplex& parent = refiner.level(level - 1).complex;
        for (int d = 0; d <= kMaxDimension; ++d) begins_[d + 1] = begins_[d] + parent.count(d);
        isWhole_ = begins_.back() == count_;
    }

    /// Number of vertices.
    Index count() const { return count_; }

    Entity operator()(Index vertex) const {
        // Vertices are numbered by the dimension and number of their parents. Without boundary
        // control, or on a level that is not uniform, some entities have no new point.
        if (!isWhole_) return refinement_.parentOf({0, vertex}).upper;
        int dimension = 0;
        while (vertex >= begins_[dimension + 1]) ++dimension;
        return {dimension, static_cast<Index>(vertex - begins_[dimension])};
    }

private:
    const far::Refinement& refinement_;
    Index count_;
    std::array<Offset, kMaxDimension + 2> begins_ = {};
    bool isWhole_;
};

}  // namespace espalier::stencils
