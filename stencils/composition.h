// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/row_order.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

// stencils/: computes sparse weights from topology.
//
// In: a far::TopologyRefiner. Out: tables of weights, as sparse matrices.
//
// Types: Mask, the weights of one point (masks.h; mlca.h and rats.h hold other rules);
// StencilTable, a matrix in compressed sparse rows; FactoredTable, a product that is left in two
// factors; Levels, refined levels with their tables and positions. Weights are made in double;
// convertTable() rounds them to float.
//
// Read masks.h, stencil_table.h, then this header.
//
// Notation: R_k is level k over level k − 1; S_n = R_n … R_1 is level n over the base. Rows sum
// to 1.
namespace espalier::stencils {

/// Checks that a level has the given vertices.
///
/// \throws Error if the level does not exist, or does not have one of the vertices
ESPALIER_API void checkVertices(const far::TopologyRefiner& refiner, int level,
                                std::span<const Index> vertices);

/// Builds R_level: row i holds the weights of level-`level` vertex i over the vertices of the level
/// before, 8 to 27 entries per row in regular lattices. Rows sum to 1.
///
/// \param level 1 to refiner.maxLevel()
/// \cost O(entries), in parallel; does not depend on positions
/// \cite MacCracken & Joy 1996, sections 2.2 and 3; Savva & Clapworthy, section 2.2 (Rules::Rats);
///       Bajaj, Schaefer, Warren & Xu 2002 (Rules::Mlca)
ESPALIER_API StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level);

/// Builds the rows of R_level for the given vertices of the level: row i belongs to vertices[i].
/// \throws Error for a vertex that the level does not have
ESPALIER_API StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level,
                                                  std::span<const Index> vertices);

/// Builds R_1 to R_level, in this order. They carry values level by level, pose after pose: apply
/// the first table to values on the base, and each further one to the result of the one before.
///
/// This gives the values of every level, with fewer products than S_level: 8 per vertex of the last
/// level instead of 14 on a surface, 15 instead of 64 in a lattice. But each level must be finished
/// before the next; rows of a level share few columns, so osd::CompiledTable cannot use its best
/// forms; and only S_level gives some rows without computing the others.
///
/// \cost O(entries), in parallel: the same as refineValues() for one pose
ESPALIER_API std::vector<StencilTable<double>> buildLevelTables(const far::TopologyRefiner& refiner,
                                                                int level);

/// Composes the level tables into S_level = R_level … R_1: row i holds the weights of level-`level`
/// vertex i over the base vertices, at most 64 entries per row in regular lattices. Rows sum to 1.
///
/// In regular parts of a base, many rows have the same weights over different columns: only one of
/// them is composed, and then copied.
///
/// \tparam Real float or double. Weights are always made in double; in float they are rounded, as
///         by convertTable(), but where rows are copied the table in double is never made
/// \param level 0 (the identity) to refiner.maxLevel()
/// \cost O(products of entries), in parallel; memory for S_level and S_(level−1) at once
/// \cite MacCracken & Joy 1996, sections 2.2 and 3
template <class Real = double>
ESPALIER_API StencilTable<Real> buildStencils(const far::TopologyRefiner& refiner, int level);

/// Builds the rows of S_level for the given vertices of the level: row i belongs to vertices[i]. On
/// each level, only the rows that these depend on are computed.
///
/// \param vertices in any order, repeats allowed
/// \throws Error for a vertex that the level does not have
template <class Real = double>
ESPALIER_API StencilTable<Real> buildStencils(const far::TopologyRefiner& refiner, int level,
                                              std::span<const Index> vertices);

/// The same from existing level tables, whether the levels are complete or made by
/// far::TopologyRefiner::refineAround().
///
/// \param tables R_1 to R_level, at least one: see buildLevelTables()
/// \throws Error if there are more tables than levels of `refiner`, or a table does not fit its
///         level
ESPALIER_API StencilTable<double> composeStencils(const far::TopologyRefiner& refiner,
                                                  std::span<const StencilTable<double>> tables,
                                                  std::span<const Index> vertices);

/// Returns the product of two tables: row i is Σ_k left(i, k) · right(k, ·).
///
/// \param order groups rows of `left` that lead to the same columns; affects the time, not the
///        result
/// \param slots a permutation: row i of the product becomes row slots[i] of the result. If it is
///        empty, rows keep their order
/// \throws Error if left.columnCount() is not right.rowCount()
/// \cost O(products of entries), in parallel; the memory of the result
ESPALIER_API StencilTable<double> multiply(const StencilTable<double>& left,
                                           const StencilTable<double>& right,
                                           const RowOrder& order = {},
                                           std::span<const Index> slots = {});

/// A table without its empty columns. Column c of `table` corresponds to column `columns[c]` of the
/// original; `columns` are ascending.
struct CompactTable {
    StencilTable<double> table;
    std::vector<Index> columns;
};
ESPALIER_API CompactTable compactColumns(StencilTable<double> table);

/// Carries values on the base vertices to the vertices of a level: applies R_1 to R_level in turn.
///
/// \param values `components` per base vertex, vertex by vertex; positions are values with 3
///        components
/// \return `components` per level vertex, vertex by vertex
/// \throws Error if values.size() is not components × number of base vertices
/// \cost O(entries of the level tables), mostly to build them: see buildLevelTables() for many
///       poses. Only a part of one table is in memory at a time
ESPALIER_API std::vector<double> refineValues(const far::TopologyRefiner& refiner, int level,
                                              std::span<const double> values, int components);

/// Carries positions of level k − 1 to level k by R_k.
ESPALIER_API std::vector<Point3> applyLevelTable(const StencilTable<double>& table,
                                                 std::span<const Point3> positions);

/// Carries positions of the base vertices to a level: refineValues() for positions.
ESPALIER_API std::vector<Point3> refinePositions(const far::TopologyRefiner& refiner, int level,
                                                 std::span<const Point3> positions);

}  // namespace espalier::stencils
