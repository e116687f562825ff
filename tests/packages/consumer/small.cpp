// SPDX-License-Identifier: Apache-2.0
//
// A smaller program: refines a cube. It needs two libraries only, which compile fast.

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/inventory.h>

int main() {
    const espalier::Lattice cube = espalier::shapes::box();
    espalier::far::TopologyRefiner refiner(cube.complex);
    refiner.refineUniform(2);
    return refiner.level(2).complex.count(3) == 64 ? 0 : 1;
}
