// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/topology_refiner.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace espalier::far {

TopologyRefiner::TopologyRefiner(CellComplex base, const RefinerOptions& options)
    : options_(options) {
    Strata strata = classify(base, options.boundary, options.sharpEdges, options.marks);
    std::vector<Index> holes = readHoles(base, options.marks);
    levels_.push_back({std::move(base), std::move(strata), std::move(holes)});
}

namespace {

/// The entities that are lower ends of children: those that are not on the open boundary. Nothing
/// where all are.
std::optional<ByEntity<std::uint8_t>> keptEntities(const Level& parent, Boundary boundary) {
    if (boundary != Boundary::Open) return std::nullopt;
    ByEntity<std::uint8_t> kept;
    for (int d = 0; d <= parent.complex.dimension(); ++d)
        for (Index index = 0; index < parent.complex.count(d); ++index)
            kept[static_cast<std::size_t>(d)].push_back(!parent.strata.isOpen({d, index}));
    return kept;
}

/// The children [v, f] of the holes.
std::vector<Index> refineHoles(const Level& parent, const Refinement& refinement) {
    std::vector<Index> holes;
    if (parent.holes.empty()) return holes;
    refinement.forEachChild(0, 2, [&](const Entity& child, const Interval& interval) {
        if (std::binary_search(parent.holes.begin(), parent.holes.end(), interval.upper.index))
            holes.push_back(child.index);
    });
    return holes;
}

}  // namespace

void TopologyRefiner::refineUniform(int level) {
    while (maxLevel() < level) {
        const Level& parent = levels_.back();
        const auto kept = keptEntities(parent, boundary());
        Refinement refinement(parent.complex, kept ? &*kept : nullptr);
        Level next{
            refinement.child(),
            refineStrata(parent.complex, parent.strata, refinement, boundary(), options_.creasing),
            refineHoles(parent, refinement)};
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
