// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels/kernels.h>

#include "device_code.h"
#include "device_data.h"
#include "spline_weights.h"

// The kernels of GPUs, as functions of one warp. They are compiled for the device by
// cuda_launch.cu, and for the host by tests. Both give the same results to the last bit: every
// product is added by fma(), and every sum over lanes has a fixed order.
//
// A Warp has
//
//     each(f)            calls f(lane) for all lanes, and synchronizes them afterwards
//     PerLane<T>         a T for each lane: value[lane]
//     sumOver(v, lanes)  v: PerLane<Values<Real, n>>; gives each lane the sums over its group of
//                        `lanes` neighbours
//     sumAll(v)          n a multiple of kWarp: sets v[lane].of[t] to the sum of of[32 t + lane]
//                        over all lanes
//     load<T>(address)   loads a T of 16 bytes, aligned to 16, that is not soon read again
//     prefetch(address)
//
// Memory that a lane writes in one each() may be read by other lanes in the next each().
namespace espalier::osd::device {

using kernels::kLanes;

template <class Real, int count>
struct Values {
    Real of[count];
};

/// One number for each of the rows of a lane.
template <class Real>
struct alignas(16) RowNumbers {
    Real of[kRowsPerLane<Real>];
};

/// Four components, which one instruction loads.
template <class Real>
struct alignas(16) Quad {
    Real of[4];
};

/// The source entries of some columns, in the shared memory of a warp.
template <int width, class Real>
class Entries {
public:
    static constexpr int kQuads = (width + 3) / 4;

    ESPALIER_DEVICE explicit Entries(unsigned char* shared)
        : quads_(reinterpret_cast<Quad<Real>*>(shared)) {}

    static constexpr unsigned bytes(Index columnCount) {
        return static_cast<unsigned>(columnCount) * kQuads * sizeof(Quad<Real>);
    }

    template <class Warp>
    ESPALIER_DEVICE void gather(Warp& warp, const Index* columns, Index columnCount,
                                const Evaluation<Real>& e, Offset from) const {
        warp.each([&](int lane) {
            for (Index i = lane; i < columnCount * width; i += kWarp) {
                const Index k = i / width, c = i % width;
                quads_[k * kQuads + c / 4].of[c % 4] =
                    e.source[columns[k] * e.sourceStride + from + c];
            }
        });
    }

    ESPALIER_DEVICE Values<Real, width> operator[](Index k) const {
        Values<Real, width> entry;
        ESPALIER_UNROLL
        for (int q = 0; q < kQuads; ++q) {
            const Quad<Real> quad = quads_[k * kQuads + q];
            ESPALIER_UNROLL
            for (int c = 4 * q; c < width && c < 4 * q + 4; ++c) entry.of[c] = quad.of[c % 4];
        }
        return entry;
    }

private:
    Quad<Real>* quads_;
};

/// Collects the results of the rows of a warp in shared memory. From there, consecutive lanes write
/// consecutive numbers of the destination.
template <int width, class Real>
class Results {
public:
    static constexpr int kRows = kWarp * kRowsPerLane<Real>;
    static constexpr unsigned kBytes = kRows * (width | 1) * sizeof(Real);

    ESPALIER_DEVICE explicit Results(unsigned char* shared)
        : numbers_(reinterpret_cast<Real*>(shared)) {}

    ESPALIER_DEVICE void set(int lane, const Values<RowNumbers<Real>, width>& sums) const {
        ESPALIER_UNROLL
        for (int q = 0; q < kRowsPerLane<Real>; ++q) {
            ESPALIER_UNROLL
            for (int c = 0; c < width; ++c)
                numbers_[(lane * kRowsPerLane<Real> + q) * kPitch + c] = sums.of[c].of[q];
        }
    }

    /// \param count number of rows, at most kRows
    template <class Warp>
    ESPALIER_DEVICE void store(Warp& warp, const Index* rows, Index count,
                               const Evaluation<Real>& e, Offset from) const {
        warp.each([&](int lane) {
            for (Index i = lane; i < count * width; i += kWarp) {
                const Index r = i / width, c = i % width, row = rows[r];
                if (row >= e.first && row < e.last)
                    e.destination[(row - e.destinationFirst) * e.destinationStride + from + c] =
                        numbers_[r * kPitch + c];
            }
        });
    }

private:
    static constexpr int kPitch = width | 1;  ///< odd, so that there are fewer bank conflicts

