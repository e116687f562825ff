// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/far/standard_cells.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/limit/vertex_ring.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/surroundings.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace espalier::limit {
namespace {

/// For each corner of a hexahedron in VTK's order, the opposite corner.
constexpr std::array<std::size_t, 8> kOpposite = {6, 7, 4, 5, 2, 3, 0, 1};

/// Returns the vertex of an edge, a quadrilateral or a hexahedron that is opposite to `vertex`.
Index opposite(const far::CellComplex& complex, const Entity& entity, Index vertex) {
    if (entity.dimension == 3) {
        const auto corners = *far::hexahedronVertices(complex, CellId(entity.index));
        const auto at = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
        return corners[kOpposite[at]];
    }
    const auto loop = complex.relation(entity.dimension, 0)[entity.index];
    const std::size_t at = std::find(loop.begin(), loop.end(), vertex) - loop.begin();
    return loop[(at + loop.size() / 2) % loop.size()];
}

/// Adds the limit of a regular vertex on stratum s: the product of (1, 4, 1)/6 along s axes.
void addRegularRow(const far::Level& level, Index vertex, stencils::RowAccumulator& row) {
    const Entity self{0, vertex};
    const int stratum = level.strata.of(self);
    for (int d = 0; d <= stratum; ++d) {
        double weight = 1;
        for (int axis = 0; axis < stratum; ++axis) weight *= axis < d ? 1.0 / 6 : 4.0 / 6;
        for (const Index index : level.complex.relation(0, d)[vertex]) {
            const Entity other{d, index};
            if (level.strata.inSubcomplex(self, stratum, other))
                row.add(d == 0 ? vertex : opposite(level.complex, other, vertex), weight);
        }
    }
}

/// Limits of irregular vertices, computed once for each distinct shape of ring.
class IrregularLimits {
public:
    IrregularLimits(const far::TopologyRefiner& refiner, const far::Level& level,
                    std::span<const Index> vertices)
        : groups_(stencils::groupByShape(refiner, level, vertices)) {
        const std::vector<Index>& representatives = groups_.representatives;
        masks_.resize(representatives.size());
        parallelFor(std::ssize(representatives), 1, [&](Offset first, Offset last) {
            for (Offset i = first; i < last; ++i) {
                const VertexRing ring = ringOf(level, refiner.options(), representatives[i]);
                masks_[i] = ring.start.transpose() * limitMask(ring);
            }
        });
    }

    /// Weights of the vertices around `vertex`, in ascending order of the vertices.
    const Eigen::VectorXd& maskOf(Index vertex) const { return masks_[groups_.groupOf.at(vertex)]; }

private:
    stencils::ShapeGroups groups_;
    std::vector<Eigen::VectorXd> masks_;
};

}  // namespace

void checkLimitRules(far::Rules rules) {
    if (rules == far::Rules::Rats)
        throw Error(
            "limits are not known under the rules of RATS, which look beyond the ring of a "
            "vertex");
}

stencils::StencilTable<double> buildLimitMasks(const far::TopologyRefiner& refiner, int level,
                                               std::span<const Index> vertices) {
    stencils::checkVertices(refiner, level, vertices);
    checkLimitRules(refiner.rules());
    const far::Level& here = refiner.level(level);
    std::vector<std::uint8_t> isRegular(vertices.size());
    parallelFor(std::ssize(vertices), 4096, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i)
            isRegular[i] =
                here.complex.dimension() == 3 && embed::isRegularVertex(here, vertices[i]);
    });
    std::vector<Index> irregular;
    for (std::size_t i = 0; i < vertices.size(); ++i)
        if (!isRegular[i] && !here.strata.isOpen({0, vertices[i]}))
            irregular.push_back(vertices[i]);
    const IrregularLimits limits(refiner, here, irregular);
    return stencils::buildTable(
        static_cast<Index>(vertices.size()), here.complex.count(0),
        [&](Index row, stencils::RowAccumulator& accumulator) {
            const Index vertex = vertices[row];
            if (isRegular[row]) {
                addRegularRow(here, vertex, accumulator);
                return;
            }
            if (here.strata.isOpen({0, vertex})) return;
            const Eigen::VectorXd& mask = limits.maskOf(vertex);
            const std::vector<Index> around = verticesAround(here.complex, vertex);
            for (std::size_t i = 0; i < around.size(); ++i)
                accumulator.add(around[i], mask[static_cast<Eigen::Index>(i)]);
        });
}

stencils::StencilTable<double> buildVertexLimits(const far::TopologyRefiner& refiner, int level,
                                                 std::span<const Index> vertices) {
    const stencils::CompactTable limits =
        stencils::compactColumns(buildLimitMasks(refiner, level, vertices));
    return stencils::multiply(limits.table,
                              stencils::buildStencils(refiner, level, limits.columns));
}

stencils::StencilTable<double> buildVertexLimits(const far::TopologyRefiner& refiner, int level) {
    std::vector<Index> all(refiner.level(level).complex.count(0));
    std::iota(all.begin(), all.end(), Index{0});
    return buildVertexLimits(refiner, level, all);
}

}  // namespace espalier::limit
