// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/embed/continuity.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// \file
/// Adds layers of cells around a lattice, in which its motion fades out. A mesh that reaches beyond
/// the lattice then has no jump at the boundary of the lattice.
namespace espalier::cages {

/// The directions −x, +x, −y, +y, −z, +z, and their words.
inline constexpr std::array<const char*, 6> kSideWords = {"-x", "+x", "-y", "+y", "-z", "+z"};

/// Returns, for each of kSideWords, whether one of the words names it. An axis without a sign, such
/// as "z", names both of its directions.
/// \throws ArgumentError of the field "open" for another word
ESPALIER_API std::array<bool, 6> sidesOf(std::span<const std::string> words);

/// Largest number of layers of a collar.
inline constexpr int kMaxCollarLayers = 100;

/// Options of collar(). Either `reach` or `until` is set.
struct CollarOptions {
    int layers = 3;  ///< layers of cells, 1 to kMaxCollarLayers

    /// Thickness of the collar, above 0, in the units of the lattice; 0: not set.
    double reach = 0;

    /// Two opposite corners of a box with sides along the axes, around the lattice: the collar
    /// reaches to its sides. Only for a box lattice whose sides face the directions of the axes.
    std::optional<std::array<Point3, 2>> until = {};

    /// Sides without a collar, in the order of kSideWords. Of a box lattice, the side that faces
    /// the direction. Of another lattice, its end there: the boundary faces whose vertices all are
    /// within 1 % of the extent from the farthest vertex. The collar around such a side continues
    /// its plane.
    std::array<bool, 6> open = {};

    /// A plane of symmetry: ends of the lattice that are in this plane exactly are open, too.
    std::optional<shapes::SymmetryPlane> symmetry = {};

    /// Number of outer layers of vertices that are held, at most `layers`. 0: two, or one if there
    /// is one layer of cells. Two give C² under subdivision; in an evenly divided box with a Bézier
    /// or B-spline basis, three would.
    int held = 0;
};

/// A lattice with a collar, and facts about it.
struct Collar {
    Lattice lattice;
    std::vector<Index> held;  ///< the vertices that the collar holds, ascending

    /// How a motion of the other vertices ends at the outer boundary, under subdivision: C0 if one
    /// layer of vertices is held, else C2.
    embed::Continuity continuity = embed::Continuity::C0;

    /// True: the lattice is a box, and so is the result.
    bool isGrid = false;

    /// The smallest and the largest distance of an outer vertex: if isGrid, from the vertex that it
    /// is over, without the vertices at edges and corners; otherwise from the faces of the lattice.
    std::array<double, 2> reach = {};
};

/// Adds layers of cells around a lattice. Vertices and cells of the lattice keep their numbers,
/// positions, attributes and marks; a pose of the lattice is a pose of the first vertices of the
/// result. A new vertex has the attributes and integers of the vertex that it is over.
///
/// The outer vertices are held (shapes/held.h): poses and fits keep them in place. Let h be the
/// distance of a point from the outer boundary, in the parameter across the layers. If two layers
/// of vertices are held, the displacement of the point is O(h³) where the lattice is regular: the
/// cubic B-spline has there the phantom layer 2 d₀ − d₁, so that its value is d₀, its slope d₁ − d₀
/// and its second derivative 0. So position, slope and second derivative vanish if and only if d₀ =
/// d₁ = 0. At irregular vertices of the boundary, where n edges meet, displacements decrease from
/// level to level by at most (3/4 + 3/2 / (n + 2)) / 8 ≤ 0.132 < 1/4, so that they are o(h²).
///
/// A box lattice becomes a larger box, with blocks of cells at its edges and corners, so that it
/// stays one tricubic spline. Where its faces are parallel to the axes, so are the new ones. Around
/// other lattices, and around a box that no larger box surrounds without folds, each boundary face
/// gets one prism per layer. Three cells then meet at a convex edge of the lattice, and five at a
/// concave one, where second derivatives may not exist. The faces are moved outwards
/// along the directions that all faces around a vertex see best, less far where other parts of the
/// lattice face them; an optimization of the shapes of the cells removes folds (untangle.h).
/// No outer vertex is farther from the faces of the lattice than twice the reach; at the corner of
/// a cube the distance is √3 times the reach. It is shorter than the reach where other parts of the
/// lattice face the vertex, and where folds were removed (Collar::reach).
///
/// The layers grow by a constant factor, from the thickness of the cells at the boundary; if the
/// reach is too small for growth, they are equally thick.
///
/// The result is proved: cells of level 1 and parts of the limit of level 2 (solve::ValidityCheck)
/// are free of folds; and no boundary vertex of level 1 is in a cell that it is not a corner of.
/// Cells of the lattice that fold without the collar may still fold, and cells of the lattice that
/// overlap each other may still overlap. A lattice that is inside out as a whole, such as one whose
/// positions were mirrored, gets a collar that is inside out, too.
///
/// \throws ArgumentError for an option out of range, for `until` around a lattice that is not
///         such a box or not inside, and for an open direction that no side or two sides of a box
///         face; Error if all sides are open; if an open end has no face; if the boundary is not a
///         manifold, naming a vertex; if the lattice has other data with the name "held"
///         (shapes/held.h); and if cells of the collar would fold, overlap or be too thick. The
///         message names the vertex of the lattice near most of these cells, and a reach or a
///         number of layers that works, if one was found.
/// \cost O(n log n) in the cells for the collar of a box; O(boundary vertices²) for others. A
///        refusal takes up to five times as long as a collar, because of the search for options
///        that work.
ESPALIER_API Collar collar(const Lattice& lattice, const CollarOptions& options);

}  // namespace espalier::cages
