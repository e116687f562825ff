// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/limit/limit_parts.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <string>

#include "limit_place.h"

namespace espalier::limit {

struct LimitParts::Refined {
    stencils::Levels levels;
    std::vector<LimitPart> parts = {};
    std::vector<embed::TricubicPatch> patches = {};
    std::vector<Index> blended = {};  ///< vertices of blended cells on the last level, ascending
    stencils::StencilTable<double> limits = {};  ///< a row for each vertex of `blended`
};

namespace {

/// Returns the children of `parents` on the last level. `parents` are cells of the level before,
/// ascending.
std::vector<LimitPart> childrenOf(const far::TopologyRefiner& refiner,
                                  const std::vector<LimitPart>& parents) {
    const int level = refiner.maxLevel();
    const far::Refinement& refinement = refiner.refinement(level);
    std::vector<LimitPart> children;
    for (Index cell = 0; cell < refiner.level(level).complex.count(3); ++cell) {
        const Index parent = refinement.parentOf({3, cell}).upper.index;
        const auto found = std::lower_bound(
            parents.begin(), parents.end(), parent,
            [](const LimitPart& part, Index wanted) { return part.cell < wanted; });
        if (found != parents.end() && found->cell == parent)
            children.push_back({found->baseCell, level, cell});
    }
    return children;
}

std::vector<Index> cellsOf(const std::vector<LimitPart>& parts) {
    std::vector<Index> cells;
    for (const LimitPart& part : parts) cells.push_back(part.cell);
    return cells;
}

}  // namespace

LimitParts::LimitParts(const far::TopologyRefiner& base, int level) {
    if (base.dimension() != 3)
        throw Error("only lattices have a limit volume, not a complex of dimension " +
                    std::to_string(base.dimension()));
    if (level < 1 || level > kMaxLevelOfParts)
        throw ArgumentError("", "level", std::to_string(level),
                            concat("1 to ", kMaxLevelOfParts, " to refine irregular features"));
    auto refined = std::make_shared<Refined>(
        Refined{stencils::Levels(far::TopologyRefiner(base.level(0), base.options()))});
    stencils::Levels& levels = refined->levels;
    std::vector<LimitPart> left;
    for (Index cell = 0; cell < base.level(0).complex.count(3); ++cell)
        left.push_back({cell, 0, cell});
    for (int k = 0;; ++k) {
        const far::Level& here = levels.finestLevel();
        std::vector<LimitPart> irregular;
        for (const LimitPart& part : left) {
            checkCancelledEvery(part.cell, 8);
            if (!embed::remainsInLimit(here, part.cell)) continue;
            if (embed::isRegularCell(here, part.cell)) {
                refined->parts.push_back(part);
                refined->patches.emplace_back(here, *embed::frameOf(here.complex, part.cell));
            } else {
                irregular.push_back(part);
            }
        }
        left = std::move(irregular);
        if (left.empty() || k == level) break;
        levels.refineAround(cellsOf(left));
        left = childrenOf(levels.refiner(), left);
    }
    // If everything shrank away there is no next level: refineUniform() throws and says why.
    if (left.empty() && refined->parts.empty())
        far::TopologyRefiner(base.level(0), base.options()).refineUniform(1);
    for (const LimitPart& part : left) {
        const auto vertices = levels.finestLevel().complex.relation(3, 0)[part.cell];
        refined->blended.insert(refined->blended.end(), vertices.begin(), vertices.end());
    }
    sortUnique(refined->blended);
    if (!left.empty()) refined->limits = blendedRows(levels, levels.finest(), refined->blended);
    refined->parts.insert(refined->parts.end(), left.begin(), left.end());
    refined_ = std::move(refined);
}

const far::CellComplex& LimitParts::base() const {
    return refined_->levels.refiner().level(0).complex;
}

std::span<const LimitPart> LimitParts::parts() const {
    return refined_->parts;
}

std::size_t LimitParts::patchCount() const {
    return refined_->patches.size();
}

const far::CellComplex& LimitParts::lastLevel() const {
    return refined_->levels.finestLevel().complex;
}

LimitPositions LimitParts::place(std::span<const Point3> positions) const {
    if (std::ssize(positions) != base().count(0))
        throw Error("got " + std::to_string(positions.size()) + " positions for " +
                    std::to_string(base().count(0)) + " vertices");
    LimitPositions result{{{positions.begin(), positions.end()}}, {}};
    for (const stencils::StencilTable<double>& table : refined_->levels.tables())
        result.levels.push_back(stencils::applyLevelTable(table, result.levels.back()));
    result.limits = result.levels.back();
    if (refined_->blended.empty()) return result;
    const auto limits = stencils::applyLevelTable(refined_->limits, result.levels.back());
    for (std::size_t i = 0; i < limits.size(); ++i) result.limits[refined_->blended[i]] = limits[i];
    return result;
}

BezierPatch LimitParts::bezierPatch(std::size_t patch, const LimitPositions& positions) const {
    const auto control =
        refined_->patches[patch].controlPoints(positions.levels[refined_->parts[patch].level]);
    const auto bezier = embed::bezierPoints(control);
    BezierPatch result;
    for (std::size_t i = 0; i < 64; ++i) {
        result.points[i] = {bezier[i][0], bezier[i][1], bezier[i][2]};
        result.largestCoordinate =
            std::max(result.largestCoordinate, control[i].lpNorm<Eigen::Infinity>());
    }
    return result;
}

}  // namespace espalier::limit
