// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_refiner.h>

#include <utility>

namespace espalier::far {

TopologyRefiner::TopologyRefiner(CellComplex base, const RefinerOptions& options)
    : boundary_(options.boundary) {
    Strata strata = boundary_ == Boundary::Sharp
                        ? classifySharp(base, options.sharpEdges, options.marks)
                        : classifyOpen(base);
    levels_.push_back({std::move(base), std::move(strata)});
}

void TopologyRefiner::refineUniform(int level) {
    while (maxLevel() < level) {
        const auto& [parent, strata] = levels_.back();
        const bool open = boundary_ == Boundary::Open;
        Refinement refinement(parent, open ? &strata : nullptr);
        Level next{refinement.child(),
                   open ? classifyOpen(refinement.child()) : refinement.inherit(strata)};
        refinements_.push_back(std::move(refinement));
        levels_.push_back(std::move(next));
    }
}

}  // namespace espalier::far
