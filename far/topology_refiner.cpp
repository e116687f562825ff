// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/topology_refiner.h>

#include <string>
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

namespace {

void checkLevel(int level, int least, int most) {
    if (level < least || level > most)
        throw Error("there is no level " + std::to_string(level) + " here: levels " +
                    std::to_string(least) + " to " + std::to_string(most) + " have been refined");
}

}  // namespace

const Level& TopologyRefiner::level(int level) const {
    checkLevel(level, 0, maxLevel());
    return levels_[static_cast<std::size_t>(level)];
}

const Refinement& TopologyRefiner::refinement(int level) const {
    checkLevel(level, 1, maxLevel());
    return refinements_[static_cast<std::size_t>(level) - 1];
}

}  // namespace espalier::far
