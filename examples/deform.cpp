// SPDX-License-Identifier: Apache-2.0
//
// Deforms a model by a lattice: deform MODEL REST POSE OUT

#include <espalier/bind/bind.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/osd/binding_evaluator.h>

using namespace espalier;

int main(int, char** arguments) {
    const auto model = io::readModel(arguments[1]);
    const Lattice rest = io::readLattice(arguments[2]), pose = io::readLattice(arguments[3]);

    // Once: find each point of the model in level 3 of the lattice, and compose the matrix.
    const far::TopologyRefiner base(rest.complex, {.marks = rest.marks});
    const auto binding =
        bind::bindPoints({base, rest.positions}, model->positions(), bind::Level{3});

    // For every pose: one sparse product.
    model->write(arguments[4], osd::evaluateBinding(binding, pose.positions));
}
