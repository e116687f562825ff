// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

// The data that kernels of GPUs read: plain arrays in memory of the device. Compiled for the host
// and for the device, so nothing here may need the standard library.
namespace espalier::osd::device {

/// Number of lanes of a warp, which are threads that run together.
inline constexpr int kWarp = 32;

/// Maximum number of warps in a block. They share nothing but the memory of the block.
inline constexpr int kWarpsPerBlock = 4;

/// Number of rows of a group that a lane evaluates at a time. The weights of these rows take 16
/// bytes, the largest number of bytes that a lane can load at once.
template <class Real>
inline constexpr int kRowsPerLane = static_cast<int>(16 / sizeof(Real));

/// Values of Group::spline, besides the levels 1, 2, ….
inline constexpr Index kNoSpline = -1, kLimitSpline = 0;

/// Rows that share their columns, as in CompiledRows, in panels of kernels::kLanes rows.
struct Group {
    Offset firstColumn;  ///< position in Groups::columns
    Offset firstNumber;  ///< position in Groups::numbers, which groups may share
    Offset firstRow;     ///< position in Groups::rows
    Index columnCount;
    Index rowCount;
    Index lowest, highest;  ///< row numbers
    Index size[3];          ///< sizes of an outer product; zeros for panels of weights
    Index spline;  ///< kNoSpline: the numbers are weights or factors; otherwise each row has three
                   ///< parameters (spline_weights.h)
};

template <class Real>
struct Groups {
    const Group* groups;
    const Index* columns;
    const Real* numbers;  ///< aligned to 64 bytes
    const Index* rows;
};

/// The part of a group that one warp evaluates.
struct Task {
    Index group;
    Index part;  ///< the first of kWarp · kRowsPerLane rows; for the adjoint, a tile of columns
};

struct TaskList {
    const Task* tasks;
    Index count;
};

/// Compressed sparse rows: row i has entries offsets[i] to offsets[i + 1] − 1.
template <class Real>
struct SparseRows {
    const Offset* offsets;
    const Index* columns;
    const Real* weights;  ///< if null, all weights are 1
    const Index* rows;    ///< the row numbers in the table, ascending; if null, row i is row i
    Index count;
    int lanesLog2;  ///< 2^lanesLog2 lanes work on a row together
};

/// The lists of outer products, each with its own kernel: products whose largest size is 4, 3 or 2,
/// and all larger ones; and splines, whose rows have parameters.
inline constexpr int kSizes[] = {4, 3, 2, 0};
inline constexpr int kSplines = 4, kProductLists = 5;

/// A table on a device.
template <class Real>
struct TableView {
    Index rowCount, columnCount;
    Groups<Real> groups;
    TaskList panels;
    TaskList products[kProductLists];  ///< one list for each of kSizes, and kSplines
    Index maxProductColumns;     ///< maximum number of columns of an outer product larger than 4
    SparseRows<Real> ungrouped;  ///< rows that are in no group
};

/// One step of the adjoint: adds up earlier results, for some slots or for the columns of the
/// table.
template <class Real>
struct SumStep {
    SparseRows<Real> rows;  ///< their columns are slots of earlier results
    Offset firstSlot;  ///< slot of the first result; not used in the last step, whose results are
                       ///< the adjoint
};

/// The additional data of the adjoint. Each intermediate result has a slot: first the sums of the
/// groups, one for each element of Groups::columns; then the sums of the segments; then the results
/// of the steps.
template <class Real>
struct AdjointView {
    TaskList panels, products, splines;  ///< tiles of columns
    SparseRows<Real> segments;           ///< segments of the columns of the ungrouped rows
    Offset firstSegment;                 ///< slot of the sum of the first segment
    const SumStep<Real>* steps;          ///< an array in the memory of the host
    int stepCount;
    Offset slotCount;
};

/// The source and the destination of an evaluation. Component c of row r goes to destination[(r −
/// destinationFirst) · stride + c].
template <class Real>
struct Evaluation {
    const Real* source;
    Offset sourceStride;
    Real* destination;
    Offset destinationStride;
    Index destinationFirst;
    Offset length;
    Index first, last;  ///< rows first to last − 1 are evaluated

    /// Component c of row r adds addend[r · addendStride + c % addendLength]; nothing if null.
    const Real* addend = nullptr;
    Offset addendStride = 0;
    Offset addendLength = 0;
};

/// `count` chunks of the kernel's width, starting at component `from`.
struct Components {
    Offset from;
    Offset count;
};

}  // namespace espalier::osd::device
