// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/stencils/stencil_table.h>

#include <cmath>
#include <cstdint>
#include <string>

namespace espalier::io {

/// Converts a number of rows or columns of a file to Index.
/// \param of "rows" or "columns"
/// \throws CodingError if the number is negative or too large for a table
Index matrixSize(std::int64_t count, const char* of);

/// Builds a table from a matrix in compressed sparse rows. Unlike in a table, the columns of a row
/// may be in any order.
///
/// \throws CodingError if the arrays are not such a matrix, naming the first bad row, counted from
///         0; if a row has duplicate columns, or a weight is not finite
/// \cost O(entries); O(entries · log entries) if columns are not in order
stencils::StencilTable<double> tableOfRows(Index columnCount, Array<Offset> offsets,
                                           Array<Index> columns, Array<double> weights);

/// Throws if a table cannot be used in a solver.
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
