// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

// What kernels of GPUs read: plain arrays, that lie in memory of the device. Compiled for the host
// and for the device: nothing here may need the standard library.
namespace espalier::osd::device {

/// Lanes of a warp: threads that go together.
inline constexpr int kWarp = 32;

/// Rows of a group that a lane evaluates at a time: as many as 16 bytes hold weights, which is the
/// most that it can load at once.
template <class Real>
inline constexpr int kRowsPerLane = static_cast<int>(16 / sizeof(Real));

/// Rows that share their columns, as in CompiledRows: panels of kernels::kLanes rows.
struct Group {
    Offset firstColumn;  ///< in Groups::columns
    Offset firstNumber;  ///< in Groups::numbers, which groups may share
    Offset firstRow;     ///< in Groups::rows
    Index columnCount;
    Index rowCount;
    Index lowest, highest;  ///< row
    Index size[3];          ///< of an outer product; zeros if these are panels of weights
};

template <class Real>
struct Groups {
    const Group* groups;
    const Index* columns;
    const Real* numbers;  ///< aligned to 64 bytes
    const Index* rows;
};

/// What a warp does of a group.
struct Task {
    Index group;
    Index part;  ///< the first of kWarp · kRowsOfLane rows; for the adjoint a tile of columns
};

struct TaskList {
    const Task* tasks;
    Index count;
};

/// Rows in compressed form: row i is entries offsets[i] to offsets[i + 1] − 1.
template <class Real>
struct SparseRows {
    const Offset* offsets;
    const Index* columns;
    const Real* weights;  ///< 1 for each entry if null
    const Index* rows;    ///< which row of the table, ascending; row i if null
    Index count;
    int lanesLog2;  ///< 2 to this many lanes go through a row together
};

/// How sizes of outer products are shared out: those of n × m × l factors with n, m and l up to 4
/// by n, and all others to 0.
inline constexpr int kSizes[] = {4, 3, 2, 0};
inline constexpr int kSizeCount = 4;

/// A table on a device.
template <class Real>
struct TableView {
    Index rowCount, columnCount;
    Groups<Real> groups;
    TaskList panels;
    TaskList products[kSizeCount];  ///< in the order of kSizes
    Index maxProductColumns;        ///< of a product of other sizes
    SparseRows<Real> ungrouped;     ///< the rows that are in no group
};

/// Sums of results for each of some places, or of the columns of the table.
template <class Real>
struct SumStep {
    SparseRows<Real> rows;  ///< columns are places of earlier results
    Offset firstPlace;      ///< of these results; those of the last step are the adjoint's
};

/// What the adjoint of a table reads besides. Results have places: first those of the groups for
/// their columns, as in Groups::columns, then those of the segments, then those of the steps.
template <class Real>
struct AdjointView {
    TaskList panels, products;   ///< tiles of columns
    SparseRows<Real> segments;   ///< of the columns of the rows that are in no group
    Offset firstSegment;         ///< its place
    const SumStep<Real>* steps;  ///< in memory of the host
    int stepCount;
    Offset placeCount;
};

/// The values that a table is applied to, and where results go: component c of row r to
/// destination[(r − destinationFirst) · stride + c].
template <class Real>
struct Evaluation {
    const Real* source;
    Offset sourceStride;
    Real* destination;
    Offset destinationStride;
    Index destinationFirst;
    Offset length;
    Index first, last;  ///< rows first to last − 1 are evaluated
};

/// Components that go through a kernel of some width: `count` times so many, from `from` on.
struct Components {
    Offset from;
    Offset count;
};

}  // namespace espalier::osd::device
