// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <string>

#include "arguments.h"

namespace espalier::c {

/// Calls `use` with some rows of a table; with the table itself where `rows` is null.
/// \param count of rows; where `rows` is null it must be the number of rows of the table
/// \param what the rows are for: "targets"
/// \throws Error naming a row that is not there
template <class Use>
auto withRows(const stencils::StencilTable<double>& table, std::int32_t count,
              const std::int32_t* rows, const char* what, const Use& use) {
    if (rows == nullptr) {
        checkCount(count, table.rowCount(), what);
        return use(table);
    }
    const auto some = array(rows, count, "rows");
    for (const std::int32_t row : some)
        if (row < 0 || row >= table.rowCount())
            throw Error("rows: there is no row " + std::to_string(row) + " among " +
                        std::to_string(table.rowCount()));
    return use(stencils::selectRows(table, some));
}

}  // namespace espalier::c
