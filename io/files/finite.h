// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/stencils/stencil_table.h>

#include <cmath>
#include <string>

namespace espalier::io {

/// Refuses a table that solvers would choke on.
/// \throws Error naming the first row with a weight that is not finite
template <class Real>
void checkFinite(const stencils::StencilTable<Real>& table) {
    for (Index row = 0; row < table.rowCount(); ++row)
        for (const Real weight : table.weights(row))
            if (!std::isfinite(weight))
                throw Error("row " + std::to_string(row) + " of the table has a weight of " +
                            std::to_string(weight) + "; matrices are written of finite weights");
}

}  // namespace espalier::io
