// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/sharpness.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <map>
#include <vector>

namespace espalier::far {

/// What is marked by hand on a complex (MacCracken & Joy 1996, section 5; OpenSubdiv's tags).
///
/// A sharpness is 0 or more (see sharpness.h): kInfinitelySharp makes a sharp edge or a corner, a
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
