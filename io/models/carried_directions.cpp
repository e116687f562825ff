// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <limits>

#include "carried_directions.h"

namespace espalier::io {

bool isDirection(const Point3& numbers, Precision precision) {
    const double largest = precision == Precision::Float ? std::numeric_limits<float>::max()
                                                         : std::numeric_limits<double>::max();
    // Half of it, so that rounding takes no component beyond it. False for a length that is NaN.
    const double size = length(numbers);
    return size > 0 && size <= largest / 2;
}

std::vector<Point3> carried(std::span<const Point3> directions,
                            std::span<const DeformationGradient> gradients, Carry carry,
                            Precision precision) {
    std::vector<Point3> result(directions.begin(), directions.end());
    for (std::size_t point = 0; point < result.size(); ++point)
        if (isDirection(result[point], precision))
            result[point] = carry(gradients[point], result[point]);
    return result;
}

}  // namespace espalier::io
