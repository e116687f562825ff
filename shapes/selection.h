// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>

#include <span>
#include <vector>

/// \file
/// Selects positions for the operations of pose.h. Each function returns one weight per position:
/// 1 in the selected region, 0 far from it. A falloff makes the weights decrease with the distance
/// from the region. Positions count as inside the region if rounding alone puts them outside:
/// within 1e-9 of the diagonal of the box around all positions.
///
/// All functions throw ArgumentError for a number that is not finite or out of range, and Error for
/// a position that is not finite, and if a distance overflows.

namespace espalier::shapes {

/// How weights decrease with the distance d from the selected region, as u = d / radius grows from
/// 0 to 1. At and beyond the radius they are 0.
struct Falloff {
    enum class Profile {
        Linear,  ///< 1 − u
        Smooth   ///< 1 − 3u² + 2u³: its slope is 0 at both ends
    };
    Profile profile = Profile::Linear;
    double radius = 0;  ///< 0 or more; 0: no weights between 0 and 1
};
inline constexpr Word<Falloff::Profile> kFalloffWords[] = {{"linear", Falloff::Profile::Linear},
                                                           {"smooth", Falloff::Profile::Smooth}};

/// Selects the box with two opposite corners, in any order.
ESPALIER_API std::vector<double> selectBox(std::span<const Point3> positions, const Point3& corner,
                                           const Point3& opposite, const Falloff& falloff = {});

/// Selects a ball.
/// \param radius 0 or more
ESPALIER_API std::vector<double> selectBall(std::span<const Point3> positions, const Point3& center,
                                            double radius, const Falloff& falloff = {});

/// Selects the half-space on the side of a plane that a normal points to.
/// \param point on the plane
/// \param normal not zero, of any length
ESPALIER_API std::vector<double> selectHalfSpace(std::span<const Point3> positions,
                                                 const Point3& point, const Point3& normal,
                                                 const Falloff& falloff = {});

/// Selects the end in a direction: the positions within 1 % of the extent along the direction from
/// the farthest one. For a lattice in layers across the direction, this is its last layer of
/// vertices.
/// \param direction not zero, of any length
/// \throws also if there are no positions
ESPALIER_API std::vector<double> selectEnd(std::span<const Point3> positions,
                                           const Point3& direction, const Falloff& falloff = {});

/// Selects positions by number. The falloff measures the distance from the nearest selected
/// position.
/// \param numbers 0 or more, below the number of positions; repeated numbers count once
/// \cost O(positions); with a falloff O(positions · numbers)
ESPALIER_API std::vector<double> selectNumbers(std::span<const Point3> positions,
                                               std::span<const Index> numbers,
                                               const Falloff& falloff = {});

}  // namespace espalier::shapes
