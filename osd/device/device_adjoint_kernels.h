// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "device_rows.h"
#include "spline_weights.h"
#include "warp_memory.h"

// The kernels of the adjoint that sum over the rows of groups, as functions of one warp
// (device_kernels.h).
namespace espalier::osd::device {

/// `count`, rounded up to a multiple of kWarp, for Warp::sumAll().
template <int count>
inline constexpr int kRoundedUpToWarp = (count + kWarp - 1) / kWarp* kWarp;

/// Visits the rows of a group for the adjoint, kWarp · kRowsPerLane at a time. While these are
/// used, the next are copied to shared memory.
///
/// In place of rows that the group lacks, at its end, the last row is visited again; the weights of
/// these must be 0, as the padding of panels is.
///
/// \tparam count how many numbers of each row are used
template <int count, int width, class Real>
class RowVisit {
public:
    static constexpr Index kRows = kWarp * kRowsPerLane<Real>;
    static constexpr unsigned kBytes =
        2 * (StagedNumbers<count, Real>::kBytes + kRows * width * sizeof(Real));

    /// \param length how many numbers each row has
    /// \param copyNumbers copyNumbers(lane, staged, numbers) begins to copy numbers of the rows of
    ///        a lane; `numbers` is the address of number 0 of the first of these rows
    /// \param use use(lane, row, staged, values) with these numbers and the values of the entries
    template <class Warp, class CopyNumbers, class Use>
    ESPALIER_DEVICE static void run(Warp& warp, const Groups<Real>& table, const Group& group,
                                    Index length, const Evaluation<Real>& e, Offset from,
                                    unsigned char* shared, CopyNumbers copyNumbers, Use use) {
        const Index* const rows = table.rows + group.firstRow;
        const Index rowCount = group.rowCount;
        const Real* const source = e.source + from;
        const Offset distance = e.sourceStride * Offset{sizeof(Real)};
        /// The numbers and the rows that a lane copies in the next step.
        struct Next {
            const Real* numbers;
            // Loaded one step earlier, because the values wait for them.
            Index rows[kRowsPerLane<Real>];
        };
        typename Warp::template PerLane<Next> next;
        const auto loadRows = [&](int lane, Index first) {
            ESPALIER_UNROLL
            for (Index q = 0; q < kRowsPerLane<Real>; ++q) {
                const Index r = first + q * kWarp + lane;
                next[lane].rows[q] = rows[r < rowCount ? r : rowCount - 1];
            }
        };
        const auto halfOf = [&](Index first) { return shared + first / kRows % 2 * (kBytes / 2); };
        const auto valuesIn = [](unsigned char* half) {
            return reinterpret_cast<Real*>(half + StagedNumbers<count, Real>::kBytes);
        };
        const auto copy = [&](int lane, Index first) {
            unsigned char* const half = halfOf(first);
            if (first + lane * kRowsPerLane<Real> < rowCount)
                copyNumbers(lane, StagedNumbers<count, Real>(half), next[lane].numbers);
            next[lane].numbers += Offset{kRows} * length;
            Real* const to = valuesIn(half) + lane * width;
            [&]<int... i>(std::integer_sequence<int, i...>) {
                constexpr int size = sizeof(Real), step = kWarp * width * size;
                (warp.template copy<i / width * step + i % width * size, i % width * size>(
                     to, entryAt(source, distance, next[lane].rows[i / width])),
                 ...);
            }
            (std::make_integer_sequence<int, kRowsPerLane<Real> * width>());
            loadRows(lane, first + kRows);
        };
        warp.each([&](int lane) {
            next[lane].numbers = numberOf(table, group, lane * kRowsPerLane<Real>, length, 0);
            loadRows(lane, 0);
            copy(lane, 0);
        });
        for (Index first = 0; first < rowCount; first += kRows) {
            warp.waitForCopies();
            if (first + kRows < rowCount) warp.each([&](int lane) { copy(lane, first + kRows); });
            warp.each([&](int lane) {
                const Index row = first + lane * kRowsPerLane<Real>;
                if (row >= rowCount) return;
                unsigned char* const half = halfOf(first);
                const auto* const packed =
                    reinterpret_cast<const RowNumbers<Real>*>(valuesIn(half)) + lane * width;
                Values<RowNumbers<Real>, width> values;
                ESPALIER_UNROLL
                for (int i = 0; i < width; ++i) {
                    const RowNumbers<Real> loaded = packed[i];
                    ESPALIER_UNROLL
                    for (int q = 0; q < kRowsPerLane<Real>; ++q) {
                        const int at = i * kRowsPerLane<Real> + q;
                        values.of[at % width].of[at / width] = loaded.of[q];
                    }
                }
                use(lane, row, StagedNumbers<count, Real>(half), values);
            });
        }
    }
};

/// Computes Σ weight · value over the rows of a group, for a tile of 16 of its columns at a time.
/// Each task is a tile. Column k of all groups is row k of evaluation.destination.
template <int width, class Real>
struct AdjointPanelKernel {
    static constexpr int kBlocks = 4;
    static constexpr Index kTile = 16;

    Groups<Real> table;
    TaskList tasks;
    Evaluation<Real> evaluation;
    Components components;

    static Index tileCount(const Group& group) { return (group.columnCount + kTile - 1) / kTile; }

    Index warpCount() const { return tasks.count; }
    unsigned sharedBytes() const { return Visit::kBytes; }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char* shared) const {
        const Task task = tasks.tasks[index];
        const Group& group = table.groups[task.group];
        for (Offset i = 0; i < components.count; ++i)
            evaluate(warp, group, task.part * kTile, components.from + i * width, shared);
    }

private:
    using Visit = RowVisit<kTile, width, Real>;

