// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

#include "device_rows.h"
#include "spline_weights.h"

// The data that a warp keeps in shared memory. device_kernels.h says what a Warp has.
namespace espalier::osd::device {

/// Four components, which one instruction loads.
template <class Real>
struct alignas(16) Quad {
    Real of[4];
};

/// Returns the address of an entry in two instructions. With a signed number, or a distance in
/// numbers, it would take more.
///
/// \param distance of consecutive entries, in bytes
/// \param number the number of the entry, not negative
template <class Real>
ESPALIER_DEVICE Real* entryAt(Real* first, Offset distance, Index number) {
    using Bytes = std::conditional_t<std::is_const_v<Real>, const char, char>;
    return reinterpret_cast<Real*>(reinterpret_cast<Bytes*>(first) +
                                   static_cast<std::uint64_t>(static_cast<std::uint32_t>(number)) *
                                       static_cast<std::uint64_t>(distance));
}

/// The source entries of some columns, in the shared memory of a warp.
template <int width, class Real>
class Entries {
public:
    static constexpr int kQuads = (width + 3) / 4;

    ESPALIER_DEVICE explicit Entries(unsigned char* shared)
        : quads_(reinterpret_cast<Quad<Real>*>(shared)) {}

    ESPALIER_DEVICE static constexpr unsigned bytes(Index columnCount) {
        return static_cast<unsigned>(columnCount) * kQuads * sizeof(Quad<Real>);
    }

    /// Loads the entries of some columns. A lane loads all its numbers before it stores the first
    /// one, so that they wait for memory together.
    template <class Warp>
    ESPALIER_DEVICE void gather(Warp& warp, const Index* columns, Index columnCount,
                                const Evaluation<Real>& e, Offset from) const {
        constexpr int kAtOnce = 2;  // 64 columns of a warp
        warp.each([&](int lane) {
            for (Index first = lane; first < columnCount; first += kAtOnce * kWarp) {
                Quad<Real> own[kAtOnce][kQuads] = {};
                ESPALIER_UNROLL
                for (int u = 0; u < kAtOnce; ++u) {
                    const Index k = first + u * kWarp;
                    const Real* values =
                        e.source + columns[k < columnCount ? k : first] * e.sourceStride + from;
                    ESPALIER_UNROLL
                    for (int c = 0; c < width; ++c) own[u][c / 4].of[c % 4] = values[c];
                }
                ESPALIER_UNROLL
                for (int u = 0; u < kAtOnce; ++u) {
                    const Index k = first + u * kWarp;
                    if (k >= columnCount) continue;
                    ESPALIER_UNROLL
                    for (int q = 0; q < kQuads; ++q) quads_[k * kQuads + q] = own[u][q];
                }
            }
        });
    }

    /// Gathers the entries of a cell of a spline and converts them to coefficients, in the order of
    /// an outer product of coefficientCount() numbers along each axis.
    template <class Warp>
    ESPALIER_DEVICE void gatherCoefficients(Warp& warp, const Index* columns,
                                            const Index (&size)[3], const Evaluation<Real>& e,
                                            Offset from) const {
        const Index stride[3] = {1, coefficientCount(size[0]),
                                 coefficientCount(size[0]) * coefficientCount(size[1])};
        warp.each([&](int lane) {
            for (Index k = lane; k < size[0] * size[1] * size[2]; k += kWarp) {
                const Real* values = e.source + columns[k] * e.sourceStride + from;
                Quad<Real> own = {};
                ESPALIER_UNROLL
                for (int c = 0; c < width; ++c) own.of[c] = values[c];
                quads_[k % size[0] + k / size[0] % size[1] * stride[1] +
                       k / (size[0] * size[1]) * stride[2]] = own;
            }
        });
        // Each lane converts the columns of a line along the axis. Lines along an axis lie side by
        // side along the two others, of which the first have been converted.
        Index first = size[1], second = size[2];
        ESPALIER_UNROLL
        for (int axis = 0; axis < 3; ++axis) {
            const int one = axis == 0 ? 1 : 0, other = axis == 2 ? 1 : 2;
            warp.each([&](int lane) {
                for (Index line = lane; line < first * second; line += kWarp) {
                    Quad<Real>* const to =
                        quads_ + line % first * stride[one] + line / first * stride[other];
                    convertLine(to, stride[axis], size[axis]);
                }
            });
            if (axis == 0)
                first = coefficientCount(size[0]);
            else
                second = coefficientCount(size[1]);
        }
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
    ESPALIER_DEVICE static void convertLine(Quad<Real>* line, Index stride, Index size) {
        Quad<Real> own[4];
        ESPALIER_UNROLL
        for (int i = 0; i < 4; ++i)
            if (i < size) own[i] = line[i * stride];
        ESPALIER_UNROLL
        for (int c = 0; c < width; ++c) {
            Real p[4] = {own[0].of[c], own[1].of[c], own[2].of[c], own[3].of[c]};
            columnsToCoefficients(size, p);
            ESPALIER_UNROLL
            for (int i = 0; i < 4; ++i) own[i].of[c] = p[i];
        }
        ESPALIER_UNROLL
        for (int i = 0; i < 4; ++i)
            if (i < coefficientCount(size)) line[i * stride] = own[i];
    }

    Quad<Real>* quads_;
};

/// Begins to copy the numbers of the rows of a warp to shared memory. Missing rows get −1.
/// \param from the first of `count` row numbers
template <class Real, class Warp>
ESPALIER_DEVICE void copyRows(Warp& warp, const Index* from, Index count, Index* to) {
    warp.each([&](int lane) {
        [&]<int... q>(std::integer_sequence<int, q...>) {
            constexpr int step = kWarp * sizeof(Index);
            ((q * kWarp + lane < count
                  ? warp.template copy<q * step, q * step>(to + lane, from + lane)
                  : void(to[q * kWarp + lane] = -1)),
             ...);
        }
        (std::make_integer_sequence<int, kRowsPerLane<Real>>());
    });
}

/// Collects the results of the rows of a warp in shared memory. From there, consecutive lanes write
/// consecutive numbers of the destination.
template <int width, class Real>
class Results {
public:
    static constexpr int kRows = kWarp * kRowsPerLane<Real>;
    /// Numbers of a lane; odd, so that all lanes write to different banks.
    static constexpr int kPitch = kRowsPerLane<Real> * width | 1;
    static constexpr unsigned kBytes = kWarp * kPitch * sizeof(Real);

