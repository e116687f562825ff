// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <utility>

namespace espalier::stencils {

/// A deformation table in two factors, D = points · vertices: a pose first moves the vertices of
/// the refined lattice, and these then move the points.
///
/// If cells of the level contain several points each, the factors take less memory and time than D:
/// a row of `points` has 8 entries, and a row of D up to 64. If each point has a cell of its own,
/// they take more, since each point needs eight rows of `vertices`. Compare entryCount() with the
/// entryCount() of D.
///
/// osd::CompiledChain evaluates it.
///
/// \cite MacCracken & Joy 1996, section 5
template <class Real>
struct ESPALIER_API FactoredTable {
    using Weight = Real;

    StencilTable<Real> vertices;  ///< rows of S_n: vertices of the level × base vertices
    StencilTable<Real> points;    ///< W: points × the rows of `vertices`

    Index rowCount() const { return points.rowCount(); }
    Index columnCount() const { return vertices.columnCount(); }
    Offset entryCount() const { return vertices.entryCount() + points.entryCount(); }

    friend bool operator==(const FactoredTable&, const FactoredTable&) = default;
};

/// Returns the table with weights rounded to another precision.
template <class To, class From>
FactoredTable<To> convertTable(FactoredTable<From> table) {
    return {convertTable<To>(std::move(table.vertices)), convertTable<To>(std::move(table.points))};
}

}  // namespace espalier::stencils
