// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/shapes/level_lattice.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/refined_lattice.h>

namespace espalier::stencils {

namespace {

FaceVaryingAttribute refined(const far::TopologyRefiner& refiner, int level,
                             const FaceVaryingAttribute& base, far::FaceVaryingLinear linear) {
    const far::FaceVaryingTopology cut = far::refineFaceVarying(refiner, base.corners, linear);
    const auto valueCount = static_cast<Offset>(base.values.size()) / base.components;
    std::vector<double> values;
    for (const Index value : cut.values) {
        if (value >= valueCount)
            throw Error(concat("a corner of a face names the texture coordinate ", value,
                               "; there are ", valueCount));
        for (int i = 0; i < base.components; ++i)
            values.push_back(base.values[static_cast<Offset>(value) * base.components + i]);
    }
    const std::span<const Index> corners = cut.refiner.level(level).complex.relation(2, 0).values();
    return {base.components,
            refineValues(cut.refiner, level, values, base.components),
            {corners.begin(), corners.end()}};
}

}  // namespace

Lattice refinedLattice(const far::TopologyRefiner& refiner, int level, const Lattice& base,
                       std::optional<far::FaceVaryingLinear> linear) {
    Lattice refined = levelLattice(refiner, level, refinePositions(refiner, level, base.positions));
    for (const auto& [name, components, values] : base.attributes)
        refined.attributes.push_back(
            {name, components, refineValues(refiner, level, values, components)});
    refined.integers = levelIntegers(refiner, level, base.integers);
    refined.tags.faceVarying = base.tags.faceVarying;
    if (!base.textureCoordinates.empty()) {
        const auto mode =
            linear.value_or(base.tags.faceVarying.value_or(far::FaceVaryingLinear::All));
        refined.textureCoordinates =
            stencils::refined(refiner, level, base.textureCoordinates, mode);
        refined.tags.faceVarying = mode;
    }
    return refined;
}

}  // namespace espalier::stencils
