// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/word.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/marks.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

/// \file
/// What becomes of semi-sharp features in the next split.

namespace espalier::far {

class Refinement;

/// What happens at the boundary of the region.
enum class Boundary {
    Sharp,  ///< boundary control: corners, sharp edges and boundary surfaces have their own rules
            ///< (MacCracken & Joy 1996, section 3). On a mesh, OpenSubdiv's "edge and corner"
    EdgeOnly,  ///< the same, but a vertex is not a corner for being in one cell (lattice) or one
               ///< face (mesh). On a mesh, OpenSubdiv's "edge only"
    Open       ///< none: uniform B-spline behaviour, the region shrinks (the same, section 2.2).
               ///< OpenSubdiv's "none" leaves out the faces that shrink away; here, what is left
               ///< of them stays
};
inline constexpr Word<Boundary> kBoundaryWords[] = {
    {"sharp", Boundary::Sharp}, {"edge-only", Boundary::EdgeOnly}, {"open", Boundary::Open}};

/// Which boundary edges of a lattice are sharp when no mark says otherwise.
enum class SharpEdges {
    SingleCell,  ///< those in exactly one cell
    Literal      ///< those that join two vertices of at most two cells each: the paper's words,
                 ///< which make more edges sharp where a lattice is one cell thick
};
inline constexpr Word<SharpEdges> kSharpEdgesWords[] = {{"single-cell", SharpEdges::SingleCell},
                                                        {"literal", SharpEdges::Literal}};

/// A number for each vertex and each edge of a complex.
struct SharpnessValues {
    std::vector<float> vertices;
    std::vector<float> edges;
};

/// The stratum of each entity: the dimension of the feature that it lies on.
///
///     0   corner vertex
///     1   sharp edge (lattice); boundary edge or crease (mesh); interior (curve)
///     2   boundary surface (lattice); interior (mesh)
///     3   interior (lattice)
///
/// The point of an entity of stratum s is computed with the s-dimensional rule, in the sub-complex
/// of the entities that inSubcomplex() names.
///
/// The stratum of a level follows from the sharpness that is left on it. Semi-sharp features fade:
/// see fadingOf().
///
/// \cite MacCracken & Joy 1996, section 3
class ESPALIER_API Strata {
public:
    Strata() = default;

    /// One number for each entity.
    using Numbers = ByEntity<std::uint8_t>;

    /// The strata that follow from sharpness: an edge that is sharp has stratum 1; a vertex that is
    /// sharp, or in which three or more sharp edges of its surface meet, has 0, and with two 1.
    ///
    /// \param smoothStrata what the strata would be without sharpness
    /// \param isOpen not 0 for the entities on the open boundary; may be left empty
    Strata(const CellComplex& complex, Numbers smoothStrata, Numbers isOpen,
           SharpnessValues sharpness);

    int of(Entity entity) const { return valueAt(strata_, entity); }

    /// The stratum without sharpness: 2 on the surface of a lattice and 3 inside it, 2 on a mesh,
    /// 1 on a curve.
    int smoothStratum(Entity entity) const { return valueAt(smoothStrata_, entity); }

    /// Of every entity.
    const Numbers& smoothStrata() const { return smoothStrata_; }

    /// Whether `other`, which contains `entity` or is it, belongs to the sub-complex that the rule
    /// of `stratum` averages over: it lies on that stratum or a lower one, and on the surface if
    /// `entity` does. So a sharp edge inside a lattice that ends on the surface leaves the surface
    /// as it is.
    bool inSubcomplex(Entity entity, int stratum, Entity other) const {
        return of(other) <= stratum &&
               (smoothStratum(entity) == kMaxDimension || smoothStratum(other) < kMaxDimension);
    }

    /// Whether the entity is on the boundary of a region without boundary control. Such entities
    /// have no rule; refinement leaves out the children whose lower end they are.
    bool isOpen(Entity entity) const {
        return !isOpen_[0].empty() && valueAt(isOpen_, entity) != 0;
    }

    /// What is left of the sharpness of a vertex or an edge.
    float sharpness(Entity entity) const {
        const auto& values = entity.dimension == 0 ? sharpness_.vertices : sharpness_.edges;
        return values[entity.index];
    }

    /// Whether any sharpness is neither 0 nor infinite.
    bool hasSemiSharp() const { return hasSemiSharp_; }

    /// Number of entities of a dimension on a stratum.
    Index count(int dimension, int stratum) const;

private:
    static std::uint8_t valueAt(const Numbers& values, Entity entity) {
        return values[entity.dimension][entity.index];
    }

