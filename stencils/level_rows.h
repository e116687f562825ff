// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/stencils/stencil_table.h>

#include <Eigen/Core>

#include <span>
#include <vector>

namespace espalier::stencils {

/// Tells from which end to multiply level tables.
enum class Composition {
    FromBase,  ///< each row of S_k is computed once, for all rows that use its vertex
    FromRows   ///< each row is carried to the base separately. Faster for long rows of S_k, most of
               ///< which are used by fewer rows than they have entries
};

/// Returns FromRows if new points above a complex have rows of more than about 256 entries. This is
/// the case if a cell or face has that many vertices, or a vertex that many cells.
/// \cost O(entities of the complex)
Composition compositionAbove(const far::CellComplex& complex);

/// The same, decided from the level tables.
/// \cost O(rows)
Composition compositionOf(std::span<const StencilTable<double>> tables);

/// Carries tables over the vertices of several levels to the base: element k of the result is
/// rows[k] · R_k … R_1. Does all levels together, so that each row of S_k is computed once, both
/// for rows[k] and for higher levels.
///
/// \param tables R_1, R_2, …, at least up to level rows.size() − 1
/// \param rows one table per level, from level 0; a table without rows if a level has none
/// \cost O(products of entries), in parallel
std::vector<StencilTable<double>> composeRows(std::span<const StencilTable<double>> tables,
                                              std::vector<StencilTable<double>> rows,
                                              Composition composition);

/// Selects what rows of derivatives mean: vectors, or only the space that each three rows span.
enum class RowMeaning { Vectors, Spans };

/// The same for rows of derivatives, each accurate relative to its own size on any level.
///
/// A row of derivatives sums to 0. Each level reduces the row to about half its size, but not the
/// rounding error of its sum. So the rows are carried to the base level by level, and their sums
/// are corrected on each level. With RowMeaning::Spans, each three rows are also made orthonormal:
/// where a smooth boundary flattens a corner, the three derivatives tend to a plane, and the third
/// one would be lost in rounding.
std::vector<StencilTable<double>> composeDerivatives(std::span<const StencilTable<double>> tables,
                                                     std::vector<StencilTable<double>> rows,
                                                     RowMeaning meaning);

/// Returns an orthonormal basis of the space that the columns span: one vector for each column. For
/// every k, the first k vectors span the same space as the first k columns.
Eigen::MatrixXd orthonormalBasis(const Eigen::MatrixXd& columns);

}  // namespace espalier::stencils
