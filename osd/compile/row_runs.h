// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "table_compiler.h"

#include <vector>

namespace espalier::osd {

/// Puts rows into runs of one length, each with columns of its own: those of the same weights
/// together, which the run then has once, as rows of one mask have; and the others.
///
/// \param rows some rows of `table`
/// \param compiled a table without runs
/// \cost O(entries + rows log rows)
template <class Real>
void addRuns(const stencils::StencilTable<Real>& table, std::vector<Index> rows,
             CompiledRows<Real>& compiled);

}  // namespace espalier::osd
