// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <vector>

#include "superset_form.h"
#include "table_compiler.h"

namespace espalier::osd {

/// Stores the numbers of the groups of all forms, in the layout of the kernels, and sets
/// firstNumber of the groups. Groups with identical numbers share them: their rows are sorted, so
/// that the same rows have the same slot. Groups of outer products whose weights are stored, for
/// the adjoint, get the size 0.
/// \cost O(numbers + rows log rows), in parallel
template <class Real>
void storeNumbers(const stencils::StencilTable<Real>& table, NumberOrder order,
                  const kernels::Kernels<Real>& kernels, std::vector<FormBlock<Real>>& blocks,
                  AlignedVector<Real>& numbers);

}  // namespace espalier::osd
