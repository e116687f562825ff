// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/compare/open_subdiv_tables.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

namespace espalier::compare {

template <class Real>
OpenSubdivTable<Real>::OpenSubdivTable(const stencils::StencilTable<Real>& table)
    : columnCount_(table.columnCount()),
      indices_(table.columns().begin(), table.columns().end()),
      weights_(table.weights().begin(), table.weights().end()) {
    if (table.entryCount() > std::numeric_limits<int>::max())
        throw Error(concat("a table of ", table.entryCount(),
                           " entries is too large for OpenSubdiv, whose offsets are of 32 bits"));
    for (Index row = 0; row < table.rowCount(); ++row) {
        sizes_.push_back(static_cast<int>(table.columns(row).size()));
        offsets_.push_back(static_cast<int>(table.offsets()[row]));
    }
}

namespace {

/// Returns the position of the first entry of a row. It adds up the sizes, since GetOffsets() may
/// be omitted and GetWeights() may be longer than the indices.
template <class Real>
Offset firstEntry(const OpenSubdiv::Far::StencilTableReal<Real>& table, Index first, Index count) {
    if (first < 0 || count < 0 || first > table.GetNumStencils() - count)
        throw Error(concat("there are no rows ", first, " to ", first + count - 1,
                           " in a table of ", table.GetNumStencils()));
    const std::vector<int>& sizes = table.GetSizes();
    return std::accumulate(sizes.begin(), sizes.begin() + first, Offset{0});
}

}  // namespace

template <class Real>
OpenSubdivTable<Real>::OpenSubdivTable(const OpenSubdiv::Far::StencilTableReal<double>& table,
                                       Index first, Index count)
    : columnCount_(table.GetNumControlVertices()) {
    std::size_t entry = firstEntry(table, first, count);
    for (Index row = first; row < first + count; ++row) {
        sizes_.push_back(table.GetSizes()[row]);
        offsets_.push_back(static_cast<int>(indices_.size()));
        for (int k = 0; k < sizes_.back(); ++k, ++entry) {
            indices_.push_back(table.GetControlIndices()[entry]);
            weights_.push_back(static_cast<Real>(table.GetWeights()[entry]));
        }
    }
}

template <class Real>
stencils::StencilTable<Real> fromOpenSubdiv(const OpenSubdiv::Far::StencilTableReal<Real>& table,
                                            Index first, Index count) {
    const std::vector<int>& sizes = table.GetSizes();
    Offset at = firstEntry(table, first, count);
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    std::vector<std::pair<Index, Real>> row;
    for (Index i = first; i < first + count; ++i) {
        row.clear();
        for (int k = 0; k < sizes[i]; ++k, ++at)
            row.emplace_back(table.GetControlIndices()[at], table.GetWeights()[at]);
        std::sort(row.begin(), row.end(),
                  [](const auto& a, const auto& b) { return a.first < b.first; });
        for (const auto& [column, weight] : row) {
            if (std::ssize(columns) > offsets.back() && columns.back() == column) {
                weights.back() += weight;
                continue;
            }
            columns.push_back(column);
            weights.push_back(weight);
        }
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return stencils::StencilTable<Real>(table.GetNumControlVertices(), std::move(offsets),
                                        std::move(columns), std::move(weights));
}

template class OpenSubdivTable<float>;
template class OpenSubdivTable<double>;
template stencils::StencilTable<float> fromOpenSubdiv(
    const OpenSubdiv::Far::StencilTableReal<float>&, Index, Index);
template stencils::StencilTable<double> fromOpenSubdiv(
    const OpenSubdiv::Far::StencilTableReal<double>&, Index, Index);

}  // namespace espalier::compare
