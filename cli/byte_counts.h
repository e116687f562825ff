// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/embedding.h>

#include <cstddef>
#include <span>

namespace espalier::cli {

// Memory of what the stages make.

/// A table's offsets, columns and weights.
template <class Real>
std::size_t bytesOf(const stencils::StencilTable<Real>& table) {
    return table.offsets().size_bytes() + table.columns().size_bytes() +
           table.weights().size_bytes();
}

/// Where the points of a model lie: one status, place and distance each.
template <class Place>
std::size_t bytesOf(const stencils::PlacedPoints<Place>& embedding) {
    return std::span(embedding.points).size_bytes();
}

/// The stored relations ∂ of the levels above the base, their offsets and signs. The strata, the
/// maps from parents to children and the relations that are derived when asked for come on top.
inline std::size_t bytesOf(const far::TopologyRefiner& refiner) {
    std::size_t bytes = 0;
    for (int level = 1; level <= refiner.maxLevel(); ++level)
        for (int dimension = 1; dimension <= refiner.dimension(); ++dimension) {
            const far::Incidence& rows =
                refiner.level(level).complex.boundary(dimension).unsignedRows();
            const auto offsetCount = static_cast<std::size_t>(rows.rowCount()) + 1;
            bytes += rows.values().size_bytes() + offsetCount * sizeof(far::Offset) +
                     rows.values().size() * sizeof(far::Signed::sign);
        }
    return bytes;
}

}  // namespace espalier::cli
