// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/hash.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "table_compiler.h"

namespace espalier::osd {

/// Returns a hash of the bits of some numbers, which depends on their order.
template <class Number>
std::uint64_t hashOf(std::span<const Number> numbers) {
    std::uint64_t hash = numbers.size();
    for (const Number number : numbers) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &number, sizeof(number));
        hash = appendedHash(hash, bits);
    }
    return hash;
}

/// Returns the weights of a row for columns that include its own, with zeros for the others.
/// \param spread gets the weights if the row lacks some of the columns
template <class Real>
std::span<const Real> spreadRow(const stencils::StencilTable<Real>& table, Index row,
                                std::span<const Index> columns, std::vector<Real>& spread) {
    const auto own = table.columns(row);
    const auto weights = table.weights(row);
    if (own.size() == columns.size()) return weights;
    spread.assign(columns.size(), 0);
    for (std::size_t k = 0, place = 0; k < own.size(); ++k) {
        while (columns[place] != own[k]) ++place;
        spread[place] = weights[k];
    }
    return spread;
}

/// Collects the groups of a compiled table. Groups with identical numbers share them; all faces of
/// a regular surface are such groups, for example.
///
/// The numbers of all groups are stored at the end, when their count is known: weights are copied
/// once, from the table to their final place.
template <class Real>
class GroupList {
public:
    /// \param table must outlive this object
    explicit GroupList(const stencils::StencilTable<Real>& table);

    /// Adds panels of weights: groups of at most kMaxRowsPerGroup rows.
    /// \param columns include the columns of each row; a row has the weight 0 for other columns
    void addPanels(std::span<const Index> rows, std::span<const Index> columns);

    /// Appends the factors of a row, for the next call of addProducts().
    void addFactors(std::span<const Real> factors);

    /// Adds outer products: groups of at most kMaxRowsPerGroup rows.
    /// \param rows the rows whose factors were added since the last call, in their order
    void addProducts(std::span<const Index> rows, std::span<const Index> columns,
                     const std::array<Index, 3>& size);

    /// Moves the groups, their columns, rows and numbers into a table that has none yet.
    /// \cost in parallel
    void moveTo(CompiledRows<Real>& compiled);

private:
    using Group = typename CompiledRows<Real>::Group;

    void add(std::span<const Index> rows, std::span<const Index> columns,
             const std::array<Index, 3>& size);
    static std::size_t lengthOf(const Group& group);
    std::span<const Index> columnsOf(const Group& group) const;
    std::span<Index> rowsOf(const Group& group);
    std::span<const Real> numbersOf(const Group& group, Index row, std::vector<Real>& spread) const;
    std::uint64_t sumOfBits(const Group& group) const;
    std::uint64_t hashOfGroup(const Group& group) const;
    bool haveSameNumbers(const Group& a, const Group& b) const;
    void sortRows(const Group& group);
    std::vector<std::size_t> findSources();
    void storeNumbers(const Group& group, Real* to) const;

    const stencils::StencilTable<Real>& table_;
    std::vector<Group> groups_;        ///< until moveTo(), firstNumber is a position in factors_
    std::vector<std::uint64_t> sums_;  ///< for each group, sumOfBits()
    std::vector<Index> columns_, rows_;
    Array<Real> factors_;          ///< of all outer products, row by row
    std::size_t factorsUsed_ = 0;  ///< number of factors that belong to groups
};

}  // namespace espalier::osd
