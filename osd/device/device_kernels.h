// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "device_rows.h"
#include "spline_weights.h"
#include "warp_memory.h"

// The kernels of GPUs, as functions of one warp. They are compiled for the device by
// cuda_launch.cu, and for the host by tests. Both give the same results to the last bit: every
// product is added by fma(), and every sum over lanes has a fixed order.
//
// A kernel says how many blocks of it each multiprocessor shall run at a time (kBlocks): they share
// its registers.
//
// A Warp has
//
//     each(f)                 calls f(lane) for all lanes, and synchronizes them afterwards
//     PerLane<T>              a T for each lane: value[lane]
//     sumOver(v, lanes)       v: PerLane<Values<Real, n>>; divides the warp into groups of `lanes`
//                             consecutive lanes, and gives each lane the sums over its group
//     sumAll(v)               n a multiple of kWarp: sets v[lane].of[t] to the sum of
//                             of[32 t + lane] over all lanes
//     load<T>(address)        loads a T of 16 bytes, aligned to 16, that is not soon read again
//     copy<a, b>(to, from)    begins to copy a T of 4, 8 or 16 bytes, aligned to its size, from
//                             `b` bytes after `from` to `a` bytes after `to`, in shared memory
//     waitForCopies()         waits until the copies of all lanes are done
//     storeIf(is, to, value)  writes a number if `is` is true, without a branch
//
// Memory that a lane writes in one each() may be read by other lanes in the next each().
namespace espalier::osd::device {

/// Evaluates rows that share their columns. Each warp evaluates one task. A lane loads one weight
/// of each of its rows at a time.
template <int width, class Real>
struct PanelKernel {
    static constexpr int kBlocks = 4;
    static constexpr Index kColumns = 64;  ///< columns whose entries are in shared memory at a time

    Groups<Real> table;
    TaskList tasks;
    Evaluation<Real> evaluation;
    Components components;

    Index warpCount() const { return tasks.count; }
    unsigned sharedBytes() const { return kEntriesFrom + Entries<width, Real>::bytes(kColumns); }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char* shared) const {
        const Task task = tasks.tasks[index];
        const Group& group = table.groups[task.group];
        if (!isAnyInRange(group, evaluation)) return;
        for (Offset i = 0; i < components.count; ++i)
            evaluate(warp, group, task.part, components.from + i * width, shared);
    }

private:
    using Sums = Values<RowNumbers<Real>, width>;

    // Shared memory has the results, the row numbers and the entries.
    static constexpr unsigned kRowsFrom = Results<width, Real>::kBytes;
    static constexpr unsigned kEntriesFrom =
        kRowsFrom + Results<width, Real>::kRows * sizeof(Index);

    template <class Warp>
    ESPALIER_DEVICE void evaluate(Warp& warp, const Group& group, Index firstRow, Offset from,
                                  unsigned char* shared) const {
        const Results<width, Real> results(shared);
        Index* const rows = reinterpret_cast<Index*>(shared + kRowsFrom);
        const Entries<width, Real> entries(shared + kEntriesFrom);
        typename Warp::template PerLane<Sums> sums;
        copyRows<Real>(warp, table.rows + group.firstRow + firstRow, group.rowCount - firstRow,
                       rows);
        warp.each([&](int lane) { sums[lane] = {}; });
        for (Index first = 0; first < group.columnCount; first += kColumns) {
            const Index left = group.columnCount - first, count = left < kColumns ? left : kColumns;
            entries.gather(warp, table.columns + group.firstColumn + first, count, evaluation,
                           from);
            warp.each([&](int lane) {
                const Index row = firstRow + lane * kRowsPerLane<Real>;
                if (row >= group.rowCount) return;
                const Real* number = numberOf(table, group, row, group.columnCount, first);
                Sums own = sums[lane];
#if defined(__CUDACC__)
#pragma unroll 4
#endif
                for (Index k = 0; k < count; ++k, number += kLanes<Real>)
                    addEntry(own, warp.template load<RowNumbers<Real>>(number), entries[k]);
                sums[lane] = own;
            });
        }
        warp.each([&](int lane) { results.set(lane, sums[lane]); });
        warp.waitForCopies();
        results.store(warp, rows, evaluation, from);
    }
};

/// The factors of the rows of a lane, for an outer product of at most 4 columns along each axis.
template <int n, class Real>
struct Factors {
    RowNumbers<Real> a[n], b[4], c[4];
};