    template <class Warp>
    ESPALIER_DEVICE void evaluate(Warp& warp, const Group& group, Index firstColumn, Offset from,
                                  unsigned char* shared) const {
        const Evaluation<Real>& e = evaluation;
        constexpr int kSums = kRoundedUpToWarp<kTile * width>;
        using Sums = Values<Real, kSums>;
        typename Warp::template PerLane<Sums> sums;
        const Index columns = group.columnCount - firstColumn;
        warp.each([&](int lane) { sums[lane] = {}; });
        Visit::run(
            warp, table, group, group.columnCount, e, from, shared,
            [&](int lane, const auto& staged, const Real* numbers) {
                staged.template copy<kTile>(warp, lane, numbers + firstColumn * kLanes<Real>,
                                            columns, 0);
            },
            [&](int lane, Index, const auto& staged, const auto& values) {
                ESPALIER_UNROLL
                for (Index k = 0; k < kTile; ++k)
                    if (k < columns) addProducts(sums[lane], k * width, staged(lane, k), values);
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
/// \tparam isSpline true for groups whose rows have parameters
template <bool isSpline, int width, class Real>
struct AdjointProductKernel {
    static constexpr int kBlocks = isSpline ? 3 : 4;

    Groups<Real> table;
    TaskList tasks;
    Evaluation<Real> evaluation;
    Components components;

    static Index tileCount(const Group& group) {
        return (group.size[0] + 3) / 4 * ((group.size[1] + 3) / 4) * group.size[2];
    }

    Index warpCount() const { return tasks.count; }
    unsigned sharedBytes() const { return Visit::kBytes; }

    template <class Warp>
    ESPALIER_DEVICE void operator()(Warp& warp, Index index, unsigned char* shared) const {
        const Task task = tasks.tasks[index];
        const Group& group = table.groups[task.group];
        for (Offset i = 0; i < components.count; ++i)
            evaluate(warp, group, task.part, components.from + i * width, shared);
    }

private:
    using Visit = RowVisit<9, width, Real>;

    /// Returns how many factors of an axis belong to a tile.
    ESPALIER_DEVICE static Index countFrom(Index first, Index size) {
        return size - first < 4 ? size - first : 4;
    }

    /// Replaces the parameters of rows of a spline by factors; its planes have one tile.
    ESPALIER_DEVICE void setWeights(const Group& group, Index row, Index plane,
                                    RowNumbers<Real> (&factors)[9]) const {
        ESPALIER_UNROLL
        for (int q = 0; q < kRowsPerLane<Real>; ++q) {
            Real a[4], b[4], c[4];
            splineWeights(group.spline, group.size[0], factors[0].of[q], a);
            splineWeights(group.spline, group.size[1], factors[1].of[q], b);
            splineWeights(group.spline, group.size[2], factors[2].of[q], c);
            ESPALIER_UNROLL
            for (int i = 0; i < 4; ++i) {
                factors[i].of[q] = a[i];
                factors[4 + i].of[q] = b[i];
            }
            // Not c[plane]: an array with variable indices would be in memory.
            const Real own = plane == 0 ? c[0] : plane == 1 ? c[1] : plane == 2 ? c[2] : c[3];
            factors[8].of[q] = row + q < group.rowCount ? own : Real{0};
        }
    }

    template <class Warp>
    ESPALIER_DEVICE void evaluate(Warp& warp, const Group& group, Index tile, Offset from,
                                  unsigned char* shared) const {
        const Evaluation<Real>& e = evaluation;
        constexpr int kSums = kRoundedUpToWarp<16 * width>;
        using Sums = Values<Real, kSums>;
        typename Warp::template PerLane<Sums> sums;
        const Index n = group.size[0], m = group.size[1];
        const Index tilesPerLine = (n + 3) / 4, tilesPerPlane = tilesPerLine * ((m + 3) / 4);
        const Index firstI = tile % tilesPerLine * 4,
                    firstJ = tile % tilesPerPlane / tilesPerLine * 4;
        const Index plane = tile / tilesPerPlane;
        warp.each([&](int lane) { sums[lane] = {}; });
        Visit::run(
            warp, table, group, productLength(group), e, from, shared,
            [&](int lane, const auto& staged, const Real* numbers) {
                if constexpr (isSpline) return staged.template copy<3>(warp, lane, numbers, 3, 0);
                staged.template copy<4>(warp, lane, numbers + firstI * kLanes<Real>,
                                        countFrom(firstI, n), 0);
                staged.template copy<4>(warp, lane, numbers + (n + firstJ) * kLanes<Real>,
                                        countFrom(firstJ, m), 4);
                staged.template copy<1>(warp, lane, numbers + (n + m + plane) * kLanes<Real>, 1, 8);
            },
            [&](int lane, Index row, const auto& staged, const auto& values) {
                RowNumbers<Real> factors[9];
                ESPALIER_UNROLL
                for (int k = 0; k < 9; ++k) factors[k] = staged(lane, k);
                if constexpr (isSpline) setWeights(group, row, plane, factors);
                const auto planeValues = scaled(factors[8], values);
                ESPALIER_UNROLL
                for (int j = 0; j < 4; ++j) {
                    if (firstJ + j >= m) continue;
                    const auto lineValues = scaled(factors[4 + j], planeValues);
                    ESPALIER_UNROLL
                    for (int i = 0; i < 4; ++i)
                        if (firstI + i < n)
                            addProducts(sums[lane], (j * 4 + i) * width, factors[i], lineValues);
                }
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

}  // namespace espalier::osd::device
