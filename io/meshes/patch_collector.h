// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/simulation_mesh.h>

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace espalier::io {

/// Collects the named groups of the elements of a mesh.
class PatchCollector {
public:
    /// The next elements belong to these groups.
    void begin(std::span<const std::string> names);

    /// Adds the points of an element.
    void add(int dimension, std::span<const Index> points);

    /// Adds the corners of a face.
    void addFace(std::span<const Index> corners);

    /// Adds the points of a line, its two ends first.
    void addLine(std::span<const Index> points);

    /// Adds images of the points of a group in its partner. A group has one partner, the first one;
    /// images in others are left out.
    void addImages(const std::string& name, const std::string& partner,
                   std::span<const std::array<Index, 2>> images);

    /// Returns the groups that have points, in the order in which they began. This must not be used
    /// afterwards.
    std::vector<far::MeshPatch> take();

private:
    /// The points of a group: first as a list with duplicates, and from a certain length on as one
    /// bit for each point of the mesh.
    struct Points {
        std::vector<Index> list;
        std::vector<bool> bits;
    };

    std::vector<far::MeshPatch> patches_;
    std::vector<Points> points_;  ///< of each patch
    std::map<std::string, Index> numbers_;
    std::vector<Index> current_;  ///< the groups of the next elements
    Index largestPoint_ = 0;
};

}  // namespace espalier::io
