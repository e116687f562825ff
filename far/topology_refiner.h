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

// far/: topology. No positions and no weights.
//
// In: loops of vertex numbers, and marks. Out: refined levels with the strata of their entities.
//
// Types: CellComplex, built by ComplexBuilder; Strata; Refinement, from one level to the next;
// TopologyRefiner, the chain of levels.
//
// Read cell_complex.h, strata.h, refinement.h, then this header.
//
// Notation: n is a level, 0 the base. An interval [a, b] is a pair of entities, a in b; its child
// has the dimension dim b − dim a.
namespace espalier::far {

/// The rules of refinement. The first two are Catmull-Clark's, and differ in the edge rule of
/// volumes only, and there only where other than four faces meet in an interior edge. On grids the
/// third is the same again.
enum class Rules {
    Siggraph96,  ///< edge (C̄ + 2Ā + (n − 3)M)/n   MacCracken & Joy 1996, section 2.2
    Cse96,       ///< edge (C̄ + 2Ā + M)/4           Joy & MacCracken CSE-96-1, section 6
    Mlca,        ///< split, then average: see stencils/mlca.h    Bajaj, Schaefer, Warren & Xu 2002
    Rats         ///< of curves and meshes: see stencils/rats.h   Savva & Clapworthy, section 2.2
};
inline constexpr Word<Rules> kRulesWords[] = {{"siggraph96", Rules::Siggraph96},
                                              {"cse96", Rules::Cse96},
                                              {"mlca", Rules::Mlca},
                                              {"rats", Rules::Rats}};

/// The weights of a triangle at a smooth edge of a surface.
enum class TriangleSubdivision {
    Catmark,  ///< those of every face
    Smooth    ///< 0.47 in place of 1/4 for its centroid: OpenSubdiv's "smooth triangles"
};
inline constexpr Word<TriangleSubdivision> kTriangleSubdivisionWords[] = {
    {"catmark", TriangleSubdivision::Catmark}, {"smooth", TriangleSubdivision::Smooth}};

/// How a complex is refined; decided once, at level 0.
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
    std::vector<Index> holes = {};  ///< of a mesh: faces, ascending
};

/// The chain of refined complexes. Level 0 is the base; level k has about 8 times (lattice), 4
/// times (mesh) or twice (curve) the entities of level k − 1.
///
/// Vertices of level k are numbered as Refinement says: vertex points, edge points, face points,
/// cell points of level k − 1. So under Boundary::Sharp, vertex i of a level is the vertex point of
/// vertex i of the level before.
///
/// Const calls are safe from any number of threads.
class ESPALIER_API TopologyRefiner {
public:
    /// \throws TopologyError for marks that do not fit `base`; under Rules::Rats (BadMark) for an
    ///         edge or a vertex that is semi-sharp
    /// \throws Error under Rules::Mlca and Rules::Rats for TriangleSubdivision::Smooth; under
    ///         Rules::Rats for a lattice and for Boundary::Open, as it reaches the border
    explicit TopologyRefiner(CellComplex base, const RefinerOptions& options = {});

    /// A chain that goes on from a level of another one: level 0 of this is `first`.
    /// \param options of the other one; its marks were read there
    explicit TopologyRefiner(Level first, const RefinerOptions& options = {});

    /// Adds levels until maxLevel() is `level`; those already there stay.
    ///
    /// \throws TopologyError (TooManyEntities; EmptyComplex under Boundary::Open); MemoryError. The
    ///         levels made before stay. A level that is too large is refused before any is made,
    ///         but under Boundary::Open, where its size is not known beforehand
    /// \throws Error after refineAround(): parts of the levels are not there
    /// \cost O(entries of the new levels)
    void refineUniform(int level);

    /// How much of a level refineAround() makes.
    enum class Extent {
        Ring,  ///< the cells [v, c] with v a vertex of one of the given cells: their children, and
               ///< all that is around these
        Cells  ///< their children alone; no level can follow
    };

    /// Adds one level that holds no more than some cells need.
    ///
    /// What is there has the same order as in the whole level. The same are the rows of level
    /// tables for the vertices of the children of `cells` and, with Extent::Ring, for those in the
    /// cells around the children, and the strata of what contains a vertex of a child. The
    /// outermost cells lack neighbours, so that no more can be said of what lies on their outer
    /// side.
    ///
    /// \param cells entities of dimension() of the finest level, ascending; where that was made
    ///        like this, children of the cells that were given then
    /// \throws Error if it is not so, naming the first; and what refineUniform() throws
    /// \cost O(entries of the finest level, and of the new one)
    void refineAround(std::span<const Index> cells, Extent extent = Extent::Ring);

    /// Whether the finest level holds all of it.
    bool isUniform() const { return !chosen_; }

    int dimension() const { return level(0).complex.dimension(); }
    Rules rules() const { return options_.rules; }
    Boundary boundary() const { return options_.boundary; }
    const RefinerOptions& options() const { return options_; }

    /// The finest level so far.
    int maxLevel() const { return static_cast<int>(levels_.size()) - 1; }

    /// \param level 0 to maxLevel()
    /// \throws Error if it is none of these
    const Level& level(int level) const;

    /// The split of level `level` − 1 into level `level`: parent and child maps.
    /// \param level 1 to maxLevel()
    /// \throws Error if it is none of these
    const Refinement& refinement(int level) const;

private:
    void addLevel(const Refinement::Kept* kept);

    RefinerOptions options_;
    /// The cells around which the finest level is whole; nothing where it is everywhere.
    std::optional<std::vector<Index>> chosen_;
    std::vector<Level> levels_;
    std::vector<Refinement> refinements_;
};

}  // namespace espalier::far
