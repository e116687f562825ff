// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace espalier::osd {

/// A hash of the bits of some numbers, in their order.
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
    std::size_t superset = 0;  ///< a set whose columns hold all of these; itself if there is none
};

/// The rows of a table by their columns. Sets come in the order of their first rows. No host has
/// another host than itself, nor more than three times the columns of a guest.
///
/// Near the planes between the cells of the base, rows have fewer columns than in the middle of a
/// cell, and those of the middle among them: they are guests of these.
///
/// \cost O(entries + rows log rows + columns); at most 256 hosts are tried for a set
template <class Real>
std::vector<RowSet> findRowSets(const stencils::StencilTable<Real>& table);

}  // namespace espalier::osd
