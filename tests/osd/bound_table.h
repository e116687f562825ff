// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>

#include <utility>
#include <vector>

#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/zoo.h"

namespace espalier::test {

/// Returns D of random points in a lattice. The default number of points puts most rows in groups.
template <class Real>
StencilTable<Real> boundTable(const Lattice& lattice,
                              std::size_t pointCount = kIsSlow ? 1500 : 4000, int level = 3) {
    const TopologyRefiner base(lattice.complex, {.marks = lattice.marks});
    const auto bound =
        embed::bindPoints({base, lattice.positions},
                          pointsIn(Refined(lattice, level), pointCount, 5), {.level = level});
    return stencils::convertTable<Real>(bound.table);
}

/// Returns a table with all kinds of rows: outer products from a box; panels and ungrouped rows
/// from a cylinder, whose columns follow the columns of the box.
template <class Real>
StencilTable<Real> tableOfAllKinds() {
    const auto box = boundTable<Real>(shapes::box({.cells = {4, 3, 3}}));
    const auto cylinder = boundTable<Real>(shapes::cylinder({.sectors = 5}));
    Array<Offset> offsets(box.offsets().begin(), box.offsets().end());
    Array<Index> columns(box.columns().begin(), box.columns().end());
    Array<Real> weights(box.weights().begin(), box.weights().end());
    for (Index row = 0; row < cylinder.rowCount(); ++row) {
        for (const Index column : cylinder.columns(row))
            columns.push_back(box.columnCount() + column);
        offsets.push_back(Offset(columns.size()));
    }
    weights.insert(weights.end(), cylinder.weights().begin(), cylinder.weights().end());
    return {box.columnCount() + cylinder.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

}  // namespace espalier::test
