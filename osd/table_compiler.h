// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <cstddef>
#include <new>
#include <vector>

// What is inside a compiled table.
namespace espalier::osd {

using far::Index;
using far::Offset;

/// Memory at an address that registers are loaded from.
template <class T>
struct Aligned {
    using value_type = T;
    static constexpr std::align_val_t kAlignment{64};

    Aligned() = default;
    template <class U>
    Aligned(const Aligned<U>&) {}
    T* allocate(std::size_t count) {
        return static_cast<T*>(::operator new(count * sizeof(T), kAlignment));
    }
    void deallocate(T* values, std::size_t) { ::operator delete(values, kAlignment); }
    friend bool operator==(const Aligned&, const Aligned&) { return true; }
};

template <class T>
using AlignedVector = std::vector<T, Aligned<T>>;

/// A table in three forms, each row in one of them.
template <class Real>
struct CompiledRows {
    /// Rows that share their columns: PanelRun, or ProductRun.
    struct Group {
        Offset firstColumn;  ///< in groupColumns
        Index columnCount;
        Offset firstNumber;  ///< in groupNumbers
        Offset firstRow;     ///< in groupRows
        Index rowCount;
        Index lowest, highest;      ///< row
        std::array<Index, 3> size;  ///< of a product; zeros if these are panels of weights
    };
    std::vector<Group> groups;
    /// For one thread after the other: task t is groups taskStarts[t] to taskStarts[t + 1] − 1.
    std::vector<Offset> taskStarts = {0};
    std::vector<Index> groupColumns;
    AlignedVector<Real> groupNumbers;  ///< weights, or factors of products
    std::vector<Index> groupRows;

    /// Rows of the same number of entries: RowRun.
    struct Run {
        Index length;
        Offset firstEntry;  ///< in columns and weights
        Offset firstRow;    ///< in rows
        Index rowCount;
    };
    std::vector<Run> runs;
    std::vector<Index> columns;
    std::vector<Real> weights;
    std::vector<Index> rows;
};

/// Finds the form of each row of a table.
/// \cost O(entries + rows log rows)
template <class Real>
CompiledRows<Real> compileRows(const stencils::StencilTable<Real>& table);

}  // namespace espalier::osd
