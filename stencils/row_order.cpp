// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/row_order.h>

#include <numeric>

namespace espalier::stencils {

RowOrder::RowOrder(std::span<const Index> groups, Index groupCount)
    : rows_(groups.size()), groups_(groups.begin(), groups.end()) {
    std::vector<Index> next(Offset{groupCount} + 1, 0);
    for (const Index group : groups) ++next[group + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::size_t row = 0; row < groups.size(); ++row)
        rows_[next[groups[row]]++] = static_cast<Index>(row);
}

BaseEntities::BaseEntities(const far::CellComplex& base) {
    for (int d = 0; d <= kMaxDimension; ++d) {
        const std::size_t at = d;
        begins_[at + 1] = begins_[at] + base.count(d);
        numbers_[at].resize(base.count(d));
        std::iota(numbers_[at].begin(), numbers_[at].end(), begins_[at]);
    }
}

Entity BaseEntities::entity(Index number) const {
    int dimension = 0;
    while (number >= begins_[dimension + 1]) ++dimension;
    return {dimension, number - begins_[dimension]};
}

void BaseEntities::refine(const far::Refinement& refinement) {
    numbers_ = refinement.inherit(numbers_);
}

std::vector<BaseEntities> baseEntities(const far::TopologyRefiner& refiner, int level) {
    std::vector<BaseEntities> result = {BaseEntities(refiner.level(0).complex)};
    for (int k = 1; k <= level; ++k) {
        result.push_back(result.back());
        result.back().refine(refiner.refinement(k));
    }
    return result;
}

}  // namespace espalier::stencils
