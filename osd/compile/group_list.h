// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "table_compiler.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace espalier::osd {

/// Groups of rows that share their columns, on their way into a compiled table. Groups with the
/// same numbers share these: the faces of a regular surface are all alike.
template <class Real>
class GroupList {
public:
    /// Adds a group.
    /// \param numbers of each row, row by row: weights of the columns, or factors
    /// \param size of a product, or zeros
    void add(std::span<const Index> rows, std::span<const Index> columns,
             const std::array<Index, 3>& size, std::vector<Real> numbers);

    /// Puts all groups into a table that has none.
    void moveTo(CompiledRows<Real>& table);

private:
    struct Group {
        std::vector<Index> rows, columns;
        std::array<Index, 3> size;
        std::vector<Real> numbers;
        std::uint64_t hash;  ///< of numbers and size, whatever the order of the rows

        std::size_t length() const { return numbers.size() / rows.size(); }
    };

    static std::uint64_t hashOf(const Group& group);
    static void sortRows(Group& group);
    static Offset appendNumbers(const Group& group, AlignedVector<Real>& all);

    std::vector<Group> groups_;
};

}  // namespace espalier::osd
