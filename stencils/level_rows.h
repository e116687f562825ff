// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

namespace espalier::stencils {

/// From which end products of level tables are made.
enum class Composition {
    FromBase,  ///< rows of S_k are made once, for all rows that share their vertices
    FromRows   ///< each row is carried up by itself: where rows of S_k are long, few of them are
               ///< shared by more rows than they have entries
};

/// FromRows if new points on the levels above a complex have rows of more than some 256 entries:
/// those of cells and faces of as many vertices, and of vertices of as many cells.
/// \cost O(entities of the complex)
Composition compositionAbove(const far::CellComplex& complex);

/// The same by level tables at hand.
/// \cost O(rows)
Composition compositionOf(std::span<const StencilTable<double>> tables);

/// Tables over the vertices of several levels, carried to the base: element k of the result is
/// rows[k] · R_k … R_1. All levels in one go: a row of S_k is made once, for what asks for it there
/// and for what is made of it further up.
///
/// \param tables R_1, R_2, …: as many as levels 1 to rows.size() − 1 at least
/// \param rows one table a level, from 0 on; without rows where a level has none
/// \cost O(products of entries), in parallel
std::vector<StencilTable<double>> composeRows(std::span<const StencilTable<double>> tables,
                                              std::vector<StencilTable<double>> rows,
                                              Composition composition);

/// Whether rows of derivatives stand for themselves, or for the space that each three of them span.
enum class RowMeaning { Themselves, Spans };

/// The same for rows of derivatives, each right to its own size, however deep its level is.
///
/// Such rows sum to 0. Each level takes them to about half their size, but not the rounding of
/// their sum. So they are carried up level by level, and their sums are put right on each. Rows
/// that span a space are made orthonormal too: where a smooth boundary bends a corner flat, the
/// three derivatives tend to a plane, and the third one, near to it, would be lost in rounding.
std::vector<StencilTable<double>> composeDerivatives(std::span<const StencilTable<double>> tables,
                                                     std::vector<StencilTable<double>> rows,
                                                     RowMeaning meaning);

}  // namespace espalier::stencils