/// Evaluates rows that are outer products: sums along axis 0, then sums of these along axis 1, then
/// along axis 2.
///
/// A warp evaluates consecutive tasks. Most of them belong to the same group, whose entries it
/// gathers once. While it evaluates one task, the numbers of the next are copied to shared memory.
///
/// \tparam n the size along axis 0, where the other sizes are at most n: all factors are loaded at
///         once, and once for any number of components. 0 allows any sizes
/// \tparam isSpline true for groups whose rows have parameters: entries are converted to
///         coefficients, up to 4 along each axis, and factors are powers of the parameters
template <int n, bool isSpline, int width, class Real>
struct ProductKernel {
    static constexpr int kBlocks = 4;
    /// Maximum of components.count: the entries of all chunks are in shared memory.
    static constexpr Offset kMaxChunks = n > 0 ? 4 : 1;

    Groups<Real> table;
    TaskList tasks;
    Index maxColumns;  ///< maximum number of columns of an outer product, if n is 0
    Evaluation<Real> evaluation;
    Components components;
    Index warpsAtOnce = 1;

    /// \param count number of warps that the device runs at a time
    void divideAmong(Index count) { warpsAtOnce = count; }

    ESPALIER_DEVICE Index warpCount() const {
        return tasks.count < warpsAtOnce ? tasks.count : warpsAtOnce;
    }
    unsigned sharedBytes() const {
        return sharedBytesOf(static_cast<Index>(components.count) * entryCount());
    }
    static constexpr unsigned sharedBytesOf(Index entries) {
        return kEntriesFrom + Entries<width, Real>::bytes(entries);
    }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char* shared) const {
        const Offset count = tasks.count, parts = warpCount();
        const auto first = static_cast<Index>(count * index / parts),
                   last = static_cast<Index>(count * (index + 1) / parts);
        const Results<width, Real> results(shared);
        const Staged staged(shared + kStagedFrom);
        const auto rowsOf = [&](Index t) {
            return reinterpret_cast<Index*>(shared + kRowsFrom) + t % 2 * Staged::kRows;
        };
        const auto entries = [&](Offset chunk) {
            return Entries<width, Real>(shared + kEntriesFrom +
                                        chunk * Entries<width, Real>::bytes(entryCount()));
        };
        const auto begin = [&](Index t) {
            const Task task = tasks.tasks[t];
            const Group& group = table.groups[task.group];
            if (!isAnyInRange(group, evaluation)) return;
            const Index length = productLength(group), rowCount = group.rowCount - task.part;
            if constexpr (n > 0)
                warp.each([&](int lane) {
                    const Index row = lane * kRowsPerLane<Real>;
                    if (row < rowCount)
                        staged.template copy<kLength>(
                            warp, lane, numberOf(table, group, task.part + row, length, 0), length,
                            0);
                });
            copyRows<Real>(warp, table.rows + group.firstRow + task.part, rowCount, rowsOf(t));
        };
        begin(first);
        Index gathered = -1;  // the group whose entries are in shared memory
        for (Index t = first; t < last; ++t) {
            const Task task = tasks.tasks[t];
            const Group& group = table.groups[task.group];
            const bool isNeeded = isAnyInRange(group, evaluation);
            const Index rowCount = group.rowCount - task.part;  // from the first row of the task on
            if (isNeeded && gathered != task.group) {
                const Index* columns = table.columns + group.firstColumn;
                for (Offset i = 0; i < components.count; ++i) {
                    const Offset from = components.from + i * width;
                    if constexpr (isSpline)
                        entries(i).gatherCoefficients(warp, columns, group.size, evaluation, from);
                    else
                        entries(i).gather(warp, columns, group.columnCount, evaluation, from);
                }
                gathered = task.group;
            }
            warp.waitForCopies();
            typename Warp::template PerLane<OwnFactors> factors;
            if constexpr (n > 0)
                if (isNeeded)
                    warp.each([&](int lane) { load(group, staged, lane, factors[lane]); });
            if (t + 1 < last) begin(t + 1);
            if (!isNeeded) continue;
            for (Offset i = 0; i < components.count; ++i) {
                warp.each([&](int lane) {
                    if (lane * kRowsPerLane<Real> >= rowCount) return;
                    if constexpr (n == 0)
                        results.set(lane, multiplyAny(group, task.part, lane, entries(i)));
                    else if constexpr (isSpline)
                        results.set(lane, multiplyPowers(group, factors[lane], entries(i)));
                    else
                        results.set(lane, multiply(group, factors[lane], entries(i)));
                });
                results.store(warp, rowsOf(t), evaluation, components.from + i * width);
            }
        }
    }

