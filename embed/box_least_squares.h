// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <Eigen/Core>

namespace espalier::embed {

/// The x between `low` and `high`, axis by axis, for which map · x is nearest to `target`. Exact
/// but for rounding, at any size of the map: one of the 27 ways to hold each axis at its lower end,
/// at its upper end or not at all is the right one. Where several x are as near, one of them.
///
/// \param map, target finite; the map may be singular
/// \cost 27 solves of at most 3 × 3: under 1 µs
ESPALIER_API Eigen::Vector3d nearestInBox(const Eigen::Matrix3d& map, const Eigen::Vector3d& target,
                                          const Eigen::Vector3d& low, const Eigen::Vector3d& high);

}  // namespace espalier::embed