    Real* numbers_;
};

template <class Real>
ESPALIER_DEVICE bool isAnyInRange(const Group& group, const Evaluation<Real>& e) {
    return group.highest >= e.first && group.lowest < e.last;
}

/// Returns how many numbers a row of an outer product has.
ESPALIER_DEVICE inline Index productLength(const Group& group) {
    return group.spline == kNoSpline ? group.size[0] + group.size[1] + group.size[2] : 3;
}

/// Returns the address of number k of a row of a group; each row has `length` numbers. The same
/// number of the next rows, up to the end of the panel, follows it directly.
template <class Real>
ESPALIER_DEVICE const Real* numberOf(const Groups<Real>& table, const Group& group, Index row,
                                     Index length, Index k) {
    constexpr Index lanes = kLanes<Real>;
    return table.numbers + group.firstNumber + Offset{row / lanes} * lanes * length + k * lanes +
           row % lanes;
}

/// For each row of a lane, adds its number times the components of an entry.
template <int width, class Real>
ESPALIER_DEVICE void addEntry(Values<RowNumbers<Real>, width>& sums, const RowNumbers<Real>& number,
                              const Values<Real, width>& entry) {
    ESPALIER_UNROLL
    for (int c = 0; c < width; ++c) {
        ESPALIER_UNROLL
        for (int q = 0; q < kRowsPerLane<Real>; ++q)
            sums.of[c].of[q] = addProduct(sums.of[c].of[q], number.of[q], entry.of[c]);
    }
}

/// For each row of a lane, adds its number times sums of the same row.
template <int width, class Real>
ESPALIER_DEVICE void addSums(Values<RowNumbers<Real>, width>& sums, const RowNumbers<Real>& number,
                             const Values<RowNumbers<Real>, width>& others) {
    ESPALIER_UNROLL
    for (int c = 0; c < width; ++c) {
        ESPALIER_UNROLL
        for (int q = 0; q < kRowsPerLane<Real>; ++q)
            sums.of[c].of[q] = addProduct(sums.of[c].of[q], number.of[q], others.of[c].of[q]);
    }
}

/// Evaluates rows that share their columns. Each warp evaluates one task. A lane loads one weight
/// of each of its rows at a time.
template <int width, class Real>
struct PanelKernel {
    static constexpr Index kColumns = 64;  ///< number of columns whose entries are in shared memory
                                           ///< at a time

    Groups<Real> table;
    TaskList tasks;
    Evaluation<Real> evaluation;
    Components components;

    Index warpCount() const { return tasks.count; }
    unsigned sharedBytes() const {
        return Entries<width, Real>::bytes(kColumns) + Results<width, Real>::kBytes;
    }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char* shared) const {
        const Task task = tasks.tasks[index];
        const Group group = table.groups[task.group];
        if (!isAnyInRange(group, evaluation)) return;
        for (Offset i = 0; i < components.count; ++i)
            evaluate(warp, group, task.part, components.from + i * width, shared);
    }

private:
    using Sums = Values<RowNumbers<Real>, width>;

    template <class Warp>
    ESPALIER_DEVICE void evaluate(Warp& warp, const Group& group, Index firstRow, Offset from,
                                  unsigned char* shared) const {
        const Entries<width, Real> entries(shared + Results<width, Real>::kBytes);
        const Results<width, Real> results(shared);
        typename Warp::template PerLane<Sums> sums;
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
        const Index rowsLeft = group.rowCount - firstRow;
        results.store(warp, table.rows + group.firstRow + firstRow,
                      rowsLeft < results.kRows ? rowsLeft : results.kRows, evaluation, from);
    }
};

/// The factors of the rows of a lane, for an outer product of at most 4 columns along each axis.
template <int n, class Real>
struct Factors {
    RowNumbers<Real> a[n], b[4], c[4];
};

/// Evaluates rows that are outer products: sums along axis 0, then sums of these along axis 1, then
/// along axis 2. Each warp evaluates one task.
///
/// Memory bandwidth limits the speed: for 128 rows of three floats, sm_90 has 1,800 instructions,
/// 1,008 of them for the products, which take a multiprocessor 460 cycles; reading and writing
/// their 8 KB takes it 630 cycles on an H100.
///
/// \tparam n the size along axis 0, where the other sizes are at most 4: all factors are loaded at
///         once, and once for any number of components. 0 allows any sizes
template <int n, int width, class Real>
struct ProductKernel {
    Groups<Real> table;
    TaskList tasks;
    Index maxColumns;  ///< of any outer product, if n is 0
    Evaluation<Real> evaluation;
    Components components;

