// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/mesh_patch.h>

#include <map>
#include <span>
#include <string>
#include <vector>

#include "cell_visitor.h"

namespace espalier::io {

/// Collects the named groups of elements of a mesh.
class PatchCollector final : public CellVisitor {
public:
    bool wantsGroups() const override { return true; }
    void beginGroups(std::span<const std::string> names) override;
    void cell(far::StandardCell, std::span<const Index> points) override { add(points); }
    void polyhedron(std::span<const std::vector<Index>> loops) override {
        for (const auto& loop : loops) add(loop);
    }
    void face(std::span<const Index> points) override;
    void smallCell(int) override {}
    void curvedCell(int dimension, std::span<const Index> points) override;
    void unknownElement(std::size_t, const std::string&) override {}

    /// Returns the groups in the order of their first elements. This must not be used afterwards.
    std::vector<far::MeshPatch> take();

private:
    void add(std::span<const Index> points);
    void addFace(std::span<const Index> corners);

    std::vector<far::MeshPatch> patches_;
    std::map<std::string, std::size_t> numbers_;
    std::vector<std::size_t> current_;  ///< the groups of the next elements
};

}  // namespace espalier::io
