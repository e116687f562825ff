// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

/// \file
/// Operations that pose a lattice: move, displace, rotate, scale, twist, bend, taper and mirror.
/// Each takes positions and returns the new ones.
///
/// Each operation gives a position with weight w a part of its effect: all of it at w = 1; at w = 0
/// the position stays as it is, bit for bit. Angles are in radians.
///
/// Twist, bend and taper vary along an axis. In their formulas, e is the unit vector of the axis,
/// c the centre, s = e·p the coordinate of a position along the axis, [a, b] the range, and
/// t = (s − a) / (b − a), but 0 below the range and 1 above it. So the end at a stays, and the full
/// effect is at b.
///
/// All functions throw ArgumentError for a number that is not finite or out of range, and Error for
/// a weight that is out of range, a wrong number of weights, and a position that is not finite
/// before or after the operation.
///
/// \cite Barr 1984, Global and local deformations of solid primitives

namespace espalier::shapes::pose {

/// The positions that an operation moves, its centre and its range. An operation ignores the fields
/// that its formula does not need.
struct Options {
    /// One weight per position, 0 to 1 (selection.h); empty: 1 for all.
    std::span<const double> weights = {};

    /// A point on the axis, or the fixed point of a scaling. By default, the middle of the box
    /// around the positions whose weight is above 0.
    std::optional<Point3> center = {};

    /// The interval [a, b] of e·p along the axis, b above a. By default, the interval of the
    /// positions whose weight is above 0.
    std::optional<std::array<double, 2>> range = {};

    /// The default of the range begins at the centre, if there is a centre: a limb then bends from
    /// its joint on, and the parts before the joint stay.
    bool startsAtCenter = false;
};

/// Adds w · offset.
ESPALIER_API std::vector<Point3> move(std::span<const Point3> positions, const Point3& offset,
                                      std::span<const double> weights = {});

/// Adds w · its own displacement to each position.
/// \param displacements one for each position
/// \throws Error also if the numbers of positions and displacements differ
ESPALIER_API std::vector<Point3> displace(std::span<const Point3> positions,
                                          std::span<const Point3> displacements,
                                          std::span<const double> weights = {});

/// Rotates by w · angle about an axis through the centre, anticlockwise seen from its tip.
/// \param axis not zero, of any length
ESPALIER_API std::vector<Point3> rotate(std::span<const Point3> positions, const Point3& axis,
                                        double angle, const Options& options = {});

/// Scales by 1 + w (factors − 1) along x, y and z about the centre.
ESPALIER_API std::vector<Point3> scale(std::span<const Point3> positions, const Point3& factors,
                                       const Options& options = {});

/// Rotates by w · angle · t about an axis through the centre.
/// \param axis not zero, of any length
/// \cite Barr 1984, section 3.3
ESPALIER_API std::vector<Point3> twist(std::span<const Point3> positions, const Point3& axis,
                                       double angle, const Options& options = {});

/// Bends the axis into an arc of a circle. The part of the axis in the range becomes an arc of the
/// same length; the parts beyond it remain straight.
///
/// With n the unit vector across e nearest to `toward`, r = n·(p − c), s' = s limited to [a, b],
/// k = w · angle / (b − a) and θ = k (s' − a), the coordinate along e becomes
/// a + sin θ (1/k − r) + cos θ (s − s'), and the one along n, relative to c, becomes
/// 1/k − cos θ (1/k − r) + sin θ (s − s').
///
/// \param axis not zero, of any length
/// \param toward direction that the end at b bends to; not parallel to the axis
/// \cite Barr 1984, section 3.4
ESPALIER_API std::vector<Point3> bend(std::span<const Point3> positions, const Point3& axis,
                                      double angle, const Point3& toward,
                                      const Options& options = {});

/// Scales by 1 + w (factor − 1) t across an axis through the centre.
/// \param axis not zero, of any length
/// \param factor 0 or more
/// \cite Barr 1984, section 3.2
ESPALIER_API std::vector<Point3> taper(std::span<const Point3> positions, const Point3& axis,
                                       double factor, const Options& options = {});

/// The result of mirror().
struct Mirrored {
    std::vector<Point3> positions;
    double plane = 0;        ///< coordinate of the plane on its axis
    Index withImage = 0;     ///< number of positions with a weight above 0 that have an image
    Index withoutImage = 0;  ///< number of the other ones with a weight above 0
};

/// Mirrors a pose from one side to the other: moves the mirror image of each position to the
/// mirrored place of the position. Images are found in the lattice at rest.
///
/// A position and its image are a pair, of which the position with the larger weight stays and the
/// other position moves. If the weights of a pair are equal, the position stays that is on the side
/// of the plane whose weights have the larger sum. If these sums are equal, too, the position with
/// the larger coordinate stays. A position that is its own image moves into the plane. A position
/// without an image stays, and so does a pair with the weights 0. The size of a weight does not
/// divide the effect.
///
/// \param rest positions of the lattice at rest. A position may be up to a thousandth of the
///        diagonal of the box around them from its mirror image: editors round coordinates, and
///        vertices of one lattice are farther apart
/// \param positions one for each of `rest`
/// \param axis 0 to 2: the plane is across this axis
/// \param weights one per position, 0 to 1; empty: 1 for all
/// \param plane coordinate of the plane on the axis; by default, of the middle of the box around
///        `rest`
/// \throws Error also if the numbers of positions differ, and if no position with a weight above 0
///         has an image
/// \cost O(n log n)
ESPALIER_API Mirrored mirror(std::span<const Point3> rest, std::span<const Point3> positions,
                             int axis, std::span<const double> weights = {},
                             std::optional<double> plane = {});

}  // namespace espalier::shapes::pose
