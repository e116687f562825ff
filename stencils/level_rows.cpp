// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/base/sort_unique.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/QR>
#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace espalier::stencils {
namespace {

/// A row with more entries than this is long.
constexpr Offset kLongRow = 256;

/// Renumbers the columns of a table to positions in `columns`.
/// \param columns ascending; contains every column that has an entry
StencilTable<double> overColumns(const StencilTable<double>& table,
                                 std::span<const Index> columns) {
    Array<Index> slotOf(table.columnCount());
    for (std::size_t i = 0; i < columns.size(); ++i) slotOf[columns[i]] = static_cast<Index>(i);
    return renumberColumns(table, static_cast<Index>(columns.size()),
                           [&](Index column) { return slotOf[column]; });
}

std::vector<Index> columnsOf(const StencilTable<double>& table) {
    std::vector<Index> columns(table.columns().begin(), table.columns().end());
    sortUnique(columns);
    return columns;
}

/// Multiplies the rows of `own`, and then the rows of `more`, by a level table.
/// \param step R of the level
/// \param areDerivatives whether rows must sum to 0
StencilTable<double> carried(const StencilTable<double>& own, const StencilTable<double>& more,
                             const StencilTable<double>& step, bool areDerivatives) {
    return buildTable(own.rowCount() + more.rowCount(), step.columnCount(),
                      [&](Index row, RowAccumulator& accumulator) {
                          const bool isOwn = row < own.rowCount();
                          const StencilTable<double>& source = isOwn ? own : more;
                          const Index from = isOwn ? row : row - own.rowCount();
                          const auto columns = source.columns(from);
                          const auto weights = source.weights(from);
                          for (std::size_t i = 0; i < columns.size(); ++i) {
                              const auto next = step.columns(columns[i]);
                              const auto factors = step.weights(columns[i]);
                              for (std::size_t k = 0; k < next.size(); ++k)
                                  accumulator.add(next[k], weights[i] * factors[k]);
                              // parallelFor() checks memory only after each chunk, which may
                              // contain thousands of long rows.
                              if (std::ssize(next) > kLongRow) checkMemory();
                          }
                          if (areDerivatives) accumulator.makeSumZero();
                      });
}

/// Makes each group of three consecutive rows orthonormal. The first, the first two and all three
/// rows of a group span the same spaces as before.
StencilTable<double> orthonormal(const StencilTable<double>& rows) {
    return buildTable(
        rows.rowCount(), rows.columnCount(), [&](Index row, RowAccumulator& accumulator) {
            const Index first = row / 3 * 3;
            std::vector<Index> columns;
            for (Index r = first; r <= row; ++r)
                columns.insert(columns.end(), rows.columns(r).begin(), rows.columns(r).end());
            sortUnique(columns);
            Eigen::MatrixXd vectors = Eigen::MatrixXd::Zero(
                std::ssize(columns), static_cast<Eigen::Index>(row - first) + 1);
            for (Index r = first; r <= row; ++r)
                for (std::size_t k = 0; k < rows.columns(r).size(); ++k)
                    vectors(indexIn(columns, rows.columns(r)[k]), r - first) = rows.weights(r)[k];
            const Eigen::MatrixXd basis = orthonormalBasis(vectors);
            for (std::size_t i = 0; i < columns.size(); ++i)
                accumulator.add(columns[i], basis(static_cast<Eigen::Index>(i), row - first));
            accumulator.makeSumZero();
        });
}

StencilTable<double> concatenated(const StencilTable<double>& first,
                                  const StencilTable<double>& second) {
    return buildTable(first.rowCount() + second.rowCount(), first.columnCount(),
                      [&](Index row, RowAccumulator& accumulator) {
                          const bool isFirst = row < first.rowCount();
                          const StencilTable<double>& table = isFirst ? first : second;
                          const Index from = isFirst ? row : row - first.rowCount();
                          for (std::size_t k = 0; k < table.columns(from).size(); ++k)
                              accumulator.add(table.columns(from)[k], table.weights(from)[k]);
                      });
}

/// Splits a concatenated table into tables with the given numbers of rows.
void appendParts(const StencilTable<double>& table, std::span<const Index> counts,
                 std::vector<StencilTable<double>>& parts) {
    Index first = 0;
    for (const Index count : counts) {
        std::vector<Index> own(count);
        std::iota(own.begin(), own.end(), std::exchange(first, first + count));
        parts.push_back(selectRows(table, own));
    }
}

std::vector<Index> rowCounts(std::span<const StencilTable<double>> tables) {
    std::vector<Index> counts;
    for (const auto& table : tables) counts.push_back(table.rowCount());
    return counts;
}

/// Returns true if a row has more than kLongRow entries.
bool hasLongRow(std::span<const Offset> offsets) {
    for (std::size_t row = 1; row < offsets.size(); ++row)
        if (offsets[row] - offsets[row - 1] > kLongRow) return true;
    return false;
}

bool hasLongRow(const far::Incidence& relation) {
    for (Index row = 0; row < relation.rowCount(); ++row)
        if (std::ssize(relation[row]) > kLongRow) return true;
    return false;
}

}  // namespace