private:
    using Sums = Values<RowNumbers<Real>, width>;
    /// Maximum number of numbers of a row that are copied to shared memory.
    static constexpr int kLength = isSpline ? 3 : 3 * n;
    using Staged = StagedNumbers<kLength, Real>;
    using OwnFactors = Factors<(n > 0 ? n : 1), Real>;

    // Shared memory has the results, the row numbers of two tasks, the numbers of one task, and the
    // entries.
    static constexpr unsigned kRowsFrom = Results<width, Real>::kBytes;
    static constexpr unsigned kStagedFrom = kRowsFrom + 2 * Staged::kRows * sizeof(Index);
    static constexpr unsigned kEntriesFrom = kStagedFrom + Staged::kBytes;

    /// Returns for how many entries of a chunk there is memory. The other sizes are at most n.
    ESPALIER_DEVICE Index entryCount() const { return n > 0 ? n * n * n : maxColumns; }

    ESPALIER_DEVICE void load(const Group& group, const Staged& staged, int lane,
                              OwnFactors& factors) const {
        Index slot = 0;
        const auto next = [&](RowNumbers<Real>& to) { to = staged(lane, slot++); };
        if constexpr (isSpline) {
            RowNumbers<Real> t[3];
            ESPALIER_UNROLL
            for (int axis = 0; axis < 3; ++axis) next(t[axis]);
            setPowers(group.spline, t[0], factors.a);
            setPowers(group.spline, t[1], factors.b);
            setPowers(group.spline, t[2], factors.c);
        } else {
            const Index m = group.size[1], l = group.size[2];
            ESPALIER_UNROLL
            for (int i = 0; i < n; ++i) next(factors.a[i]);
            ESPALIER_UNROLL
            for (int j = 0; j < 4; ++j)
                if (j < m) next(factors.b[j]);
            ESPALIER_UNROLL
            for (int k = 0; k < 4; ++k)
                if (k < l) next(factors.c[k]);
        }
    }

    /// Computes the powers of one axis for the rows of a lane.
    ESPALIER_DEVICE static void setPowers(Index spline, const RowNumbers<Real>& t,
                                          RowNumbers<Real> (&factors)[4]) {
        const auto set = [&](const auto& powersOf) {
            ESPALIER_UNROLL
            for (int q = 0; q < kRowsPerLane<Real>; ++q) {
                const SplinePowers<Real> powers = powersOf(t.of[q]);
                ESPALIER_UNROLL
                for (int i = 0; i < 4; ++i) factors[i].of[q] = powers.of[i];
            }
        };
        // One branch for all rows.
        if (spline == kLimitSpline)
            set([](Real own) { return splinePowers(kLimitSpline, own); });
        else
            set([spline](Real own) { return splinePowers(spline, own); });
    }

    ESPALIER_DEVICE static Sums multiply(const Group& group, const OwnFactors& factors,
                                         const Entries<width, Real>& entries) {
        Sums all = {};
        Index slot = 0;
        ESPALIER_UNROLL
        for (int k = 0; k < 4; ++k) {
            if (k >= group.size[2]) continue;
            Sums plane = {};
            ESPALIER_UNROLL
            for (int j = 0; j < 4; ++j) {
                if (j >= group.size[1]) continue;
                Sums line = {};
                ESPALIER_UNROLL
                for (int i = 0; i < n; ++i) addEntry(line, factors.a[i], entries[slot + i]);
                slot += n;
                addSums(plane, factors.b[j], line);
            }
            addSums(all, factors.c[k], plane);
        }
        return all;
    }

    /// Does the same for coefficients of a spline and powers of parameters: the first factor of
    /// each axis is 1.
    ESPALIER_DEVICE static Sums multiplyPowers(const Group& group, const OwnFactors& factors,
                                               const Entries<width, Real>& entries) {
        const Index sizeB = coefficientCount(group.size[1]),
                    sizeC = coefficientCount(group.size[2]);
        Sums all;
        Index slot = 0;
        ESPALIER_UNROLL
        for (int k = 0; k < 4; ++k) {
            if (k >= sizeC) continue;
            Sums plane;
            ESPALIER_UNROLL
            for (int j = 0; j < 4; ++j) {
                if (j >= sizeB) continue;
                Sums line = everywhere(entries[slot]);
                ESPALIER_UNROLL
                for (int i = 1; i < n; ++i) addEntry(line, factors.a[i], entries[slot + i]);
                slot += n;
                if (j == 0)
                    plane = line;
                else
                    addSums(plane, factors.b[j], line);
            }
            if (k == 0)
                all = plane;
            else
                addSums(all, factors.c[k], plane);
        }
        return all;
    }

    /// Returns the components of an entry for each row of a lane.
    ESPALIER_DEVICE static Sums everywhere(const Values<Real, width>& entry) {
        Sums sums;
        ESPALIER_UNROLL
        for (int c = 0; c < width; ++c) {
            ESPALIER_UNROLL
            for (int q = 0; q < kRowsPerLane<Real>; ++q) sums.of[c].of[q] = entry.of[c];
        }
        return sums;
    }

    ESPALIER_DEVICE Sums multiplyAny(const Group& group, Index firstRow, int lane,
                                     const Entries<width, Real>& entries) const {
        const Index sizeA = group.size[0], sizeB = group.size[1], sizeC = group.size[2];
        const Real* numbers =
            numberOf(table, group, firstRow + lane * kRowsPerLane<Real>, sizeA + sizeB + sizeC, 0);
        // Not Warp::load(), since the factors of axis 0 are read again for each line.
        const auto factor = [&](Index which) -> const RowNumbers<Real>& {
            return *reinterpret_cast<const RowNumbers<Real>*>(numbers + which * kLanes<Real>);
        };
        Sums all = {};
        for (Index k = 0; k < sizeC; ++k) {
            Sums plane = {};
            for (Index j = 0; j < sizeB; ++j) {
                Sums line = {};
                for (Index i = 0; i < sizeA; ++i)
                    addEntry(line, factor(i), entries[(k * sizeB + j) * sizeA + i]);
                addSums(plane, factor(sizeA + j), line);
            }
            addSums(all, factor(sizeA + sizeB + k), plane);
        }
        return all;
    }
};

