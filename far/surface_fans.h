// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>

#include <array>
#include <cstdint>
#include <vector>

namespace espalier::far {

/// How the faces of a surface meet: in its edges, and around its vertices. The surface is a mesh,
/// or the boundary of a lattice.
class SurfaceFans {
public:
    /// \param complex must outlive this
    /// \param isSurfaceFace not 0 for the faces that form the surface, one a face of `complex`
    /// \cost O(n log n) in the corners of the faces
    SurfaceFans(const CellComplex& complex, std::vector<std::uint8_t> isSurfaceFace);

    /// An edge by its faces on the surface.
    enum class EdgeKind : std::uint8_t {
        None,        ///< none
        Boundary,    ///< one
        Manifold,    ///< two, which run along it in opposite directions
        NonManifold  ///< more, or two that run along it the same way; or both its ends are one
                     ///< vertex, or one of its faces has another edge between the same two
    };
    EdgeKind edge(Index edge) const { return edgeKinds_[edge]; }

    /// Number of faces of the surface at an edge.
    Index faceCount(Index edge) const;

    /// A vertex by its fans: sets of corners on the surface, joined across manifold edges.
    enum class VertexKind {
        None,        ///< no fan
        Fan,         ///< one, closed or between two boundary edges
        Crease,      ///< three or more, all between the same two non-manifold edges
        NonManifold  ///< anything else
    };

    /// \cost O(n log n) in the corners at the vertex
    VertexKind vertex(Index vertex) const;

private:
    std::vector<Index> surfaceFaces(Index edge) const;
    void markDegenerate();

    /// A corner of a face, by the two edges that meet in it.
    struct Corner {
        Index entering;
        Index leaving;
    };

    const CellComplex& complex_;
    std::vector<std::uint8_t> isSurfaceFace_;
    std::vector<EdgeKind> edgeKinds_;
    std::vector<Offset> cornerOffsets_;  ///< vertex v has corners [v] to [v + 1]
    std::vector<Corner> corners_;
};

}  // namespace espalier::far