Composition compositionAbove(const far::CellComplex& complex) {
    const int cells = complex.dimension();
    const bool isLong = hasLongRow(complex.relation(2, 0)) ||
                        hasLongRow(complex.relation(cells, 0)) ||
                        hasLongRow(complex.relation(0, cells));
    return isLong ? Composition::FromRows : Composition::FromBase;
}

Composition compositionOf(std::span<const StencilTable<double>> tables) {
    const bool isLong =
        std::any_of(tables.begin(), tables.end(),
                    [](const StencilTable<double>& table) { return hasLongRow(table.offsets()); });
    return isLong ? Composition::FromRows : Composition::FromBase;
}

std::vector<StencilTable<double>> composeRows(std::span<const StencilTable<double>> tables,
                                              std::vector<StencilTable<double>> rows,
                                              Composition composition) {
    const std::size_t last = rows.size() - 1;
    if (last == 0) return rows;
    if (composition == Composition::FromRows) {
        const std::vector<Index> counts = rowCounts(rows);
        StencilTable<double> below;
        for (std::size_t k = last; k > 0; --k) {
            below = carried(rows[k], below, tables[k - 1], false);
            rows.pop_back();
        }
        std::vector<StencilTable<double>> result;
        if (below.rowCount() == counts.back()) {
            // Only the base and the last level have rows here, as in binding points. The long rows
            // are moved, not copied.
            result.push_back(std::move(rows[0]));
            while (result.size() < last) result.push_back(selectRows(result[0], {}));
            result.push_back(std::move(below));
            return result;
        }
        appendParts(concatenated(rows[0], below), counts, result);
        return result;
    }
    // First go down from the finest level, to find the vertices whose rows of S_k are needed. Then
    // compute these rows from the base up.
    std::vector<std::vector<Index>> vertices(rows.size());
    std::vector<StencilTable<double>> steps(rows.size());  // the rows of R_k for these vertices
    for (std::size_t k = last; k > 0; --k) {
        const auto own = columnsOf(rows[k]);
        const auto above = k == last ? std::vector<Index>() : columnsOf(steps[k + 1]);
        std::set_union(own.begin(), own.end(), above.begin(), above.end(),
                       std::back_inserter(vertices[k]));
        steps[k] = selectRows(tables[k - 1], vertices[k]);
    }
    std::vector<StencilTable<double>> result;
    result.push_back(std::move(rows[0]));
    StencilTable<double> stencils;
    for (std::size_t k = 1; k <= last; ++k) {
        stencils = k == 1 ? std::move(steps[1])
                          : multiply(overColumns(steps[k], vertices[k - 1]), stencils);
        result.push_back(multiply(overColumns(rows[k], vertices[k]), stencils));
    }
    return result;
}

std::vector<StencilTable<double>> composeDerivatives(std::span<const StencilTable<double>> tables,
                                                     std::vector<StencilTable<double>> rows,
                                                     RowMeaning meaning) {
    // On the first six levels the rows share most vertices, so it is faster to leave these levels
    // to composeRows(). There, rounding errors grow by a factor of only 2⁶.
    constexpr std::size_t kSharedLevels = 6;
    const std::vector<Index> counts = rowCounts(rows);
    StencilTable<double> below;
    for (; rows.size() > kSharedLevels + 1; rows.pop_back()) {
        below = carried(rows.back(), below, tables[rows.size() - 2], true);
        if (meaning == RowMeaning::Spans) below = orthonormal(below);
    }
    if (below.rowCount() > 0) rows.back() = concatenated(rows.back(), below);
    auto result = composeRows(tables, std::move(rows), compositionOf(tables));
    // Split the rows of the last levels again.
    const StencilTable<double> last = std::move(result.back());
    result.pop_back();
    appendParts(last, std::span(counts).subspan(result.size()), result);
    return result;
}

Eigen::MatrixXd orthonormalBasis(const Eigen::MatrixXd& columns) {
    return Eigen::HouseholderQR<Eigen::MatrixXd>(columns).householderQ() *
           Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

}  // namespace espalier::stencils
