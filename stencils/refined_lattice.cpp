// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/level_lattice.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/refined_lattice.h>

namespace espalier::stencils {

Lattice refinedLattice(const far::TopologyRefiner& refiner, int level, const Lattice& base) {
    Lattice refined = levelLattice(refiner, level, refinePositions(refiner, level, base.positions));
    for (const auto& [name, components, values] : base.attributes)
        refined.attributes.push_back(
            {name, components, refineValues(refiner, level, values, components)});
    refined.integers = levelIntegers(refiner, level, base.integers);
    return refined;
}

}  // namespace espalier::stencils