    Index warpCount() const { return tasks.count; }
    unsigned sharedBytes() const {
        // The other sizes are at most n.
        return Entries<width, Real>::bytes(n > 0 ? n * n * n : maxColumns) +
               Results<width, Real>::kBytes;
    }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char* shared) const {
        const Task task = tasks.tasks[index];
        const Group group = table.groups[task.group];
        if (!isAnyInRange(group, evaluation)) return;
        const Results<width, Real> results(shared);
        const Entries<width, Real> entries(shared + Results<width, Real>::kBytes);
        const Index rowsLeft = group.rowCount - task.part;
        const Index rowCount = rowsLeft < results.kRows ? rowsLeft : results.kRows;
        typename Warp::template PerLane<Factors<(n > 0 ? n : 1), Real>> factors;
        if constexpr (n > 0)
            warp.each([&](int lane) { load(warp, group, task.part, lane, factors[lane]); });
        for (Offset i = 0; i < components.count; ++i) {
            const Offset from = components.from + i * width;
            entries.gather(warp, table.columns + group.firstColumn, group.columnCount, evaluation,
                           from);
            warp.each([&](int lane) {
                if (lane * kRowsPerLane<Real> >= rowCount) return;
                if constexpr (n > 0)
                    results.set(lane, multiply(group, factors[lane], entries));
                else
                    results.set(lane, multiplyAny(group, task.part, lane, entries));
            });
            results.store(warp, table.rows + group.firstRow + task.part, rowCount, evaluation,
                          from);
        }
    }

private:
    using Sums = Values<RowNumbers<Real>, width>;

    template <class Warp>
    ESPALIER_DEVICE void load(Warp& warp, const Group& group, Index firstRow, int lane,
                              Factors<(n > 0 ? n : 1), Real>& factors) const {
        const Index row = firstRow + lane * kRowsPerLane<Real>;
        if (row >= group.rowCount) return;
        const Index m = group.size[1], l = group.size[2];
        const Real* number = numberOf(table, group, row, productLength(group), 0);
        const auto next = [&](RowNumbers<Real>& to) {
            to = warp.template load<RowNumbers<Real>>(number);
            number += kLanes<Real>;
        };
        if (group.spline != kNoSpline) {
            RowNumbers<Real> t[3];
            ESPALIER_UNROLL
            for (int axis = 0; axis < 3; ++axis) next(t[axis]);
            setWeights(group.spline, n, t[0], factors.a);
            setWeights(group.spline, m, t[1], factors.b);
            setWeights(group.spline, l, t[2], factors.c);
            return;
        }
        ESPALIER_UNROLL
        for (int i = 0; i < n; ++i) next(factors.a[i]);
        ESPALIER_UNROLL
        for (int j = 0; j < 4; ++j)
            if (j < m) next(factors.b[j]);
        ESPALIER_UNROLL
        for (int k = 0; k < 4; ++k)
            if (k < l) next(factors.c[k]);
    }

    /// Computes the factors of one axis for the rows of a lane.
    template <int count>
    ESPALIER_DEVICE static void setWeights(Index spline, Index size, const RowNumbers<Real>& t,
                                           RowNumbers<Real> (&factors)[count]) {
        ESPALIER_UNROLL
        for (int q = 0; q < kRowsPerLane<Real>; ++q) {
            Real weights[4];
            splineWeights(spline, size, t.of[q], weights);
            ESPALIER_UNROLL
            for (int i = 0; i < count; ++i) factors[i].of[q] = weights[i];
        }
    }

    ESPALIER_DEVICE static Sums multiply(const Group& group,
                                         const Factors<(n > 0 ? n : 1), Real>& factors,
                                         const Entries<width, Real>& entries) {
        Sums all = {};
        Index place = 0;
        ESPALIER_UNROLL
        for (int k = 0; k < 4; ++k) {
            if (k >= group.size[2]) continue;
            Sums plane = {};
            ESPALIER_UNROLL
            for (int j = 0; j < 4; ++j) {
                if (j >= group.size[1]) continue;
                Sums line = {};
                ESPALIER_UNROLL
                for (int i = 0; i < n; ++i) addEntry(line, factors.a[i], entries[place + i]);
                place += n;
                addSums(plane, factors.b[j], line);
            }
            addSums(all, factors.c[k], plane);
        }
        return all;
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
            Real* to = e.destination +
                       (numberOfRow(row) - e.destinationFirst) * e.destinationStride + from;
            ESPALIER_UNROLL
            for (int c = 0; c < width; ++c)
                if (((c ^ lane) & (lanes - 1)) == 0) to[c] = sums[lane].of[c];
        });
    }
};

/// `count`, rounded up to a multiple of kWarp, for Warp::sumAll().
template <int count>
inline constexpr int kRoundedUpToWarp = (count + kWarp - 1) / kWarp* kWarp;

