// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "cell_visitor.h"

namespace espalier::io {

/// Builds a complex from the cells of a volume. Skips and counts all others.
class LatticeCells final : public CellVisitor {
public:
    LatticeCells(std::filesystem::path path, Index pointCount);

    // All throw TopologyError, with the path in its message.
    void cell(far::StandardCell kind, std::span<const Index> points) override;
    void polyhedron(std::span<const std::vector<Index>> loops) override;
    void face(std::span<const Index>) override { ++skipped_[2]; }
    void smallCell(int dimension, std::span<const Index>) override { ++skipped_[dimension]; }

    /// \throws FileError if the cell is of dimension 3
    void curvedCell(int dimension, std::span<const Index> points) override;

    /// \throws FileError with the line and the cause
    void unknownElement(std::size_t line, const std::string& cause) override;

    /// Returns the numbers of skipped cells, by dimension.
    const std::array<Index, 3>& skipped() const { return skipped_; }

    /// Returns the builder with the cells. This must not be used afterwards.
    /// \throws TopologyError (EmptyComplex) if all cells were skipped
    far::ComplexBuilder takeBuilder();

private:
    std::filesystem::path path_;
    far::ComplexBuilder builder_;
    Index cellCount_ = 0;
    std::array<Index, 3> skipped_ = {};
};

}  // namespace espalier::io