    Numbers smoothStrata_;
    Numbers strata_;
    Numbers isOpen_;
    SharpnessValues sharpness_;
    bool hasSemiSharp_ = false;
};

/// The strata of a base complex.
///
/// Surface faces are the faces of a mesh, and the faces of a lattice in one cell. With boundary
/// control:
///
/// - An edge in one or in more than two surface faces is sharp, and so is an edge of a mesh whose
///   two faces run along it the same way, or that joins a vertex to itself (OpenSubdiv's
///   non-manifold edges).
/// - A boundary edge of a lattice is sharp if `rule` says so; a mark overrides that.
/// - A vertex whose surface faces do not form one fan is a corner, unless it has three
///   fans or more and all run between the same two edges: these form a crease.
/// - Under Boundary::Sharp, a vertex of one face of a mesh is a corner, and so is a vertex of one
///   cell of a lattice; the latter a mark overrides.
/// - Both ends of a curve are corners, and vertices of a mesh that are in no face.
/// - A mark on anything else, inside a lattice too, counts as it is.
///
/// Without it, what a boundary face of a lattice, a boundary edge of a mesh or an end of a curve
/// contains is open, unless that edge or end is marked infinitely sharp; and so is what has no
/// other vertices.
///
/// \throws TopologyError (VertexOutOfRange, BadMark) as readMarks(), and for a mark that says
///         smooth where the topology makes an edge sharp or a vertex a corner
/// \cost O(n log n) in the entries
/// \cite MacCracken & Joy 1996, section 3; the counting rule of vertices, and what is sharp on a
///       mesh, are OpenSubdiv's, with non-manifold creases as in its release 3.6.1 (pull request
///       1338: releases before it take some corners for creases). Where a face passes a vertex
///       twice, OpenSubdiv may take one of its corners there for the other, and then finds another
///       sharpness for the vertex
ESPALIER_API Strata classify(const CellComplex& complex, Boundary boundary, SharpEdges rule,
                             const Marks& marks);

/// The strata one level on: a child [a, b] inherits what b is without sharpness; a child edge
/// [v, e] has the sharpness of e as it is subdivided at v, and a child vertex [v, v] that of v.
///
/// Without boundary control and with Creasing::Chaikin, the average at a vertex of the shrinking
/// border is taken over the edges that are left.
///
/// \cost O(entries)
ESPALIER_API Strata refineStrata(const CellComplex& parent, const Strata& strata,
                                 const Refinement& refinement, Boundary boundary,
                                 Creasing creasing);

/// Marks with which classify(complex, boundary, SharpEdges::SingleCell, marks) gives back `strata`:
/// none on what is so without a mark. They keep the features of a refined complex that is written
/// to a file.
/// \param strata of `complex`, and of `boundary`
ESPALIER_API Marks marksFor(const CellComplex& complex, const Strata& strata, Boundary boundary);

/// The sharpness of the child edge [vertex, edge].
/// \param edge an edge, `vertex` one of its ends
/// \cost constant under Creasing::Uniform; O(edges at the vertex) under Creasing::Chaikin
ESPALIER_API float childSharpness(const CellComplex& complex, const Strata& strata,
                                  Creasing creasing, const Entity& edge, Index vertex);

/// An edge or vertex that loses its stratum in the next split, with sharpness that runs out. Its
/// new point is `weight` of the rule of its stratum and 1 − weight of the rule of stratum `next`.
struct Fading {
    int next = 0;
    double weight = 1;
    /// The edges of the crease that a vertex is left on, if it is left on one. All of a curve has
    /// stratum 1, where there is none.
    std::optional<std::array<Index, 2>> staySharp = {};
};

/// How an entity fades in the next split, if it does.
///
/// The weight of an edge is its sharpness, that of a vertex the mean sharpness of all that fades
/// in it, at most 1. Under Creasing::Chaikin an edge that fades at one end only may have a
/// sharpness above 1; the rules are then extrapolated, as in OpenSubdiv.
///
/// \cost O(edges at the ends of the entity); constant if nothing is semi-sharp
/// \cite OpenSubdiv 3.5, Sdc::Scheme::ComputeVertexVertexMask and ComputeEdgeVertexMask
ESPALIER_API std::optional<Fading> fadingOf(const CellComplex& complex, const Strata& strata,
                                            Creasing creasing, const Entity& entity);

}  // namespace espalier::far
