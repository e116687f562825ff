// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>
#include <espalier/stencils/levels.h>

#include <utility>

namespace espalier::stencils {

Levels::Levels(far::TopologyRefiner refiner, std::vector<Point3> positions)
    : refiner_(std::move(refiner)) {
    positions_.push_back(std::move(positions));
}

void Levels::refineAround(std::span<const Index> cells, far::TopologyRefiner::Extent extent) {
    refiner_.refineAround(cells, extent);
    tables_.push_back(buildLevelTable(refiner_, finest()));
    if (positions_.front().empty()) return;
    positions_.push_back(applyLevelTable(tables_.back(), positions_.back()));
}

StencilTable<double> Levels::stencils(std::span<const Index> vertices) const {
    return composeStencils(refiner_, tables_, vertices);
}

}  // namespace espalier::stencils
