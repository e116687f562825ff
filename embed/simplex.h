// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <Eigen/Core>
#include <array>

namespace espalier::embed {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Returns the point of a triangle that is nearest to the origin, as three barycentric coordinates
/// (0 or more, with sum 1). A triangle without area is treated as its longest edge.
ESPALIER_API Eigen::Vector3d nearestToOrigin(const Triangle& triangle);

}  // namespace espalier::embed