/// Computes Σ weight · value over the rows of a group, for a tile of 16 of its columns at a time.
/// Each task is a tile. Column k of all groups is row k of evaluation.destination.
template <int width, class Real>
struct AdjointPanelKernel {
    static constexpr Index kTile = 16;

    Groups<Real> table;
    TaskList tasks;
    Evaluation<Real> evaluation;
    Components components;

    static Index tileCount(const Group& group) { return (group.columnCount + kTile - 1) / kTile; }

    Index warpCount() const { return tasks.count; }
    unsigned sharedBytes() const { return 0; }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char*) const {
        const Task task = tasks.tasks[index];
        const Group group = table.groups[task.group];
        for (Offset i = 0; i < components.count; ++i)
            evaluate(warp, group, task.part * kTile, components.from + i * width);
    }

private:
    template <class Warp>
    ESPALIER_DEVICE void evaluate(Warp& warp, const Group& group, Index firstColumn,
                                  Offset from) const {
        const Evaluation<Real>& e = evaluation;
        constexpr int kSums = kRoundedUpToWarp<kTile * width>;
        using Sums = Values<Real, kSums>;
        typename Warp::template PerLane<Sums> sums;
        const Index columns = group.columnCount - firstColumn;
        warp.each([&](int lane) {
            Sums own = {};
            for (Index r = lane; r < group.rowCount; r += kWarp) {
                const Real* values =
                    e.source + table.rows[group.firstRow + r] * e.sourceStride + from;
                Values<Real, width> value;
                ESPALIER_UNROLL
                for (int c = 0; c < width; ++c) value.of[c] = values[c];
                const Real* weight = numberOf(table, group, r, group.columnCount, firstColumn);
                ESPALIER_UNROLL
                for (int k = 0; k < kTile; ++k) {
                    const Real own_k = k < columns ? weight[k * kLanes<Real>] : Real{0};
                    ESPALIER_UNROLL
                    for (int c = 0; c < width; ++c)
                        own.of[k * width + c] =
                            addProduct(own.of[k * width + c], own_k, value.of[c]);
                }
            }
            sums[lane] = own;
        });
        warp.sumAll(sums);
        warp.each([&](int lane) {
            ESPALIER_UNROLL
            for (int t = 0; t < kSums / kWarp; ++t) {
                const int i = t * kWarp + lane, k = i / width;
                if (k < kTile && k < columns)
                    e.destination[(group.firstColumn + firstColumn + k) * e.destinationStride +
                                  from + i % width] = sums[lane].of[t];
            }
        });
    }
};

/// Does the same for outer products. A tile is 4 × 4 columns in one plane of their box.
template <int width, class Real>
struct AdjointProductKernel {
    Groups<Real> table;
    TaskList tasks;
    Evaluation<Real> evaluation;
    Components components;

    static Index tileCount(const Group& group) {
        return (group.size[0] + 3) / 4 * ((group.size[1] + 3) / 4) * group.size[2];
    }

    Index warpCount() const { return tasks.count; }
    unsigned sharedBytes() const { return 0; }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char*) const {
        const Task task = tasks.tasks[index];
        const Group group = table.groups[task.group];
        for (Offset i = 0; i < components.count; ++i)
            evaluate(warp, group, task.part, components.from + i * width);
    }

