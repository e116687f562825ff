// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <utility>

namespace espalier::stencils {

/// A deformation table that is not multiplied out: D = points · vertices, so that a pose moves the
/// vertices of the refined lattice first, and these the points.
///
/// Where cells of the level hold several points each, that is less to keep and less to do: a row
/// of `points` has 8 entries, one of D up to 64. Where each point has a cell of its own it is more,
/// since each brings eight rows of `vertices`. entryCount() against that of D tells.
///
/// osd::CompiledChain evaluates it.
///
/// \cite MacCracken & Joy 1996, section 5
template <class Real>
struct ESPALIER_API FactoredTable {
    using Weight = Real;

    StencilTable<Real> vertices;  ///< rows of S_n: vertices of the level × base vertices
    StencilTable<Real> points;    ///< W: points × those vertices

    Index rowCount() const { return points.rowCount(); }
    Index columnCount() const { return vertices.columnCount(); }
    Offset entryCount() const { return vertices.entryCount() + points.entryCount(); }

    friend bool operator==(const FactoredTable&, const FactoredTable&) = default;
};

/// The same factors with weights rounded to another precision.
template <class To, class From>
FactoredTable<To> convertTable(FactoredTable<From> table) {
    return {convertTable<To>(std::move(table.vertices)), convertTable<To>(std::move(table.points))};
}

}  // namespace espalier::stencils
