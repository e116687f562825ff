// SPDX-License-Identifier: Apache-2.0
//
// Deforms a model by a lattice: deform MODEL REST POSE OUT

#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/stencils/binding.h>
#include <espalier/stencils/composition.h>

using namespace espalier;

int main(int, char** arguments) {
    const auto model = io::readModel(arguments[1]);
    const Lattice rest = io::readLattice(arguments[2]), pose = io::readLattice(arguments[3]);

    // Once: refine the lattice, find each point of the model in it, compose the matrix.
    const int level = 3;
    const auto rules = stencils::Rules::Siggraph96;
    far::TopologyRefiner refiner(rest.complex, {.marks = rest.marks});
    refiner.refineUniform(level);
    const auto positions = stencils::refinePositions(refiner, level, rules, rest.positions);
    const auto embedding =
        stencils::embedPoints(refiner.level(level).complex, positions, model->positions());
    const auto binding =
        stencils::makeBinding<double>(refiner, level, rules, embedding, model->positions());

    // For every pose: one sparse product.
    model->write(arguments[4], osd::evaluateBinding(binding, pose.positions));
}