    ESPALIER_DEVICE explicit Results(unsigned char* shared)
        : numbers_(reinterpret_cast<Real*>(shared)) {}

    ESPALIER_DEVICE void set(int lane, const Values<RowNumbers<Real>, width>& sums) const {
        ESPALIER_UNROLL
        for (int q = 0; q < kRowsPerLane<Real>; ++q) {
            ESPALIER_UNROLL
            for (int c = 0; c < width; ++c)
                numbers_[lane * kPitch + q * width + c] = sums.of[c].of[q];
        }
    }

    /// Writes the results of the rows that are in the range of the evaluation.
    /// \param numbersOfRows the row numbers of the warp, in shared memory; −1 for missing rows
    template <class Warp>
    ESPALIER_DEVICE void store(Warp& warp, const Index* numbersOfRows, const Evaluation<Real>& e,
                               Offset from) const {
        const Offset distance = e.destinationStride * Offset{sizeof(Real)};
        const auto rangeSize = static_cast<std::uint32_t>(e.last - e.first);
        warp.each([&](int lane) {
            // `width` numbers of each lane belong to kWarp rows.
            ESPALIER_UNROLL
            for (int s = 0; s < width; ++s) {
                const int i = s * kWarp + lane, c = i % width, first = i / width;
                const Index* const rows = numbersOfRows + first;
                const Real* const numbers = numbers_ + first / kRowsPerLane<Real> * kPitch +
                                            first % kRowsPerLane<Real> * width + c;
                Real* const to =
                    e.destination - e.destinationFirst * e.destinationStride + from + c;
                ESPALIER_UNROLL
                for (int q = 0; q < kRowsPerLane<Real>; ++q) {
                    const Index row = rows[q * kWarp];
                    const bool isStored = static_cast<std::uint32_t>(row - e.first) < rangeSize;
                    Real number = numbers[q * (kWarp / kRowsPerLane<Real>)*kPitch];
                    if (isStored) number = withAddend(e, row, from + c, number);
                    warp.storeIf(isStored, entryAt(to, distance, row), number);
                }
            }
        });
    }

private:
    Real* numbers_;
};

/// Copies some numbers of the rows of a warp to shared memory. There, each number of all rows comes
/// before the next number.
template <int count, class Real>
class StagedNumbers {
public:
    static constexpr Index kRows = kWarp * kRowsPerLane<Real>;
    static constexpr unsigned kBytes = kRows * count * sizeof(Real);

    ESPALIER_DEVICE explicit StagedNumbers(unsigned char* shared)
        : numbers_(reinterpret_cast<Real*>(shared)) {}

    /// Begins to copy some numbers of the rows of a lane.
    /// \tparam most maximum of `copied`
    /// \param from the address of the first of these numbers, of the first of these rows
    /// \param copied how many numbers
    /// \param first the slot of the first one among the numbers here
    template <int most, class Warp>
    ESPALIER_DEVICE void copy(Warp& warp, int lane, const Real* from, Index copied,
                              Index first) const {
        using Numbers = RowNumbers<Real>;
        auto* const to = reinterpret_cast<Numbers*>(slotOf(lane, first));
        const auto* const numbers = reinterpret_cast<const Numbers*>(from);
        [&]<int... k>(std::integer_sequence<int, k...>) {
            ((k < copied ? warp.template copy<k * kRows* int{sizeof(Real)},
                                              k * kLanes<Real>* int{sizeof(Real)}>(to, numbers)
                         : void()),
             ...);
        }
        (std::make_integer_sequence<int, most>());
    }

    /// Returns number k of the rows of a lane.
    ESPALIER_DEVICE const RowNumbers<Real>& operator()(int lane, Index k) const {
        return *reinterpret_cast<const RowNumbers<Real>*>(slotOf(lane, k));
    }

private:
    ESPALIER_DEVICE Real* slotOf(int lane, Index k) const {
        return numbers_ + k * kRows + lane * kRowsPerLane<Real>;
    }

    Real* numbers_;
};

}  // namespace espalier::osd::device
