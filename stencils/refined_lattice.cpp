// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/level_lattice.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/refined_lattice.h>

namespace espalier::stencils {

namespace {

FaceVaryingAttribute refined(const far::TopologyRefiner& refiner, int level,
                             const FaceVaryingAttribute& base, far::FaceVaryingLinear linear) {
    const far::FaceVaryingTopology cut = far::refineFaceVarying(refiner, base.corners, linear);
    std::vector<double> values;
    for (const Index value : cut.values)
        for (int i = 0; i < base.components; ++i)
            values.push_back(base.values[static_cast<Offset>(value) * base.components + i]);
    const std::span<const Index> corners = cut.refiner.level(level).complex.relation(2, 0).values();
    return {base.components,
            refineValues(cut.refiner, level, values, base.components),
            {corners.begin(), corners.end()}};
}

}  // namespace

Lattice refinedLattice(const far::TopologyRefiner& refiner, int level, const Lattice& base,
                       far::FaceVaryingLinear linear) {
    Lattice refined = levelLattice(refiner, level, refinePositions(refiner, level, base.positions));
    for (const auto& [name, components, values] : base.attributes)
        refined.attributes.push_back(
            {name, components, refineValues(refiner, level, values, components)});
    refined.integers = levelIntegers(refiner, level, base.integers);
    if (!base.textureCoordinates.empty())
        refined.textureCoordinates =
            stencils::refined(refiner, level, base.textureCoordinates, linear);
    return refined;
}

}  // namespace espalier::stencils
