// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/compare/face_varying_comparison.h>
#include <espalier/compare/open_subdiv_tables.h>
#include <espalier/stencils/composition.h>

#include <opensubdiv/far/stencilTableFactory.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "level_match.h"
#include "open_subdiv_refiner.h"

namespace espalier::compare {
namespace {

/// Adds `scale` times a row of a table to weights by value.
/// \param values the value of each column; empty if columns are values
void addRow(const stencils::StencilTable<double>& table, Index row, double scale,
            std::span<const Index> values, std::map<Index, double>& weights) {
    const auto columns = table.columns(row);
    for (std::size_t i = 0; i < columns.size(); ++i)
        weights[values.empty() ? columns[i] : values[columns[i]]] += scale * table.weights(row)[i];
}

/// Returns OpenSubdiv's value at the corner of a face that is at a vertex of OpenSubdiv.
Index valueAt(const OpenSubdiv::Far::TopologyLevel& level, Index face,
              std::optional<Index> vertex) {
    const auto loop = level.GetFaceVertices(face);
    for (int corner = 0; corner < loop.size(); ++corner)
        if (vertex == loop[corner]) return level.GetFaceFVarValues(face)[corner];
    throw Error(concat("a corner of OpenSubdiv's face ", face, " has no match"));
}

}  // namespace

std::vector<double> faceVaryingDifferences(const far::TopologyRefiner& refiner,
                                           std::span<const Index> cornerValues,
                                           far::FaceVaryingLinear linear) {
    namespace Far = OpenSubdiv::Far;
    const far::FaceVaryingTopology ours = far::refineFaceVarying(refiner, cornerValues, linear);
    const far::CellComplex& base = refiner.level(0).complex;
    const Surface surface = surfaceOf(base);
    const FaceVaryingValues faceVarying{cornerValues, linear};
    const auto openSubdiv = makeOpenSubdivRefiner(refiner, surface, &faceVarying).refiner;
    using Factory = Far::StencilTableFactoryReal<double>;
    Factory::Options options;
    options.interpolationMode = Factory::INTERPOLATE_FACE_VARYING;
    options.maxLevel = static_cast<unsigned>(refiner.maxLevel()) & 15U;
    const std::unique_ptr<const Far::StencilTableReal<double>> all(
        Factory::Create(*openSubdiv, options));

    std::vector<double> differences;
    LevelMatch match = matchBase(base, surface, openSubdiv->GetLevel(0));
    Index firstRow = 0;
    for (int k = 1; k <= refiner.maxLevel(); ++k) {
        match = matchChildren(refiner.level(k - 1).complex, match, refiner.refinement(k),
                              openSubdiv->GetLevel(k - 1));
        const Far::TopologyLevel level = openSubdiv->GetLevel(k);
        const auto theirTable = fromOpenSubdiv(*all, firstRow, level.GetNumFVarValues());
        firstRow += level.GetNumFVarValues();
        const auto ourTable = stencils::buildStencils(ours.refiner, k);
        const far::Incidence& loops = refiner.level(k).complex.relation(2, 0);
        const far::Incidence& values = ours.refiner.level(k).complex.relation(2, 0);
        double largest = 0;
        for (const Index face : comparedRegion(refiner, k, match, level).faces)
            for (std::size_t corner = 0; corner < loops[face].size(); ++corner) {
                std::map<Index, double> weights;
                addRow(ourTable, values[face][corner], 1, ours.values, weights);
                addRow(theirTable,
                       valueAt(level, *match.of({2, face}), match.of({0, loops[face][corner]})), -1,
                       {}, weights);
                for (const auto& [value, difference] : weights)
                    largest = std::max(largest, std::abs(difference));
            }
        differences.push_back(largest);
    }
    return differences;
}

}  // namespace espalier::compare
