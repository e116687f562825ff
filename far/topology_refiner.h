// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/word.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/refinement.h>
#include <espalier/far/strata.h>
#include <espalier/far/topology_error.h>

#include <optional>
#include <span>
#include <vector>

// far/: refines topology. It knows neither positions nor weights.
//
// In: loops of vertex numbers, and marks. Out: refined levels with the strata of their entities.
//
// Types: CellComplex, built by ComplexBuilder; Strata; Refinement, from one level to the next;
// TopologyRefiner, the chain of levels.
//
// Read cell_complex.h, strata.h, refinement.h, then this header.
//
// Notation: n is a level, 0 the base. An interval [a, b] is a pair of entities, a contained in b or
// equal to it; its child has the dimension dim b − dim a.
namespace espalier::far {

/// The rules of refinement. The first two are Catmull-Clark's and differ only in the edge rule of
/// volumes, and only for interior edges with a number of faces other than four. On grids, the third
/// is equal to both.
enum class Rules {
    Siggraph96,  ///< edge (C̄ + 2Ā + (n − 3)M)/n   MacCracken & Joy 1996, section 2.2
    Cse96,       ///< edge (C̄ + 2Ā + M)/4           Joy & MacCracken CSE-96-1, section 6
    Mlca,        ///< split, then average: see stencils/mlca.h    Bajaj, Schaefer, Warren & Xu 2002
    Rats         ///< curves and meshes only: see stencils/rats.h   Savva & Clapworthy, section 2.2
};
inline constexpr Word<Rules> kRulesWords[] = {{"siggraph96", Rules::Siggraph96},
                                              {"cse96", Rules::Cse96},
                                              {"mlca", Rules::Mlca},
                                              {"rats", Rules::Rats}};

/// The weight of a triangle in the point of a smooth edge of a surface.
enum class TriangleSubdivision {
    Catmark,  ///< the same as for every face
    Smooth    ///< 0.47 instead of 1/4 for the triangle's centroid: OpenSubdiv's "smooth triangles"
};
inline constexpr Word<TriangleSubdivision> kTriangleSubdivisionWords[] = {
    {"catmark", TriangleSubdivision::Catmark}, {"smooth", TriangleSubdivision::Smooth}};

/// How to refine a complex; chosen once, at level 0.
struct RefinerOptions {
    Rules rules = Rules::Siggraph96;
    Boundary boundary = Boundary::Sharp;
    SharpEdges sharpEdges = SharpEdges::SingleCell;
    Creasing creasing = Creasing::Uniform;
    TriangleSubdivision triangles = TriangleSubdivision::Catmark;
    Marks marks = {};
};

/// One level of the chain: a complex and the strata of its entities.
struct Level {
    CellComplex complex;
    Strata strata;
    std::vector<Index> holes = {};  ///< faces of a mesh that are holes, ascending
};

struct FaceVaryingTopology;
enum class FaceVaryingLinear;

/// Refines a complex level by level. Level 0 is the base; level k has about 8 times (lattice), 4
/// times (mesh) or twice (curve) the entities of level k − 1.
///
/// Vertices of level k are numbered as in Refinement: the vertex points, edge points, face points
/// and cell points of level k − 1. So under Boundary::Sharp, vertex i of a level is the vertex
/// point of vertex i of the level before.
///
/// Any number of threads may call const functions at once.
class ESPALIER_API TopologyRefiner {
public:
    /// \throws TopologyError for marks that do not fit `base`; under Rules::Rats (BadMark) for an
    ///         edge or a vertex that is semi-sharp
    /// \throws Error under Rules::Mlca and Rules::Rats for TriangleSubdivision::Smooth; under
    ///         Rules::Rats for a lattice and for Boundary::Open
    explicit TopologyRefiner(CellComplex base, const RefinerOptions& options = {});

    /// Continues the chain of another refiner: level 0 is `first`.
    /// \param options of the other refiner; its marks are not read again
    explicit TopologyRefiner(Level first, const RefinerOptions& options = {});

    /// Refines up to `level`. Does nothing if the level exists.
    ///
    /// \throws TopologyError (TooManyEntities; EmptyComplex under Boundary::Open); MemoryError. The
    ///         levels made before are kept. If a level is too large, the function throws before it
    ///         makes any level; except under Boundary::Open, where sizes are not known in advance
    /// \throws Error after refineAround(), which leaves the finest level incomplete
    /// \cost O(entries of the new levels)
    void refineUniform(int level);

    /// How much of a level refineAround() creates.
    enum class Extent {
        Ring,  ///< the cells [v, c] with v a vertex of one of the given cells: the children of
               ///< these cells, and all cells around the children
        Cells  ///< the children of the given cells only; no level can follow
    };

    /// Adds one level that contains only what some cells need.
    ///
    /// The entities that exist have the same order as in the whole level. The children of `cells`
    /// are as in the whole level: their vertices have the same rows in level tables, and the
    /// entities that contain such a vertex have the same strata. With Extent::Ring, the vertices of
    /// the cells around the children have the same rows, too. The outermost cells lack neighbours,
    /// so rows and strata on their outer side may differ.
    ///
    /// \param cells entities of dimension() of the finest level, ascending; if that level was made
    ///        by refineAround(), children of the cells that were given then
    /// \throws Error if `cells` is empty, or that names the first of `cells` that is not such an
    ///         entity; TopologyError (TooManyEntities; EmptyComplex under Boundary::Open);
    ///         MemoryError
    /// \cost O(entries of the finest level and of the new one)
    void refineAround(std::span<const Index> cells, Extent extent = Extent::Ring);

    /// Returns true if the finest level is complete.
    bool isUniform() const { return !chosen_; }

    int dimension() const { return level(0).complex.dimension(); }
    Rules rules() const { return options_.rules; }
    Boundary boundary() const { return options_.boundary; }
    const RefinerOptions& options() const { return options_; }

    /// Returns the number of the finest level so far.
    int maxLevel() const { return static_cast<int>(levels_.size()) - 1; }

    /// Returns a level.
    /// \param level 0 to maxLevel()
    /// \throws Error if `level` is out of range
    const Level& level(int level) const;

    /// Returns the split of level `level` − 1 into level `level`: the maps between parents and
    /// children.
    /// \param level 1 to maxLevel()
    /// \throws Error if `level` is out of range
    const Refinement& refinement(int level) const;

private:
    friend FaceVaryingTopology refineFaceVarying(const TopologyRefiner& refiner,
                                                 std::span<const Index> cornerValues,
                                                 FaceVaryingLinear linear);

    /// Splits a complete level, without the children on its open boundary.
    static Refinement splitWhole(const Level& parent, Boundary boundary);

    void addLevel(Refinement refinement);
    void addLevel(Refinement refinement, Strata strata);

    RefinerOptions options_;
    /// The cells around which the finest level is complete; nothing if it is complete everywhere.
    std::optional<std::vector<Index>> chosen_;
    std::vector<Level> levels_;
    std::vector<Refinement> refinements_;
};

}  // namespace espalier::far
