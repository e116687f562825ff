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
/// Classifies the entities of a complex as corners, sharp edges, boundary surfaces or interior, and
/// tells how semi-sharp features fade.

namespace espalier::far {

class Refinement;

/// How to treat the boundary of the region.
enum class Boundary {
    Sharp,  ///< boundary control: corners, sharp edges and boundary surfaces have their own rules
            ///< (MacCracken & Joy 1996, section 3). On a mesh, this is OpenSubdiv's "edge and
            ///< corner"
    EdgeOnly,  ///< like Sharp, but a vertex is not a corner merely because it is in one cell
               ///< (lattice) or one face (mesh). On a mesh, this is OpenSubdiv's "edge only"
    Open       ///< no boundary control: uniform B-spline behaviour, the region shrinks (section
               ///< 2.2). OpenSubdiv's "none" omits faces that shrink; here, their remaining parts
               ///< stay
};
inline constexpr Word<Boundary> kBoundaryWords[] = {
    {"sharp", Boundary::Sharp}, {"edge-only", Boundary::EdgeOnly}, {"open", Boundary::Open}};

/// Which boundary edges of a lattice are sharp without a mark.
enum class SharpEdges {
    SingleCell,  ///< edges in exactly one cell
    Literal      ///< edges that join two vertices of at most two cells each. This is the paper's
                 ///< wording, which makes more edges sharp where a lattice is one cell thick
};
inline constexpr Word<SharpEdges> kSharpEdgesWords[] = {{"single-cell", SharpEdges::SingleCell},
                                                        {"literal", SharpEdges::Literal}};

/// The sharpness of each vertex and each edge of a complex.
struct SharpnessValues {
    std::vector<float> vertices;
    std::vector<float> edges;
};

/// The stratum of each entity: the dimension of the feature that the entity belongs to.
///
///     0   corner vertex
///     1   sharp edge (lattice); boundary edge or crease (mesh); interior (curve)
///     2   boundary surface (lattice); interior (mesh)
///     3   interior (lattice)
///
/// The point of an entity of stratum s is computed by the s-dimensional rule, from the entities
/// that inSubcomplex() selects.
///
/// The strata of a level follow from the sharpness that is left on that level. Semi-sharp features
/// fade: see fadingOf().
///
/// \cite MacCracken & Joy 1996, section 3
class ESPALIER_API Strata {
public:
    Strata() = default;

    /// One number for each entity.
    using Numbers = ByEntity<std::uint8_t>;

    /// Derives the strata from sharpness: a sharp edge has stratum 1; a vertex that is sharp, or in
    /// which three or more sharp edges of its surface meet, has stratum 0; a vertex with two sharp
    /// edges has stratum 1.
    ///
    /// \param smoothStrata the strata that the entities would have without sharpness
    /// \param isOpen not 0 for entities on the open boundary; may be empty
    Strata(const CellComplex& complex, Numbers smoothStrata, Numbers isOpen,
           SharpnessValues sharpness);

    /// Returns the strata of some entities of the complex, as they are here.
    /// \param entities for each entity of the part of the complex, its number here
    Strata select(const ByEntity<Index>& entities) const;

    int of(Entity entity) const { return valueAt(strata_, entity); }

    /// Returns the stratum without sharpness: 2 on the surface of a lattice and 3 inside it, 2 on a
    /// mesh, 1 on a curve.
    int smoothStratum(Entity entity) const { return valueAt(smoothStrata_, entity); }

    /// Returns smoothStratum() of every entity.
    const Numbers& smoothStrata() const { return smoothStrata_; }

    /// Returns of() of every entity.
    const Numbers& strata() const { return strata_; }

    /// Returns true if `other`, which contains `entity` or is equal to it, belongs to the
    /// sub-complex that the rule of `stratum` averages over: `other` has this stratum or a lower
    /// one, and is on the surface if `entity` is. So a sharp edge inside a lattice does not affect
    /// the surface where it ends.
    bool inSubcomplex(Entity entity, int stratum, Entity other) const {
        return of(other) <= stratum &&
               (smoothStratum(entity) == kMaxDimension || smoothStratum(other) < kMaxDimension);
    }

    /// Returns true if the entity is on the boundary of a region without boundary control. Such
    /// entities have no rule, and refinement omits the children whose lower end they are.
    bool isOpen(Entity entity) const {
        return !isOpen_[0].empty() && valueAt(isOpen_, entity) != 0;
    }

    /// Returns the remaining sharpness of a vertex or an edge.
    float sharpness(Entity entity) const {
        const auto& values = entity.dimension == 0 ? sharpness_.vertices : sharpness_.edges;
        return values[entity.index];
    }

    /// Returns true if any sharpness is neither 0 nor infinite.
    bool hasSemiSharp() const { return hasSemiSharp_; }

