// SPDX-License-Identifier: Apache-2.0
//
// Less than main.cpp: a cube, refined. It needs two of the libraries, which are soon compiled.

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/inventory.h>

int main() {
    const espalier::Lattice cube = espalier::shapes::box();
    espalier::far::TopologyRefiner refiner(cube.complex);
    refiner.refineUniform(2);
    return refiner.level(2).complex.count(3) == 64 ? 0 : 1;
}
