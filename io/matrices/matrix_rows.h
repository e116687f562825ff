// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/stencils/stencil_table.h>

#include <cmath>
#include <cstdint>
#include <string>

namespace espalier::io {

/// A number of rows or columns, as a file claims it.
/// \param of "rows" or "columns"
/// \throws CodingError if a table cannot have so many
Index matrixSize(std::int64_t count, const char* of);

/// A table of the arrays of a matrix in compressed sparse rows, as programs write them: unlike in a
/// table, the columns of a row may come in any order.
///
/// \throws CodingError if they are not such a matrix, naming the first bad row, counted from 0; if
///         a column comes twice in a row, or if a weight is not finite
/// \cost   O(entries); O(entries · log entries) where they are not in order
stencils::StencilTable<double> tableOfRows(Index columnCount, Array<Offset> offsets,
                                           Array<Index> columns, Array<double> weights);

/// Refuses a table that solvers would choke on.
/// \throws Error naming the first row with a weight that is not finite
template <class Real>
void checkFinite(const stencils::StencilTable<Real>& table) {
    for (Index row = 0; row < table.rowCount(); ++row)
        for (const Real weight : table.weights(row))
            if (!std::isfinite(weight))
                throw Error(concat("row ", row, " of the table has the weight ", weight,
                                   "; only finite weights can be written"));
}

}  // namespace espalier::io
