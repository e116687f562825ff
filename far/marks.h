// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/word.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <limits>
#include <map>
#include <span>
#include <vector>

namespace espalier::far {

/// \file
/// Marks on a complex, and the arithmetic of sharpness; strata.h applies it to a complex.
///
/// Sharpness is a number, as in OpenSubdiv: 0 is smooth, 10 or more is infinite, and anything
/// between is semi-sharp and loses 1 per level. It is stored in single precision, as in OpenSubdiv,
/// so that Chaikin's averages are rounded in the same way.
///
/// If three or more semi-sharp values meet in a vertex, their sum is rounded, and OpenSubdiv may
/// add them in another order. Weights may then differ by a few units of single precision (1e-7),
/// unless the sums are exact, as sums of multiples of 1/4 are.
///
/// \cite DeRose, Kass, Truong 1998, as OpenSubdiv 3.5 computes it (Sdc::Crease)

/// Sharpness that refinement does not reduce.
inline constexpr float kInfinitelySharp = std::numeric_limits<float>::infinity();
inline constexpr float kSmooth = 0;

/// A sharpness of this or more counts as infinite.
inline constexpr double kLeastInfinite = 10;

/// How the two children of an edge inherit its sharpness.
enum class Creasing {
    Uniform,  ///< both children lose 1
    Chaikin   ///< each child loses 1 after averaging with the other semi-sharp edges at its end
};
inline constexpr Word<Creasing> kCreasingWords[] = {{"uniform", Creasing::Uniform},
                                                    {"chaikin", Creasing::Chaikin}};

/// Returns a sharpness as it is stored: in single precision, and infinite from kLeastInfinite on.
/// \param sharpness 0 or more
ESPALIER_API float storedSharpness(double sharpness);

inline bool isSemiSharp(float sharpness) {
    return sharpness > kSmooth && sharpness < kInfinitelySharp;
}

/// Returns the sharpness on the next level, regardless of neighbours: for a vertex, and for an edge
/// under Creasing::Uniform.
ESPALIER_API float subdivideSharpness(float sharpness);

/// Returns the sharpness of the child of an edge at one of its ends.
/// \param around the sharpness of all edges at that end, including the edge itself
ESPALIER_API float subdivideEdgeSharpness(Creasing creasing, float sharpness,
                                          std::span<const float> around);

/// Marks set by hand on a complex (MacCracken & Joy 1996, section 5; OpenSubdiv's tags).
///
/// A sharpness is 0 or more: kInfinitelySharp makes a sharp edge or a corner, a finite value makes
/// a semi-sharp crease or corner, and kSmooth removes the sharpness that an edge or a vertex of a
/// lattice would have by rule. If an edge or vertex has two marks, the later one counts. An edge is
/// named by its two vertices.
struct Marks {
    struct Edge {
        std::array<Index, 2> vertices = {};
        double sharpness = kInfinitelySharp;
        friend bool operator==(const Edge&, const Edge&) = default;
    };
    struct Vertex {
        Index vertex = 0;
        double sharpness = kInfinitelySharp;
        friend bool operator==(const Vertex&, const Vertex&) = default;
    };
    std::vector<Edge> edges = {};
    std::vector<Vertex> vertices = {};

    /// Faces of a mesh that are not part of the surface. They are refined like any other face, and
    /// their children are holes.
    std::vector<Index> holes = {};

    bool empty() const { return edges.empty() && vertices.empty() && holes.empty(); }
    friend bool operator==(const Marks&, const Marks&) = default;
};

/// The marks by entity, with stored sharpness (storedSharpness()).
struct MarkedSharpness {
    std::map<Index, float> edges;
    std::map<Index, float> vertices;
};

/// Looks up the marked edges and vertices.
/// \throws TopologyError (VertexOutOfRange, BadMark) if a marked vertex or edge does not exist, or
///         a sharpness is negative or NaN
ESPALIER_API MarkedSharpness readMarks(const CellComplex& complex, const Marks& marks);

/// Returns the marked holes, ascending and without duplicates.
/// \throws TopologyError (BadMark) if a face does not exist, or if `complex` is not a mesh
ESPALIER_API std::vector<Index> readHoles(const CellComplex& complex, const Marks& marks);

}  // namespace espalier::far
