// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>
#include <opensubdiv/far/stencilTable.h>

#include <vector>

namespace espalier::compare {

/// A table in the form that OpenSubdiv's evaluators take: it models STENCIL_TABLE of the templates
/// Osd::CpuEvaluator::EvalStencils and the like. (Only OpenSubdiv's factories can make a
/// Far::StencilTable.)
template <class Real>
class ESPALIER_API OpenSubdivTable {
public:
    /// Copies one of our tables.
    /// \throws Error if the table has more entries than OpenSubdiv's offsets can count (2³¹ − 1)
    /// \cost O(entries)
    explicit OpenSubdivTable(const stencils::StencilTable<Real>& table);

    /// Copies rows `first` to `first` + `count` − 1 of one of OpenSubdiv's tables in double
    /// precision, in the same order, with rounded weights.
    /// \throws Error if the table does not have these rows
    OpenSubdivTable(const OpenSubdiv::Far::StencilTableReal<double>& table, Index first,
                    Index count);

    // OpenSubdiv's names.
    int GetNumStencils() const { return static_cast<int>(sizes_.size()); }
    int GetNumControlVertices() const { return columnCount_; }
    const std::vector<int>& GetSizes() const { return sizes_; }
    const std::vector<int>& GetOffsets() const { return offsets_; }
    const std::vector<int>& GetControlIndices() const { return indices_; }
    const std::vector<Real>& GetWeights() const { return weights_; }

private:
    int columnCount_;
    std::vector<int> sizes_, offsets_, indices_;
    std::vector<Real> weights_;
};

/// Converts rows `first` to `first` + `count` − 1 of one of OpenSubdiv's tables, with ascending
/// columns. If a control vertex occurs twice in a row, its weights are added.
///
/// \throws Error if the table does not have these rows
/// \cost O(entries of the table)
template <class Real>
ESPALIER_API stencils::StencilTable<Real> fromOpenSubdiv(
    const OpenSubdiv::Far::StencilTableReal<Real>& table, Index first, Index count);

}  // namespace espalier::compare
