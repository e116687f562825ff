// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace espalier::osd {

/// Returns a hash of the bits of some numbers, which depends on their order.
template <class Number>
std::uint64_t hashOf(std::span<const Number> numbers) {
    std::uint64_t hash = numbers.size();
    for (const Number number : numbers) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &number, sizeof(number));
        hash = (hash ^ bits) * 0x9E3779B97F4A7C15U;
        hash ^= hash >> 29;
    }
    return hash;
}

/// Rows of a table with the same columns.
struct RowSet {
    std::vector<Index> rows = {};  ///< ascending
    std::size_t superset = 0;  ///< a set whose columns include the columns of this one; this set
                               ///< itself if there is none
};

/// Groups the rows of a table by their columns. The sets are in the order of their first rows. A
/// set that is the superset of another has no superset other than itself, and at most three times
/// the columns of the other.
///
/// Near the planes between base cells, rows have fewer columns than rows in the middle of a cell,
/// and each of these columns is also a column of the rows in the middle. So the sets near the
/// planes become subsets of the set in the middle.
///
/// \cost O(entries + columns); at most 256 candidates for a superset are tried
template <class Real>
std::vector<RowSet> findRowSets(const stencils::StencilTable<Real>& table);

}  // namespace espalier::osd
