// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/refiner_options.h>

#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/random_lattices.h"
#include "support/zoo.h"

// Shapes to compare with OpenSubdiv.
namespace espalier::test {

/// Refines a shape with the options of its tags.
inline TopologyRefiner refined(const Lattice& shape, int level) {
    TopologyRefiner refiner(shape.complex, refinerOptions(shape));
    refiner.refineUniform(level);
    return refiner;
}

/// Returns the lattices of zoo.h and random_lattices.h: all kinds of the inventory, cells of types
/// 3 to 6, L-shapes, rings, tripods, darts, semi-sharp features.
inline std::vector<NamedLattice> allLattices() {
    std::vector<NamedLattice> all = zoo();
    for (NamedLattice& lattice : featureLattices()) all.push_back(std::move(lattice));
    return all;
}

inline constexpr unsigned kRandomLattices = 200;

}  // namespace espalier::test
