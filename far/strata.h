// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace espalier::far {

/// What happens at the boundary of the region.
enum class Boundary {
    Sharp,  ///< boundary control: corners, sharp edges and boundary surfaces have their own rules
            ///< (MacCracken & Joy 1996, section 3)
    Open    ///< none: uniform B-spline behaviour, the region shrinks (the same, section 2.2)
};

/// Which boundary edges of a lattice are sharp when no mark says otherwise.
enum class SharpEdges {
    SingleCell,  ///< those in exactly one cell
    Literal      ///< those that join two vertices of at most two cells each: the paper's words,
                 ///< which make more edges sharp where a lattice is one cell thick
};

/// Sharpness that no refinement uses up; at least 10, as in OpenSubdiv, counts as infinite.
inline constexpr double kInfinitelySharp = std::numeric_limits<double>::infinity();
inline constexpr double kSmooth = 0;

/// Edges and vertices marked by hand; a mark overrides the automatic choice (the paper, section 5).
///
/// An edge is named by its two vertices. Sharpness is kInfinitelySharp (a sharp edge, a corner) or
/// kSmooth (a smooth edge, a vertex that is free). A free vertex loses the mark of being the vertex
/// of one cell; three or more sharp edges still make a corner, as in OpenSubdiv. Of two marks on
/// the same edge or vertex the later one counts.
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

    bool empty() const { return edges.empty() && vertices.empty(); }
    friend bool operator==(const Marks&, const Marks&) = default;
};

/// The stratum of each entity: the dimension of the feature that it lies on.
///
///     0   corner vertex
///     1   sharp edge (lattice); boundary edge or crease (mesh); interior (curve)
///     2   boundary surface (lattice); interior (mesh)
///     3   interior (lattice)
///
/// The point of an entity of stratum s is computed with the s-dimensional rule, in the sub-complex
/// of the entities whose stratum is at most s.
///
/// \cite MacCracken & Joy 1996, section 3
class Strata {
public:
    Strata() = default;

    /// All entities of `complex` on `stratum`.
    Strata(const CellComplex& complex, int stratum);

    int of(Entity entity) const {
        return strata_[static_cast<std::size_t>(entity.dimension)]
                      [static_cast<std::size_t>(entity.index)];
    }

    /// Lowers the stratum of an entity to at most `stratum`.
    void lower(Entity entity, int stratum);

    /// Number of entities of a dimension on a stratum.
    Index count(int dimension, int stratum) const;

private:
    std::array<std::vector<std::uint8_t>, kMaxDimension + 1> strata_;
};

/// Strata under boundary control.
///
/// - An entity of dimension d − 1 in other than two of dimension d is on the boundary, with all
///   that it contains (d is the dimension of the complex).
/// - A boundary edge of a lattice is sharp if `rule` or a mark says so, or if it lies in other than
///   two boundary faces.
/// - A vertex is a corner if three or more sharp edges meet in it, if it belongs to exactly one
/// cell
///   of dimension d, if its surface faces do not form one fan, or if it is marked. With two sharp
///   edges it lies on the curve, with one (a dart) or none on the surface.
///
/// \throws TopologyError (VertexOutOfRange, BadMark) for a mark on what does not exist, of a
///         sharpness that is neither, or smooth on an edge or vertex that cannot be
/// \cost O(entries)
/// \cite MacCracken & Joy 1996, section 3; the counting rule of vertices is OpenSubdiv's
Strata classifySharp(const CellComplex& complex, SharpEdges rule, const Marks& marks);

/// Marks with which classifySharp(complex, SharpEdges::SingleCell, marks) gives back `strata`: none
/// on what is so without a mark. They keep the features of a refined lattice that is written to a
/// file. \param strata under boundary control, of `complex` or inherited by it
Marks marksFor(const CellComplex& complex, const Strata& strata);

/// Strata without boundary control: an entity is on the boundary (dimension of the complex − 1) or
/// interior (dimension of the complex).
Strata classifyOpen(const CellComplex& complex);

}  // namespace espalier::far
