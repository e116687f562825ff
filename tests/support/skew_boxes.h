// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/tensor_product.h>

#include <Eigen/Core>
#include <array>
#include <vector>

#include "support/test.h"
#include "support/zoo.h"

namespace espalier::test {

using Cells = std::array<Index, 3>;

/// A skew parallelepiped away from the origin, on which the grid points of a box lie.
struct Skew {
    Eigen::Vector3d origin{4, -3, 2};
    Eigen::Matrix3d axes{{1.1, 0.4, -0.2}, {0.1, 0.7, 0.3}, {-0.3, 0.2, 0.9}};

    Point3 operator()(const Point3& at) const {
        const Eigen::Vector3d position = origin + axes * Eigen::Vector3d(at.data());
        return {position[0], position[1], position[2]};
    }
    std::vector<Point3> operator()(const std::vector<Point3>& points) const {
        std::vector<Point3> moved;
        for (const Point3& point : points) moved.push_back((*this)(point));
        return moved;
    }
};

/// Returns random points whose coordinate along axis a is from low to cells[a] − low.
inline std::vector<Point3> randomPoints(const Cells& cells, double low, std::size_t count,
                                        unsigned seed) {
    const auto values = randomValues(3 * count, seed);
    std::vector<Point3> points(count);
    for (std::size_t i = 0; i < 3 * count; ++i) {
        const double half = cells[i % 3] / 2.0;
        points[i / 3][i % 3] = half + (half - low) * values[i];
    }
    return points;
}

}  // namespace espalier::test
