// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <Eigen/Core>

namespace espalier::embed {

/// Returns the x in the box from `low` to `high` for which map · x is nearest to `target`; if
/// several are equally near, one of them. Exact up to rounding, at any size of the map: the
/// solution has each axis at its lower bound, at its upper bound or free, and the function tries
/// all 27 combinations.
///
/// \param map, target finite; the map may be singular
/// \cost 27 solves of at most 3 × 3: under 1 µs
ESPALIER_API Eigen::Vector3d nearestInBox(const Eigen::Matrix3d& map, const Eigen::Vector3d& target,
                                          const Eigen::Vector3d& low, const Eigen::Vector3d& high);

}  // namespace espalier::embed