    /// Returns the number of entities of a dimension that have a stratum.
    Index count(int dimension, int stratum) const;

private:
    void findSemiSharp();

    static std::uint8_t valueAt(const Numbers& values, Entity entity) {
        return values[entity.dimension][entity.index];
    }

    Numbers smoothStrata_;
    Numbers strata_;
    Numbers isOpen_;
    SharpnessValues sharpness_;
    bool hasSemiSharp_ = false;
};

/// Computes the strata of a base complex.
///
/// The surface faces are all faces of a mesh, or the faces of a lattice that are in one cell. With
/// boundary control:
///
/// - An edge in one surface face, or in more than two, is sharp. So is an edge of a mesh whose two
///   faces run along it in the same direction, or that joins a vertex to itself (OpenSubdiv's
///   non-manifold edges).
/// - A boundary edge of a lattice is sharp if `rule` says so; a mark overrides this.
/// - A vertex whose surface faces do not form one fan is a corner, unless it has three or more fans
///   that all run between the same two edges: these form a crease.
/// - Under Boundary::Sharp, a vertex of one face of a mesh is a corner, and so is a vertex of one
///   cell of a lattice; for a lattice, a mark overrides this.
/// - Both ends of a curve are corners, and so are vertices of a mesh that are in no face.
/// - A mark on anything else counts, inside a lattice too.
///
/// Without boundary control, an entity is open if a boundary face of a lattice, a boundary edge of
/// a mesh or an end of a curve contains it, unless that edge or end is marked infinitely sharp. An
/// entity whose vertices are all open is open too.
///
/// \throws TopologyError (VertexOutOfRange, BadMark) as readMarks(), and if a mark makes an edge or
///         vertex smooth that must be sharp by topology
/// \cost O(n log n) in the entries
/// \cite MacCracken & Joy 1996, section 3. The counting rule of vertices, and the sharp entities of
///       a mesh, are OpenSubdiv's, with non-manifold creases as in its release 3.6.1 (pull request
///       1338: earlier releases treat some corners as creases). If a face passes a vertex twice,
///       OpenSubdiv may confuse its two corners there, and then computes another sharpness for the
///       vertex
ESPALIER_API Strata classify(const CellComplex& complex, Boundary boundary, SharpEdges rule,
                             const Marks& marks);

/// Computes the strata of the next level. A child [a, b] inherits the smooth stratum of b. A child
/// edge [v, e] has the sharpness of e, subdivided at v, and a child vertex [v, v] the sharpness of
/// v.
///
/// Without boundary control and with Creasing::Chaikin, the average at a vertex of the shrinking
/// border uses the remaining edges.
///
/// \cost O(entries)
ESPALIER_API Strata refineStrata(const CellComplex& parent, const Strata& strata,
                                 const Refinement& refinement, Boundary boundary,
                                 Creasing creasing);

/// Returns marks with which classify(complex, boundary, SharpEdges::SingleCell, marks) reproduces
/// `strata`. Entities that have their stratum without a mark get none. The marks preserve the
/// features of a refined complex that is written to a file.
/// \param strata of `complex`, computed with `boundary`
ESPALIER_API Marks marksFor(const CellComplex& complex, const Strata& strata, Boundary boundary);

/// Returns the sharpness of the child edge [vertex, edge].
/// \param edge an edge, `vertex` one of its ends
/// \cost constant under Creasing::Uniform; O(edges at the vertex) under Creasing::Chaikin
ESPALIER_API float childSharpness(const CellComplex& complex, const Strata& strata,
                                  Creasing creasing, const Entity& edge, Index vertex);

/// Tells how an edge or vertex loses its stratum in the next split, because its sharpness runs out.
/// Its new point is `weight` times the rule of its stratum plus 1 − weight times the rule of
/// stratum `next`.
struct Fading {
    int next = 0;
    double weight = 1;
    /// The edges of the crease that a vertex remains on, if `next` is a crease. Empty on a curve,
    /// where everything has stratum 1.
    std::optional<std::array<Index, 2>> staySharp = {};
};

/// Returns how an entity fades in the next split; nothing if it does not.
///
/// The weight of an edge is its sharpness. The weight of a vertex is the mean sharpness, at most 1,
/// of all that fades in it: the vertex and its edges. Under Creasing::Chaikin, an edge that fades
/// at one end only may have a sharpness above 1; the rules are then extrapolated, as in OpenSubdiv.
///
/// \cost O(edges at the ends of the entity); constant if nothing is semi-sharp
/// \cite OpenSubdiv 3.5, Sdc::Scheme::ComputeVertexVertexMask and ComputeEdgeVertexMask
ESPALIER_API std::optional<Fading> fadingOf(const CellComplex& complex, const Strata& strata,
                                            Creasing creasing, const Entity& entity);

}  // namespace espalier::far
