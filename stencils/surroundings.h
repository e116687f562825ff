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

/// Finds the entities of a complex whose surroundings have the same shape. The surroundings of an
/// entity are all entities that share a vertex with it. Two surroundings have the same shape if
/// renumbering in the same order turns one into the other: then they have the same loops, with the
/// same start and direction, over vertices in the same order, on the same strata.
///
/// Refinement and its rules depend on nothing else: they use numbers only for their order, and the
/// new points inside an entity depend only on its surroundings. So, under Catmull-Clark's rules and
/// without semi-sharp features or open boundaries (which depend on entities farther away), the rows
/// of stencils inside two entities of the same shape have the same weights, to the last bit; their
/// columns are renumbered as the shapes are. The same holds for MLCA on curves and meshes, whose
/// loops contain everything that it uses. It does not hold for MLCA on lattices: the point of a
/// cell depends on edges and faces on the cell's far side, which the surroundings of an entity do
/// not include.
class Surroundings {
public:
    explicit Surroundings(const far::Level& level);

    /// Returns true if the shape around an entity determines the rows inside it. It does not under
    /// RATS, which uses vertices one step farther away, nor under MLCA on lattices, which uses all
    /// parts of the cells around, while a shape names only those that touch the entity.
    static bool shapesDetermineRows(const far::Level& level, const far::RefinerOptions& options);

    /// Returns the number of the shape around an entity, counted from 0 in the order of first
    /// occurrence. After several thousand shapes, new ones are not stored, and get a different
    /// number each time.
    /// \cost O(entries around the entity)
    Index shapeOf(const Entity& entity);

    /// The vertices around the entity of the last call of shapeOf(), ascending.
    const std::vector<Index>& vertices() const { return vertices_.items(); }

private:
    void collect(const Entity& entity);
    void describe(const Entity& entity);
    void describe(int dimension, Index index);

    struct Hash {
        std::size_t operator()(const std::vector<Index>& numbers) const;
    };

    /// The relations that are read for each dimension; looking them up once saves 5 % of the time.
    struct Relations {
        const far::Incidence* ofVertex;
        const far::Incidence* toVertices;
        const far::SignedIncidence* boundary;  ///< the signed boundary of faces and cells
    };
    const far::Level& level_;
    std::vector<Relations> relations_;
    /// Entities around one entity, by dimension; [0] holds the entity's own vertices.
    std::array<IndexSet, kMaxDimension + 1> around_;
    IndexSet vertices_;
    std::vector<Index> description_;
    std::unordered_map<std::vector<Index>, Index, Hash> shapes_;
    Index shapeCount_ = 0;
};

/// Vertices grouped by the shape of their surroundings. Rows of vertices in the same group have the
/// same weights, over the vertices around them in ascending order.
struct ShapeGroups {
    std::vector<Index> representatives;    ///< one vertex of each group
    std::map<Index, std::size_t> groupOf;  ///< the group of each vertex
};

/// Groups vertices by shape. If shapes do not determine rows, each vertex is a separate group.
/// \param vertices of `level`, a level of `refiner`; repeats are allowed
ShapeGroups groupByShape(const far::TopologyRefiner& refiner, const far::Level& level,
                         std::span<const Index> vertices);

}  // namespace espalier::stencils
