// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>

#include <array>
#include <cstdint>
#include <vector>

// How faces meet; not installed.
namespace espalier::far {

/// Classifies how the faces of a surface meet in its edges and around its vertices. The surface is
/// a mesh, or the boundary of a lattice.
class ESPALIER_API SurfaceFans {
public:
    /// \param complex must outlive this object
    /// \param isSurfaceFace one per face of `complex`, not 0 for the faces that form the surface
    /// \cost O(n log n) in the corners of the faces
    SurfaceFans(const CellComplex& complex, std::vector<std::uint8_t> isSurfaceFace);

    /// The kind of an edge, by its number of faces on the surface.
    enum class EdgeKind : std::uint8_t {
        None,        ///< no face
        Boundary,    ///< one face
        Manifold,    ///< two faces, which run along the edge in opposite directions
        NonManifold  ///< more faces, or two that run along the edge in the same direction; or both
                     ///< ends are the same vertex, or one of its faces has another edge between the
                     ///< same two vertices
    };
    EdgeKind edge(Index edge) const { return edgeKinds_[edge]; }

    /// Returns the number of faces of the surface at an edge.
    Index faceCount(Index edge) const;

    /// The kind of a vertex, by its fans. A fan is a set of corners on the surface, joined across
    /// manifold edges.
    enum class VertexKind {
        None,        ///< no fan
        Fan,         ///< one fan, closed or between two boundary edges
        Crease,      ///< three or more fans, all between the same two non-manifold edges
        NonManifold  ///< anything else
    };

    /// \cost O(n log n) in the corners at the vertex
    VertexKind vertex(Index vertex) const;

private:
    std::vector<Index> surfaceFaces(Index edge) const;
    void markDegenerate();

    /// A corner of a face: the two edges that meet in it.
    struct Corner {
        Index entering;
        Index leaving;
    };

    const CellComplex& complex_;
    std::vector<std::uint8_t> isSurfaceFace_;
    std::vector<EdgeKind> edgeKinds_;
    std::vector<Offset> cornerOffsets_;  ///< vertex v has corners cornerOffsets_[v] to
                                         ///< cornerOffsets_[v + 1] − 1
    std::vector<Corner> corners_;
};

}  // namespace espalier::far