/// Evaluates rows with their own columns. Several lanes work on a row together.
template <int width, class Real>
struct SparseKernel {
    static constexpr int kBlocks = 8;

    SparseRows<Real> rows;
    Index first, last;  ///< the range in `rows`
    Evaluation<Real> evaluation;
    Components components;

    Index warpCount() const {
        const Index rowsPerWarp = kWarp >> rows.lanesLog2;
        return (last - first + rowsPerWarp - 1) / rowsPerWarp;
    }
    unsigned sharedBytes() const { return 0; }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char*) const {
        for (Offset i = 0; i < components.count; ++i)
            evaluate(warp, index, components.from + i * width);
    }

private:
    using Sums = Values<Real, width>;

    /// Returns the position in `rows` of the row of a lane; `last` or more if the lane has none.
    ESPALIER_DEVICE Offset rowOf(Index index, int lane) const {
        return first + Offset{index} * (kWarp >> rows.lanesLog2) + (lane >> rows.lanesLog2);
    }

    /// Returns the number of a row in the table.
    ESPALIER_DEVICE Index numberOfRow(Offset row) const {
        return rows.rows == nullptr ? static_cast<Index>(row) : rows.rows[row];
    }

    ESPALIER_DEVICE bool isInRange(Offset row) const {
        if (row >= last) return false;
        const Index number = numberOfRow(row);
        return number >= evaluation.first && number < evaluation.last;
    }

    template <class Warp>
    ESPALIER_DEVICE void evaluate(Warp& warp, Index index, Offset from) const {
        const Evaluation<Real>& e = evaluation;
        const int lanes = 1 << rows.lanesLog2;
        typename Warp::template PerLane<Sums> sums;
        warp.each([&](int lane) {
            Sums own = {};
            const Offset row = rowOf(index, lane);
            const bool isHere = isInRange(row);
            const Offset end = isHere ? rows.offsets[row + 1] : 0;
            Offset entry = isHere ? rows.offsets[row] + (lane & (lanes - 1)) : 0;
#if defined(__CUDACC__)
#pragma unroll 4
#endif
            for (; entry < end; entry += lanes) {
                const Real* values = e.source + rows.columns[entry] * e.sourceStride + from;
                const Real weight = rows.weights == nullptr ? Real{1} : rows.weights[entry];
                ESPALIER_UNROLL
                for (int c = 0; c < width; ++c)
                    own.of[c] = addProduct(own.of[c], weight, values[c]);
            }
            sums[lane] = own;
        });
        warp.sumOver(sums, lanes);
        warp.each([&](int lane) {
            const Offset row = rowOf(index, lane);
            if (!isInRange(row)) return;
            const Index number = numberOfRow(row);
            Real* to = e.destination + (number - e.destinationFirst) * e.destinationStride + from;
            ESPALIER_UNROLL
            for (int c = 0; c < width; ++c)
                if (((c ^ lane) & (lanes - 1)) == 0)
                    to[c] = withAddend(e, number, from + c, sums[lane].of[c]);
        });
    }
};

}  // namespace espalier::osd::device
