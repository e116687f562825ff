// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>

#include <utility>

#include "patch_collector.h"

namespace espalier::io {

void PatchCollector::beginGroups(std::span<const std::string> names) {
    current_.clear();
    for (const std::string& name : names) {
        const auto [at, isNew] = numbers_.try_emplace(name, patches_.size());
        if (isNew) patches_.push_back({name});
        current_.push_back(at->second);
    }
}

void PatchCollector::add(std::span<const Index> points) {
    for (const std::size_t number : current_) {
        auto& all = patches_[number].points;
        all.insert(all.end(), points.begin(), points.end());
    }
}

void PatchCollector::addFace(std::span<const Index> corners) {
    for (const std::size_t number : current_) {
        auto& faces = patches_[number].faces;
        faces.values.insert(faces.values.end(), corners.begin(), corners.end());
        faces.offsets.push_back(static_cast<Offset>(faces.values.size()));
    }
}

void PatchCollector::face(std::span<const Index> points) {
    add(points);
    addFace(points);
}

void PatchCollector::curvedCell(int dimension, std::span<const Index> points) {
    add(points);
    if (dimension == 2 && !points.empty()) addFace(points.first(points.size() == 6 ? 3 : 4));
}

std::vector<far::MeshPatch> PatchCollector::take() {
    for (far::MeshPatch& patch : patches_) sortUnique(patch.points);
    std::erase_if(patches_, [](const far::MeshPatch& patch) { return patch.points.empty(); });
    return std::move(patches_);
}

}  // namespace espalier::io
