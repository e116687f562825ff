// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/far/point.h>
#include <espalier/stencils/binding.h>
#include <espalier/stencils/factored_table.h>

#include <span>
#include <vector>

namespace espalier::osd {

/// The points of a bound model for a pose of the lattice: D · p', and the kept points where they
/// were. Table is StencilTable<Real>, or FactoredTable<Real>. For many poses: CompiledTable, and
/// CompiledChain.
///
/// \param pose positions of the base vertices
/// \throws Error if the pose is not of binding.table.columnCount() vertices
/// \cost O(entries), on all threads
/// \cite MacCracken & Joy 1996, section 5
template <class Real, class Table>
ESPALIER_API std::vector<Point3> evaluateBinding(const stencils::Binding<Real, Table>& binding,
                                                 std::span<const Point3> pose);

}  // namespace espalier::osd
