// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/base/index.h>

#include <Eigen/Geometry>
#include <cstdint>

namespace espalier::embed {

/// Where an item lies along a space-filling curve.
struct CurveItem {
    std::uint64_t key = 0;
    Index item = 0;
};

/// How far along Morton's curve through a box a point is. Bits 3k to 3k + 2 of the result say in
/// which eighth of a part of the box it lies, and the higher bits in which part: points with common
/// high bits are in a common box. Points outside count as the nearest inside, and those that are
/// not finite have some place.
class ESPALIER_API MortonCurve {
public:
    static constexpr int kBitsPerAxis = 21;
    static constexpr int kBits = 3 * kBitsPerAxis;

    explicit MortonCurve(const Eigen::AlignedBox3d& box);
    std::uint64_t key(const Eigen::Vector3d& point) const;

private:
    Eigen::Vector3d low_;
    Eigen::Vector3d scale_;
};

/// Sorts by the highest `bits` of the key; those with the same stay in order.
/// \cost O(places · bits): 1 M places by all bits in 0.05 s
ESPALIER_API void sortAlongCurve(Array<CurveItem>& places, int bits = MortonCurve::kBits);

}  // namespace espalier::embed
