// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/inventory.h>
#include <espalier/stencils/local_binding.h>

#include <vector>

#include "support/refined_lattice.h"
#include "support/zoo.h"

namespace espalier::test {

/// D of random points in a lattice at level 3: some thousand, so that most rows are in groups.
template <class Real>
stencils::StencilTable<Real> boundTable(const Lattice& lattice, std::size_t pointCount = 4000) {
    const Refined refined(lattice, 3);
    return stencils::bindPoints<Real>(far::TopologyRefiner(lattice.complex), lattice.positions, 3,
                                      stencils::Rules::Siggraph96, pointsIn(refined, pointCount, 5))
        .binding.table;
}

/// Between −1 and 1.
template <class Real>
std::vector<Real> randomValuesOf(far::Offset count, unsigned seed) {
    const auto values = randomValues(static_cast<std::size_t>(count), seed);
    return {values.begin(), values.end()};
}

}  // namespace espalier::test
