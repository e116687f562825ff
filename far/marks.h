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
/// Sharpness is a number, as in OpenSubdiv: 0 is smooth, 10 and more is infinite, and what lies
/// between is semi-sharp: it loses 1 a level. It is held in single precision, as there, so that
/// Chaikin's averages are rounded alike. These are the rules of numbers alone; strata.h applies
/// them to a complex.
///
/// Where three or more semi-sharp values meet in a vertex, their sum is rounded, and OpenSubdiv may
/// add them in another order: weights may then differ by some units of single precision (1e-7),
/// unless the sums are exact, as those of multiples of 1/4 are.
///
/// \cite DeRose, Kass, Truong 1998, as OpenSubdiv 3.5 computes it (Sdc::Crease)

/// Sharpness that no refinement uses up.
inline constexpr float kInfinitelySharp = std::numeric_limits<float>::infinity();
inline constexpr float kSmooth = 0;

/// From this on, a sharpness counts as infinite.
inline constexpr double kLeastInfinite = 10;

/// How the sharpness of an edge goes over to its two children.
enum class Creasing {
    Uniform,  ///< less 1 at both ends
    Chaikin   ///< less 1 after it is averaged with the other semi-sharp edges at that end
};
inline constexpr Word<Creasing> kCreasingWords[] = {{"uniform", Creasing::Uniform},
                                                    {"chaikin", Creasing::Chaikin}};

/// A sharpness as it is stored: in single precision, and infinite from kLeastInfinite on.
/// \param sharpness 0 or more
ESPALIER_API float storedSharpness(double sharpness);

inline bool isSemiSharp(float sharpness) {
    return sharpness > kSmooth && sharpness < kInfinitelySharp;
}

/// Sharpness one level on, without regard to what is around: that of a vertex, and of an edge under
/// Creasing::Uniform.
ESPALIER_API float subdivideSharpness(float sharpness);

/// Sharpness of the child of an edge at one of its ends.
/// \param around the sharpness of all edges at that end, the edge itself among them
ESPALIER_API float subdivideEdgeSharpness(Creasing creasing, float sharpness,
                                          std::span<const float> around);

/// What is marked by hand on a complex (MacCracken & Joy 1996, section 5; OpenSubdiv's tags).
///
/// A sharpness is 0 or more (see above): kInfinitelySharp makes a sharp edge or a corner, a
/// finite one a semi-sharp crease or corner, kSmooth takes away the sharpness that an edge or a
/// vertex of a lattice would have by rule. Of two marks on the same edge or vertex the later one
/// counts. An edge is named by its two vertices.
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

    /// Faces of a mesh that are not part of the surface. They take part in refinement like any
    /// other, and their children are holes.
    std::vector<Index> holes = {};

    bool empty() const { return edges.empty() && vertices.empty() && holes.empty(); }
    friend bool operator==(const Marks&, const Marks&) = default;
};

/// The marks by entity, each in its stored form (storedSharpness()).
struct MarkedSharpness {
    std::map<Index, float> edges;
    std::map<Index, float> vertices;
};

/// \throws TopologyError (VertexOutOfRange, BadMark) for a mark on what does not exist, or of a
///         sharpness that is negative or NaN
ESPALIER_API MarkedSharpness readMarks(const CellComplex& complex, const Marks& marks);

/// The marked holes, ascending, each once.
/// \throws TopologyError (BadMark) for a face that does not exist, or if `complex` is not a mesh
ESPALIER_API std::vector<Index> readHoles(const CellComplex& complex, const Marks& marks);

}  // namespace espalier::far
