// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <span>
#include <vector>

namespace espalier::shapes {

/// In place of a mirror image: a position has none, or several.
inline constexpr Index kNoImage = -1, kSeveralImages = -2;

/// Returns for each position the position at its mirror image about a plane. A position in the
/// plane is its own image. Two positions are images of each other, or neither has the other one as
/// its image.
///
/// \param axis 0 to 2: the plane is across this axis
/// \param plane coordinate of the plane on the axis
/// \param tolerance largest distance of a position from the image of another one, 0 or more. If
///        several positions are within the tolerance of an image, the nearest counts. If these
///        positions are within the tolerance of each other, there are several images
/// \throws ArgumentError for an axis, a plane or a tolerance out of range; Error naming the first
///         position that is not finite
/// \cost O(n log n)
ESPALIER_API std::vector<Index> mirrorImages(std::span<const Point3> positions, int axis,
                                             double plane, double tolerance);

}  // namespace espalier::shapes
