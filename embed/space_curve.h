// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/base/index.h>

#include <Eigen/Geometry>
#include <cstdint>

namespace espalier::embed {

/// The position of an item along a space-filling curve.
struct CurveItem {
    std::uint64_t key = 0;
    Index item = 0;
};

/// Computes the position of a point along Morton's curve through a box. Bits 3k to 3k + 2 of the
/// key tell which eighth of a part of the box contains the point, and the higher bits tell which
/// part: points with common high bits are in a common sub-box. A point outside gets the key of the
/// nearest point inside; a point that is not finite gets some key.
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

/// Sorts by the highest `bits` bits of the key; items with equal bits keep their order.
/// \cost O(places · bits): 1 M places by all bits in 0.05 s
ESPALIER_API void sortAlongCurve(Array<CurveItem>& places, int bits = MortonCurve::kBits);

}  // namespace espalier::embed