private:
    /// How many rows ahead to prefetch. The warps of a group run side by side and read the same
    /// factors, so without early prefetches few bytes would be in flight.
    static constexpr Index kRowsAhead = 4 * kWarp;

    template <class Warp>
    ESPALIER_DEVICE void prefetch(Warp& warp, const Group& group, Index row, Index length) const {
        constexpr Index lanes = kLanes<Real>, bytesPerLine = 128;
        // Each lane prefetches one cache line of the numbers of a warp's rows.
        constexpr Index numbersPerLine = bytesPerLine / static_cast<Index>(sizeof(Real));
        const Index first = row / kWarp * kWarp;
        const Index panels = (group.rowCount - first + lanes - 1) / lanes;
        const Index wanted = panels < kWarp / lanes ? panels : kWarp / lanes;
        for (Index i = (row - first) * numbersPerLine; i < wanted * lanes * length;
             i += kWarp * numbersPerLine)
            warp.prefetch(numberOf(table, group, first, length, 0) + i);
    }

    /// Loads the factors of a row for a tile: 4 of each of the first two axes, with zeros for those
    /// that the group lacks, and returns one of the third.
    ESPALIER_DEVICE Real loadFactors(const Group& group, Index row, Index firstI, Index firstJ,
                                     Index plane, Real (&a)[4], Real (&b)[4]) const {
        const Index n = group.size[0], m = group.size[1];
        const Real* factor = numberOf(table, group, row, productLength(group), 0);
        ESPALIER_UNROLL
        for (int i = 0; i < 4; ++i)
            a[i] = firstI + i < n ? factor[(firstI + i) * kLanes<Real>] : Real{0};
        ESPALIER_UNROLL
        for (int j = 0; j < 4; ++j)
            b[j] = firstJ + j < m ? factor[(n + firstJ + j) * kLanes<Real>] : Real{0};
        return factor[(n + m + plane) * kLanes<Real>];
    }

    /// Computes the factors of a row of a spline; its planes have one tile.
    ESPALIER_DEVICE Real setWeights(const Group& group, Index row, Index plane, Real (&a)[4],
                                    Real (&b)[4]) const {
        const Real* t = numberOf(table, group, row, productLength(group), 0);
        Real c[4];
        splineWeights(group.spline, group.size[0], t[0], a);
        splineWeights(group.spline, group.size[1], t[kLanes<Real>], b);
        splineWeights(group.spline, group.size[2], t[2 * kLanes<Real>], c);
        // Not c[plane]: an array with variable indices would be in memory.
        return plane == 0 ? c[0] : plane == 1 ? c[1] : plane == 2 ? c[2] : c[3];
    }

    template <class Warp>
    ESPALIER_DEVICE void evaluate(Warp& warp, const Group& group, Index tile, Offset from) const {
        const Evaluation<Real>& e = evaluation;
        constexpr int kSums = kRoundedUpToWarp<16 * width>;
        using Sums = Values<Real, kSums>;
        typename Warp::template PerLane<Sums> sums;
        const Index n = group.size[0], m = group.size[1];
        const Index tilesPerLine = (n + 3) / 4, tilesPerPlane = tilesPerLine * ((m + 3) / 4);
        const Index firstI = tile % tilesPerLine * 4,
                    firstJ = tile % tilesPerPlane / tilesPerLine * 4;
        const Index plane = tile / tilesPerPlane;
        warp.each([&](int lane) {
            Sums own = {};
            for (Index r = lane; r < group.rowCount; r += kWarp) {
                if (r + kRowsAhead < group.rowCount)
                    prefetch(warp, group, r + kRowsAhead, productLength(group));
                const Real* values =
                    e.source + table.rows[group.firstRow + r] * e.sourceStride + from;
                Real a[4], bs[4], c;
                if (group.spline != kNoSpline)
                    c = setWeights(group, r, plane, a, bs);
                else
                    c = loadFactors(group, r, firstI, firstJ, plane, a, bs);
                Values<Real, width> value;
                ESPALIER_UNROLL
                for (int d = 0; d < width; ++d) value.of[d] = c * values[d];
                ESPALIER_UNROLL
                for (int j = 0; j < 4; ++j) {
                    if (firstJ + j >= m) continue;
                    const Real b = bs[j];
                    ESPALIER_UNROLL
                    for (int d = 0; d < width; ++d) {
                        const Real lineValue = b * value.of[d];
                        ESPALIER_UNROLL
                        for (int i = 0; i < 4; ++i) {
                            Real& sum = own.of[(j * 4 + i) * width + d];
                            sum = addProduct(sum, a[i], lineValue);
                        }
                    }
                }
            }
            sums[lane] = own;
        });
        warp.sumAll(sums);
        warp.each([&](int lane) {
            ESPALIER_UNROLL
            for (int t = 0; t < kSums / kWarp; ++t) {
                const int at = t * kWarp + lane, k = at / width;
                const Index i = firstI + k % 4, j = firstJ + k / 4;
                if (k < 16 && i < n && j < m)
                    e.destination[(group.firstColumn + (plane * m + j) * n + i) *
                                      e.destinationStride +
                                  from + at % width] = sums[lane].of[t];
            }
        });
    }
};

/// Writes the values of some entries: component c of entry rows[i] becomes values[i · length + c].
template <class Real>
struct ScatterKernel {
    const Index* rows;
    Index count;
    const Real* values;
    Evaluation<Real> evaluation;

    Index warpCount() const { return (count + kWarp - 1) / kWarp; }
    unsigned sharedBytes() const { return 0; }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char*) const {
        const Evaluation<Real>& e = evaluation;
        warp.each([&](int lane) {
            const Offset i = Offset{index} * kWarp + lane;
            if (i >= count) return;
            for (Offset c = 0; c < e.length; ++c)
                e.destination[rows[i] * e.destinationStride + c] = values[i * e.length + c];
        });
    }
};

}  // namespace espalier::osd::device
