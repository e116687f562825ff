// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/io/model.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

// Helps formats to list the attributes and the groups of their points.

namespace espalier::io {

/// Returns the name of a component of an array: "name" of the only one, "name:0", "name:1" of
/// several.
inline std::string nameOfComponent(const std::string& name, std::size_t component,
                                   std::size_t components) {
    return components == 1 ? name : concat(name, ":", component);
}

/// Adds an attribute for each component of an array.
/// \param unit the number of the file that stands for 1
/// \param read returns all numbers, one tuple per point
template <class Read>
void addAttributes(const std::string& name, std::size_t components, double unit,
                   PointAttribute::Kind kind, std::vector<PointAttribute>& attributes, Read read) {
    for (std::size_t component = 0; component < components; ++component)
        attributes.push_back({nameOfComponent(name, component, components),
                              [read, components, unit, component] {
                                  std::vector<double> numbers = read();
                                  const std::size_t count = numbers.size() / components;
                                  for (std::size_t i = 0; i < count; ++i)
                                      numbers[i] = numbers[components * i + component] / unit;
                                  numbers.resize(count);
                                  return numbers;
                              },
                              kind, component});
}

/// Adds an attribute for each component of an array of VTK. The first array of 3 or 4 bytes for
/// each point has the colours; such bytes are divided by 255.
/// \param kind what the file says that the array is
template <class Read>
void addVtkAttributes(const std::string& name, std::size_t components, bool areBytes,
                      PointAttribute::Kind kind, std::vector<PointAttribute>& attributes,
                      Read read) {
    const bool areColorBytes = areBytes && (components == 3 || components == 4);
    if (areColorBytes) kind = PointAttribute::Kind::Color;
    const bool isFirst =
        std::ranges::find(attributes, kind, &PointAttribute::kind) == attributes.end();
    addAttributes(name, components, areColorBytes ? 255 : 1,
                  isFirst ? kind : PointAttribute::Kind::Numbers, attributes, read);
}

/// Lists the names of groups, each once, in the order in which they are added.
/// \tparam Read makes the function that reads the points of the group of a name
template <class Read>
class GroupNames {
public:
    explicit GroupNames(Read read) : read_(std::move(read)) {}

    void add(const std::string& name) {
        if (!name.empty() && known_.insert(name).second) groups_.push_back({name, read_(name)});
    }

    std::vector<PointGroup> take() { return std::move(groups_); }

private:
    Read read_;
    std::vector<PointGroup> groups_;
    std::set<std::string> known_;
};

/// Returns the numbers of the points of a group, ascending.
inline std::vector<Index> pointsIn(const std::vector<bool>& isIn) {
    std::vector<Index> points;
    for (std::size_t i = 0; i < isIn.size(); ++i)
        if (isIn[i]) points.push_back(static_cast<Index>(i));
    return points;
}

}  // namespace espalier::io
