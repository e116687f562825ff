// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/io/model.h>

#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

// Helps formats to list the attributes and the groups of their points.

namespace espalier::io {

/// Adds an attribute for each component of an array: "name" of one, "name:0", "name:1" of several.
/// \param read returns all numbers, one tuple per point
template <class Read>
void addAttributes(const std::string& name, std::size_t components,
                   std::vector<PointAttribute>& attributes, Read read) {
    for (std::size_t component = 0; component < components; ++component)
        attributes.push_back(
            {components == 1 ? name : concat(name, ":", component), [read, components, component] {
                 std::vector<double> numbers = read();
                 for (std::size_t i = 0; i < numbers.size() / components; ++i)
                     numbers[i] = numbers[components * i + component];
                 numbers.resize(numbers.size() / components);
                 return numbers;
             }});
}

/// Collects groups of points, in the order of their names in the file.
class GroupBuilder {
public:
    void add(const std::string& name, Index point) { pointsOf(name).push_back(point); }

    /// Adds the points from `first` on.
    void add(const std::string& name, Index first, Index count) {
        auto& points = pointsOf(name);
        for (Index i = 0; i < count; ++i) points.push_back(first + i);
    }

    std::vector<PointGroup> finish() {
        for (PointGroup& group : groups_) sortUnique(group.points);
        return std::move(groups_);
    }

private:
    std::vector<Index>& pointsOf(const std::string& name) {
        const auto [found, isNew] = numbers_.try_emplace(name, groups_.size());
        if (isNew) groups_.push_back({name, {}});
        return groups_[found->second].points;
    }

    std::vector<PointGroup> groups_;
    std::unordered_map<std::string, std::size_t> numbers_;
};

}  // namespace espalier::io
