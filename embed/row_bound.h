// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/stencils/factored_table.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

// Keeps the weights of a point bounded: see kMaxRowSum in embedding.h.
namespace espalier::embed {

/// Returns the rows whose weights sum to more than kMaxRowSum in absolute value, ascending.
/// \cost O(entries), in parallel
ESPALIER_API std::vector<Index> unboundedRows(const stencils::StencilTable<double>& table);

/// Returns the table with some rows empty.
/// \param rows ascending
/// \cost O(entries), or nothing if there are no rows
ESPALIER_API stencils::StencilTable<double> emptyRows(stencils::StencilTable<double> table,
                                                      std::span<const Index> rows);

/// Returns the table with its unbounded rows empty.
ESPALIER_API stencils::StencilTable<double> boundRows(stencils::StencilTable<double> table);

/// Returns the factors of D with those rows of W empty whose rows of D would be unbounded. Computes
/// the rows of D only for points that may have one: those far outside.
ESPALIER_API stencils::FactoredTable<double> boundRows(stencils::FactoredTable<double> table);

}  // namespace espalier::embed
