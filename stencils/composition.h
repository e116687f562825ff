// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/row_order.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

// stencils/: topology to sparse weights.
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
/// \throws Error for a vertex that the level does not have, and for a level that is not there
ESPALIER_API void checkVertices(const far::TopologyRefiner& refiner, int level,
                                std::span<const Index> vertices);

/// Builds R_level: row i holds the weights of level-`level` vertex i over the vertices of the level
/// before. 8 to 27 entries a row in regular lattices. Rows sum to 1.
///
/// \param level 1 to refiner.maxLevel()
/// \cost O(entries), in parallel; does not depend on positions
/// \cite MacCracken & Joy 1996, sections 2.2 and 3; Savva & Clapworthy, section 2.2 (Rules::Rats);
///       Bajaj, Schaefer, Warren & Xu 2002 (Rules::Mlca)
ESPALIER_API StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level);

/// Builds the rows of R_level for the given vertices of the level: row i is that of vertices[i].
/// \throws Error for a vertex that the level does not have
ESPALIER_API StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level,
                                                  std::span<const Index> vertices);

/// R_1 to R_level, in this order, for values that are carried level by level, pose after pose:
/// apply the first to values on the base, and each to what the one before gave.
///
/// That gives the values of every level, and takes fewer products than S_level: on a surface 8 a
/// vertex of the last level instead of 14, in a lattice 15 instead of 64. But each level must be
/// done before the next, rows of a level share few columns, for which osd::CompiledTable has its
/// best forms, and only S_level gives some rows without the others.
///
/// \cost O(entries), in parallel: as much as refineValues() for one pose
ESPALIER_API std::vector<StencilTable<double>> buildLevelTables(const far::TopologyRefiner& refiner,
                                                                int level);

/// Composes the level tables into S_level = R_level … R_1: row i holds the weights of level-`level`
/// vertex i over the base vertices. At most 64 entries a row in regular lattices. Rows sum to 1.
///
/// \param level 0 (the identity) to refiner.maxLevel()
/// Many rows are the same weights over other columns, where a base is regular: just one of them
/// is composed, and copied.
///
/// \cost O(products of entries), in parallel; memory for S_level and S_(level−1) at once
/// \cite MacCracken & Joy 1996, sections 2.2 and 3
ESPALIER_API StencilTable<double> buildStencils(const far::TopologyRefiner& refiner, int level);

/// Builds the rows of S_level for the given vertices of the level: row i is that of vertices[i].
/// Of each level, only the rows that these depend on are made.
///
/// \param vertices in any order, repeats allowed
/// \throws Error for a vertex that the level does not have
ESPALIER_API StencilTable<double> buildStencils(const far::TopologyRefiner& refiner, int level,
                                                std::span<const Index> vertices);

/// The same from level tables at hand, of whole levels or of those of
/// far::TopologyRefiner::refineAround().
///
/// \param tables R_1 to R_level: see buildLevelTables(). At least one
/// \throws Error if they are not as many as the levels of `refiner`, or not of these
ESPALIER_API StencilTable<double> composeStencils(const far::TopologyRefiner& refiner,
                                                  std::span<const StencilTable<double>> tables,
                                                  std::span<const Index> vertices);

/// The product of two tables: row i is Σ_k left(i, k) · right(k, ·).
///
/// \param order which rows of `left` lead to the same columns. The result does not depend on it,
///        only the time
/// \throws Error if left.columnCount() is not right.rowCount()
/// \cost O(products of entries), in parallel; twice the memory of the result
ESPALIER_API StencilTable<double> multiply(const StencilTable<double>& left,
                                           const StencilTable<double>& right,
                                           const RowOrder& order = {});

/// The columns that a table names, ascending, and the table over just those: column c of `table`
/// stands for column `columns[c]` of the original.
struct CompactTable {
    StencilTable<double> table;
    std::vector<Index> columns;
};
ESPALIER_API CompactTable compactColumns(StencilTable<double> table);

/// Values on the base vertices carried to the vertices of a level: R_level … R_1 applied in turn.
///
/// \param values `components` a base vertex, vertex by vertex; positions are values of 3 components
/// \return `components` a level vertex, vertex by vertex
/// \throws Error if values.size() is not components × base vertices
/// \cost O(entries of the level tables), most of it to make them: see buildLevelTables() for many
///       poses. Holds one of them at a time
ESPALIER_API std::vector<double> refineValues(const far::TopologyRefiner& refiner, int level,
                                              std::span<const double> values, int components);

/// One step of that for positions, with its table at hand: R_k times positions of level k − 1.
ESPALIER_API std::vector<Point3> applyLevelTable(const StencilTable<double>& table,
                                                 std::span<const Point3> positions);

/// All steps for positions.
ESPALIER_API std::vector<Point3> refinePositions(const far::TopologyRefiner& refiner, int level,
                                                 std::span<const Point3> positions);

}  // namespace espalier::stencils
