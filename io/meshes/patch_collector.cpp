// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>

#include <algorithm>
#include <utility>

#include "cell_visitor.h"
#include "patch_collector.h"

namespace espalier::io {

std::string nameOfGroup(int dimension, std::string_view number) {
    return concat(dimension == 1 ? "line " : dimension == 2 ? "surface " : "volume ", number);
}

void PatchCollector::begin(std::span<const std::string> names) {
    current_.clear();
    for (const std::string& name : names) {
        const auto [at, isNew] = numbers_.try_emplace(name, static_cast<Index>(patches_.size()));
        if (isNew) {
            patches_.push_back({name});
            points_.emplace_back();
        }
        current_.push_back(at->second);
    }
    sortUnique(current_);
}

void PatchCollector::add(int dimension, std::span<const Index> points) {
    for (const Index point : points) largestPoint_ = std::max(largestPoint_, point);
    for (const Index number : current_) {
        patches_[number].dimension = std::max(patches_[number].dimension, dimension);
        auto& [list, bits] = points_[number];
        // Many small groups must not have bits for all points, and a large group not a long list.
        constexpr Index kShort = 1024, kPointsOfAnEntry = 64;
        if (bits.empty() &&
            std::cmp_greater(list.size(), std::max(kShort, largestPoint_ / kPointsOfAnEntry))) {
            bits.resize(std::size_t(largestPoint_) + 1);
            for (const Index point : std::exchange(list, {})) bits[point] = true;
        }
        for (const Index point : points) {
            // A point that does not exist is an error of the cells.
            if (point < 0) continue;
            if (bits.empty()) {
                list.push_back(point);
                continue;
            }
            if (std::cmp_greater_equal(point, bits.size()))
                bits.resize(std::max(std::size_t(point) + 1, 2 * bits.size()));
            bits[point] = true;
        }
    }
}

void PatchCollector::addFace(std::span<const Index> corners) {
    for (const Index number : current_) patches_[number].faces.push(corners);
}

void PatchCollector::addLine(std::span<const Index> points) {
    for (const Index number : current_) patches_[number].lines.push(points);
}

void PatchCollector::addImages(const std::string& name, const std::string& partner,
                               std::span<const std::array<Index, 2>> images) {
    const auto found = numbers_.find(name);
    if (found == numbers_.end() || !numbers_.contains(partner)) return;
    far::MeshPatch& patch = patches_[found->second];
    if (patch.partner.empty()) patch.partner = partner;
    if (patch.partner == partner)
        patch.images.insert(patch.images.end(), images.begin(), images.end());
}

std::vector<far::MeshPatch> PatchCollector::take() {
    for (std::size_t number = 0; number < patches_.size(); ++number) {
        auto& [list, bits] = points_[number];
        sortUnique(list);
        for (std::size_t point = 0; point < bits.size(); ++point)
            if (bits[point]) list.push_back(static_cast<Index>(point));
        patches_[number].points = std::move(list);
    }
    std::erase_if(patches_, [](const far::MeshPatch& patch) { return patch.points.empty(); });
    return std::move(patches_);
}

}  // namespace espalier::io
