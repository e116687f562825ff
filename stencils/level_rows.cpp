// SPDX-License-Identifier: Apache-2.0
#include "level_rows.h"

#include <espalier/stencils/composition.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "sort_unique.h"

namespace espalier::stencils {
namespace {

/// A table over some of its columns, which hold all of its entries.
/// \param columns ascending
StencilTable<double> overColumns(const StencilTable<double>& table,
                                 std::span<const Index> columns) {
    Array<Index> places(table.columns().size());
    std::transform(
        table.columns().begin(), table.columns().end(), places.begin(), [&](Index column) {
            return static_cast<Index>(std::lower_bound(columns.begin(), columns.end(), column) -
                                      columns.begin());
        });
    return StencilTable<double>(Trusted{}, static_cast<Index>(columns.size()),
                                {table.offsets().begin(), table.offsets().end()}, std::move(places),
                                {table.weights().begin(), table.weights().end()});
}

std::vector<Index> columnsOf(const StencilTable<double>& table) {
    std::vector<Index> columns(table.columns().begin(), table.columns().end());
    sortUnique(columns);
    return columns;
}

}  // namespace

template <class Real>
std::vector<StencilTable<Real>> composeRows(std::span<const StencilTable<double>> tables,
                                            std::vector<StencilTable<double>> rows) {
    // Down the levels: the vertices whose rows of S_k are asked for. Then up: these rows.
    const std::size_t last = rows.size() - 1;
    std::vector<std::vector<Index>> vertices(rows.size());
    std::vector<StencilTable<double>> steps(rows.size());  // The rows of R_k for those.
    for (std::size_t k = last;; --k) {
        const auto own = columnsOf(rows[k]);
        const auto above = k == last ? std::vector<Index>() : columnsOf(steps[k + 1]);
        std::set_union(own.begin(), own.end(), above.begin(), above.end(),
                       std::back_inserter(vertices[k]));
        if (k == 0) break;
        steps[k] = selectRows(tables[k - 1], vertices[k]);
    }
    std::vector<StencilTable<Real>> result;
    result.push_back(convertTable<Real>(std::move(rows[0])));
    StencilTable<double> stencils;
    for (std::size_t k = 1; k <= last; ++k) {
        stencils = k == 1 ? std::move(steps[1])
                          : multiply<double>(overColumns(steps[k], vertices[k - 1]), stencils);
        result.push_back(multiply<Real>(overColumns(rows[k], vertices[k]), stencils));
    }
    return result;
}

template std::vector<StencilTable<float>> composeRows(std::span<const StencilTable<double>>,
                                                      std::vector<StencilTable<double>>);
template std::vector<StencilTable<double>> composeRows(std::span<const StencilTable<double>>,
                                                       std::vector<StencilTable<double>>);

}  // namespace espalier::stencils
