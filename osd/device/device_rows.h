// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels/kernels.h>

#include <cstdint>

#include "device_code.h"
#include "device_data.h"

// The numbers of the rows of groups, in memory and in the registers of lanes. A lane has
// kRowsPerLane consecutive rows.
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

template <class Real>
ESPALIER_DEVICE bool isAnyInRange(const Group& group, const Evaluation<Real>& e) {
    return group.highest >= e.first && group.lowest < e.last;
}

/// Returns a result of a row with what the evaluation adds to it.
template <class Real>
ESPALIER_DEVICE Real withAddend(const Evaluation<Real>& e, Index row, Offset component,
                                Real result) {
    if (e.addend == nullptr) return result;
    // Lengths are below 2³¹ (checkLength()), and a division of 64 bits is slow on a device.
    const auto slot =
        static_cast<std::uint32_t>(component) % static_cast<std::uint32_t>(e.addendLength);
    return result + e.addend[row * e.addendStride + slot];
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

/// Adds number times value, summed over the rows of a lane, to `width` sums from sums.of[first] on.
template <int width, int count, class Real>
ESPALIER_DEVICE void addProducts(Values<Real, count>& sums, int first,
                                 const RowNumbers<Real>& numbers,
                                 const Values<RowNumbers<Real>, width>& values) {
    ESPALIER_UNROLL
    for (int q = 0; q < kRowsPerLane<Real>; ++q) {
        ESPALIER_UNROLL
        for (int c = 0; c < width; ++c)
            sums.of[first + c] = addProduct(sums.of[first + c], numbers.of[q], values.of[c].of[q]);
    }
}

/// Returns number times value for each row of a lane.
template <int width, class Real>
ESPALIER_DEVICE Values<RowNumbers<Real>, width> scaled(
    const RowNumbers<Real>& numbers, const Values<RowNumbers<Real>, width>& values) {
    Values<RowNumbers<Real>, width> products;
    ESPALIER_UNROLL
    for (int c = 0; c < width; ++c) {
        ESPALIER_UNROLL
        for (int q = 0; q < kRowsPerLane<Real>; ++q)
            products.of[c].of[q] = numbers.of[q] * values.of[c].of[q];
    }
    return products;
}

}  // namespace espalier::osd::device
