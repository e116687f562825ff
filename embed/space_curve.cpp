// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/embed/space_curve.h>

#include <algorithm>
#include <array>
#include <utility>

namespace espalier::embed {
namespace {

constexpr double kStepsPerAxis = 1 << MortonCurve::kBitsPerAxis;

/// Inserts two zeros after each bit of a number of 21 bits.
std::uint64_t spread(std::uint64_t bits) {
    bits = (bits | bits << 32) & 0x001f00000000ffff;
    bits = (bits | bits << 16) & 0x001f0000ff0000ff;
    bits = (bits | bits << 8) & 0x100f00f00f00f00f;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
    bits = (bits | bits << 2) & 0x1249249249249249;
    return bits;
}

}  // namespace

MortonCurve::MortonCurve(const Eigen::AlignedBox3d& box) : low_(box.min()) {
    // An axis along which the box has no length has a single step.
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double length = box.max()[axis] - box.min()[axis];
        scale_[axis] = length > 0 ? kStepsPerAxis / length : 0;
    }
}

std::uint64_t MortonCurve::key(const Eigen::Vector3d& point) const {
    std::uint64_t key = 0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double steps = (point[axis] - low_[axis]) * scale_[axis];
        // The comparison is such that a NaN gives 0.
        const double inside = steps > 0 ? std::min(steps, kStepsPerAxis - 1) : 0;
        key |= spread(static_cast<std::uint64_t>(inside)) << axis;
    }
    return key;
}

void sortAlongCurve(Array<CurveItem>& places, int bits) {
    // Radix sort from the lowest digit. Digits of 11 bits would take fewer passes but twice the
    // time: each pass would then write to more memory pages at once than the TLB holds.
    constexpr int kDigitBits = 8;
    constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
    constexpr std::size_t kBlock = 1 << 17;  // a millisecond or two
    Array<CurveItem> sorted(places.size());
    const int low = MortonCurve::kBits - bits;
    for (int shift = low; shift < MortonCurve::kBits; shift += kDigitBits) {
        const auto digit = [&](const CurveItem& place) { return (place.key >> shift) % kDigits; };
        std::array<std::size_t, kDigits> next = {};
        forEachBlock(places.size(), kBlock, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) ++next[digit(places[i])];
        });
        std::size_t begin = 0;
        for (std::size_t& count : next) begin += std::exchange(count, begin);
        forEachBlock(places.size(), kBlock, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) sorted[next[digit(places[i])]++] = places[i];
        });
        places.swap(sorted);
    }
}

}  // namespace espalier::embed
