// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/strata.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/masks.h>
#include <espalier/stencils/mlca.h>
#include <espalier/stencils/rats.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include "vertex_parents.h"

namespace espalier::stencils {
namespace {

using far::CellComplex;
using far::Rules;

/// The sub-complex that a rule averages over: the entities of a stratum, without the edges that
/// fade.
struct Neighbourhood {
    const far::Level& level;
    const Entity& entity;
    int stratum;
    std::optional<std::array<Index, 2>> crease = {};  ///< the edges of the crease that a vertex
                                                      ///< remains on

    /// Calls visit(other) for each entity of a dimension that is equal to the entity or contains
    /// it.
    template <class Visit>
    void forEach(int dimension, Visit visit) const {
        for (const Index index :
             level.complex.relation(entity.dimension, dimension)[entity.index]) {
            const Entity other{dimension, index};
            if (!level.strata.inSubcomplex(entity, stratum, other)) continue;
            if (crease && dimension == 1 && !far::contains(*crease, index)) continue;
            visit(other);
        }
    }

    Index count(int dimension) const {
        Index count = 0;
        forEach(dimension, [&](const Entity&) { ++count; });
        return count;
    }
};

Mask maskOf(const Neighbourhood& around, const far::RefinerOptions& options) {
    const Entity& entity = around.entity;
    const int stratum = around.stratum;
    const bool isSurfaceEdge = entity.dimension == 1 && stratum == 2;
    if (isSurfaceEdge && options.triangles == far::TriangleSubdivision::Smooth) {
        int triangleCount = 0;
        around.forEach(2, [&](const Entity& face) {
            triangleCount += around.level.complex.boundary(2)[face.index].size() == 3;
        });
        return smoothTriangleMask(triangleCount);
    }
    // n in the rules: faces at an edge of the volume, edges at a vertex of the surface.
    const bool needsValence = entity.dimension == stratum - 2;
    return refinementMask(options.rules, entity.dimension, stratum,
                          needsValence ? around.count(entity.dimension + 1) : 0);
}

/// Adds `weight` / `count` times the centroid of an entity.
/// \param verticesOf the vertices of all entities of its dimension
void addCentroid(const far::Incidence& verticesOf, const Entity& entity, double weight,
                 double count, RowAccumulator& row) {
    const auto vertices = verticesOf[entity.index];
    const double share = weight / (count * static_cast<double>(vertices.size()));
    for (const Index vertex : vertices) row.add(vertex, share);
}

/// Adds `scale` times a mask, as weights of the vertices of each centroid in each average. The
/// entity itself comes last: its weight is large, and the many small weights at a vertex with many
/// edges are summed more accurately before it (with 360 edges at a vertex, the error is 2e-17
/// instead of 2e-14).
void addMask(const Neighbourhood& around, const Mask& mask, double scale, RowAccumulator& row) {
    for (int dimension = around.stratum; dimension >= around.entity.dimension; --dimension) {
        const double weight = scale * mask[dimension];
        if (weight == 0) continue;
        const Index count = around.count(dimension);
        const far::Incidence& verticesOf = around.level.complex.relation(dimension, 0);
        around.forEach(dimension, [&](const Entity& other) {
            addCentroid(verticesOf, other, weight, count, row);
        });
    }
}

/// Adds the row of a new point of RATS.
void addRatsRow(const far::Level& level, const Entity& entity, RowAccumulator& row) {
    const std::vector<Entity> sources = ratsSources(level, entity);
    for (const Entity& source : sources) {
        const int stratum = level.strata.of(source);
        addMask({level, source, stratum}, refinementMask(Rules::Rats, source.dimension, stratum, 0),
                1.0 / static_cast<double>(sources.size()), row);
    }
}

/// Adds `scale` times the rule of MLCA: the centroids of all sub-cells at the point of the entity.
void addSubCells(const Neighbourhood& around, double scale, RowAccumulator& row) {
    const far::CellComplex& complex = around.level.complex;
    const Entity& entity = around.entity;
    const auto own = complex.relation(entity.dimension, 0)[entity.index];
    const double share = scale / (around.count(around.stratum) * static_cast<double>(own.size()));
    std::optional<Index> last;
    around.forEach(around.stratum, [&](const Entity& whole) {
        // A face that passes the entity more than once is listed as often, consecutively.
        if (std::exchange(last, whole.index) == whole.index) return;
        const auto corners = complex.relation(whole.dimension, 0)[whole.index];
        for (std::size_t corner = 0; corner < corners.size(); ++corner) {
            if (!far::contains(own, corners[corner])) continue;
            const std::vector<Entity> parts = mlcaSubCell(complex, whole, corner);
            const auto times = std::count(parts.begin(), parts.end(), entity);
            for (const Entity& part : parts)
                addCentroid(complex.relation(part.dimension, 0), part,
                            share * static_cast<double>(times), static_cast<double>(parts.size()),
                            row);
        }
    });
}

/// Adds the row of a new point of Catmull-Clark or MLCA: by the rule of its stratum, blended with
/// the rule of the next stratum if the entity fades.
void addBlendedRow(const far::TopologyRefiner& refiner, const far::Level& level,
                   const Entity& entity, RowAccumulator& row) {
    const far::RefinerOptions& options = refiner.options();
    const auto addRule = [&](const Neighbourhood& around, double scale) {
        if (options.rules == Rules::Mlca)
            addSubCells(around, scale, row);
        else
            addMask(around, maskOf(around, options), scale, row);
    };
    const auto fading = far::fadingOf(level.complex, level.strata, options.creasing, entity);
    addRule({level, entity, level.strata.of(entity)}, fading ? fading->weight : 1);
    if (fading) addRule({level, entity, fading->next, fading->staySharp}, 1 - fading->weight);
}

}  // namespace

StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level,
                                     std::span<const Index> vertices) {
    const VertexParents parents(refiner, level);
    checkVertices(refiner, level, vertices);
    const far::Level& parent = refiner.level(level - 1);
    return buildTable(static_cast<Index>(vertices.size()), parent.complex.count(0),
                      [&](Index row, RowAccumulator& accumulator) {
                          const Index vertex = vertices[row];
                          const Entity entity = parents(vertex);
                          if (refiner.rules() == Rules::Rats)
                              addRatsRow(parent, entity, accumulator);
                          else
                              addBlendedRow(refiner, parent, entity, accumulator);
                      });
}

StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level) {
    std::vector<Index> all(refiner.level(level).complex.count(0));
    std::iota(all.begin(), all.end(), Index{0});
    return buildLevelTable(refiner, level, all);
}

}  // namespace espalier::stencils
