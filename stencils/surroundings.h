// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/index_set.h>

#include <array>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

namespace espalier::stencils {

/// Tells which entities of a complex have surroundings of the same shape. What is around an entity
/// is all that shares a vertex with it. Two shapes are the same if what is around one entity
/// becomes what is around the other by renumbering that keeps the order of the numbers: the same
/// loops, from the same start and in the same direction, over vertices of the same order, on the
/// same strata.
///
/// Refinement and its rules see nothing but that: numbers enter as an order only, and the new
/// points inside an entity depend on nothing further out. So with neither semi-sharp features nor
/// open boundaries (whose fate is decided further out), and by Catmull-Clark's rules, the rows of
/// stencils inside two entities of one shape have the same weights, to the last bit, over columns
/// that renumber as the shapes do. By those of MLCA too on curves and meshes, whose loops say it
/// all; the point of a cell, however, depends on its edges and faces on the far side, of which the
/// shape of what is around an entity of a lattice says nothing.
class Surroundings {
public:
    explicit Surroundings(const far::Level& level);

    /// Whether rows inside entities follow from shapes, under these rules. RATS looks one vertex
    /// further, and MLCA at all parts of the cells around, of which a shape names those alone that
    /// touch the entity.
    static bool decideRows(const far::Level& level, const far::RefinerOptions& options);

    /// The number of the shape around an entity; they count from 0 as they are first met. Once very
    /// many are known, new ones are no longer remembered, and have another number each time.
    /// \cost O(entries around the entity)
    Index shapeOf(const Entity& entity);

    /// The vertices around the entity that was last asked for, ascending.
    const std::vector<Index>& vertices() const { return vertices_.items(); }

private:
    void collect(const Entity& entity);
    void describe(const Entity& entity);
    void describe(int dimension, Index index);

    struct Hash {
        std::size_t operator()(const std::vector<Index>& numbers) const;
    };

    /// What is read of the complex for each dimension, looked up once: 5 % of the time otherwise.
    struct Relations {
        const far::Incidence* ofVertex;
        const far::Incidence* toVertices;
        const far::SignedIncidence* boundary;  ///< of faces and cells
    };
    const far::Level& level_;
    std::vector<Relations> relations_;
    std::array<IndexSet, kMaxDimension + 1> around_;  ///< by dimension; 0: of the entity
    IndexSet vertices_;
    std::vector<Index> description_;
    std::unordered_map<std::vector<Index>, Index, Hash> shapes_;
    Index shapeCount_ = 0;
};

/// Vertices by the shape of their surroundings: rows of vertices of one group have the same
/// weights, over the vertices around them in ascending order.
struct ShapeGroups {
    std::vector<Index> firsts;             ///< one vertex of each group
    std::map<Index, std::size_t> groupOf;  ///< of each vertex
};

/// Where shapes do not decide rows, each vertex is a group of its own.
/// \param vertices of `level`, a level of `refiner`; repeats are allowed
ShapeGroups groupByShape(const far::TopologyRefiner& refiner, const far::Level& level,
                         std::span<const Index> vertices);

}  // namespace espalier::stencils
