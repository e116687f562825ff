// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <optional>
#include <span>

/// \file
/// Makes a box lattice around the points of a model.

namespace espalier::shapes {

/// A plane across a coordinate axis.
struct SymmetryPlane {
    int axis = 0;                   ///< 0 to 2
    std::optional<double> at = {};  ///< its coordinate; by default 0, if the points reach to there
};

/// The number of cells comes from the first of `cells`, `cellSize` and `cellsAlongLongest` that is
/// set.
struct AroundOptions {
    /// Cells along each axis of the box, 1 or more each; zeros: not set.
    std::array<int, 3> cells = {0, 0, 0};

    /// Largest edge of a cell, in the units of the points, above 0; 0: not set. The edges are this
    /// long or a little shorter, so that a whole number of cells fits.
    double cellSize = 0;

    /// Cells along the longest side of the box, 1 or more. The other sides get the numbers for
    /// which the cells are closest to cubes.
    int cellsAlongLongest = 4;

    /// Distance between the box and the points on each side, as a fraction of the diagonal of the
    /// smallest box that holds the points: 0 or more.
    double margin = 0.05;

    /// False: the sides of the box are parallel to the axes. True: the box has the orientation of
    /// smallest volume that a search finds. On random clouds of points, its volume was at most 1 %
    /// above the smallest of 40,000 orientations. Its axes are named x, y and z by the coordinate
    /// axes that they are nearest to.
    bool oriented = false;

    /// A plane of symmetry, in which faces of the lattice lie exactly. If all points are on one
    /// side of it, it is a side of the box, without a margin. Else the box is symmetric about it,
    /// with an even number of cells across. Not with `oriented`.
    ///
    /// A pose that moves the vertices in the plane within the plane, and in a symmetric box the
    /// others symmetrically, keeps points of the plane in it.
    std::optional<SymmetryPlane> symmetry = {};
};

/// Facts about the box that around() makes.
struct AroundFacts {
    double margin = 0;               ///< AroundOptions::margin, or a wider one
    std::array<int, 3> cells = {};   ///< cells along each axis
    std::array<int, 3> wanted = {};  ///< the same without the plane of symmetry: across it, a cell
                                     ///< is added to an odd number
};

/// A point this far outside the box, as a fraction of its diagonal, counts as inside, as binding
/// does by default (embed::EmbeddingOptions::tolerance).
inline constexpr double kAroundTolerance = 1e-6;

/// Makes a box of hexahedra around points, with the numbers of vertices and cells of box().
///
/// Under the default rules, the limit and all levels of a box lattice fill the same box, so that
/// they contain every point. Where rounding leaves points outside, the margin is doubled until all
/// are inside.
///
/// \param facts is set, if it is not null
/// \throws ArgumentError for an option that is out of range, also for a margin of 0 around points
///         in a plane, and for a plane of symmetry that the points do not reach to; Error if there
///         are no points, a point is not finite, or all points are at one place, or some stay
///         outside ten wider boxes; far::TopologyError if there would be too many cells for an
///         Index
/// \cost O(points); O(points · log points) if `oriented`
ESPALIER_API Lattice around(std::span<const Point3> points, const AroundOptions& options = {},
                            AroundFacts* facts = nullptr);

}  // namespace espalier::shapes
