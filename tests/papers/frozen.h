// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Core>

#include "support/complexes.h"
#include "support/test.h"

// Shapes with their positions, refined; and models frozen to them.
namespace espalier::test {

inline Eigen::Vector3d vec(const Point3& p) {
    return Eigen::Vector3d(p.data());
}

inline TopologyRefiner refined(const Lattice& lattice, int levels,
                               Boundary boundary = Boundary::Sharp) {
    TopologyRefiner refiner =
        test::refined(lattice.complex, levels, {.boundary = boundary, .marks = lattice.marks});
    return refiner;
}

inline std::vector<Point3> positionsAt(const Lattice& lattice, const TopologyRefiner& refiner,
                                       int level) {
    return stencils::refinePositions(refiner, level, stencils::Rules::Siggraph96,
                                     lattice.positions);
}

/// A model frozen to a lattice (MacCracken & Joy 1996, section 5), all of it inside.
struct Frozen {
    Lattice rest;
    std::vector<Point3> model;
    embed::Binding binding;

    Frozen(const Lattice& lattice, int level, const std::vector<Point3>& points)
        : rest(lattice), model(points) {
        const TopologyRefiner refiner = refined(rest, level);
        const embed::Embedding embedding = embed::embedPoints(
            refiner.level(level).complex, positionsAt(rest, refiner, level), points);
        EXPECT_EQ(embedding.count(embed::PointStatus::Inside), Index(points.size()));
        binding =
            embed::makeBinding(refiner, level, stencils::Rules::Siggraph96, embedding, points);
    }

    std::vector<Point3> posed(const std::vector<Point3>& pose) const {
        return osd::evaluateBinding(binding, pose);
    }

    void expectBackAtRest() const {
        const std::vector<Point3> back = posed(rest.positions);
        for (std::size_t i = 0; i < model.size(); ++i)
            // What the project promises of a model of size 1.
            EXPECT_LT((vec(back[i]) - vec(model[i])).norm(), 1e-12);
    }
};

}  // namespace espalier::test
