// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/local_binding.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Core>

#include "support/complexes.h"
#include "support/test.h"

// Refined shapes with their positions, and models frozen to them.
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
    return stencils::refinePositions(refiner, level, lattice.positions);
}

/// A model frozen to a lattice (MacCracken & Joy 1996, section 5), completely inside.
struct Frozen {
    Lattice rest;
    std::vector<Point3> model;
    embed::BoundRows<> binding;

    Frozen(const Lattice& lattice, int level, const std::vector<Point3>& points)
        : rest(lattice), model(points) {
        binding = embed::bindPoints({refined(rest, 0), rest.positions}, points, {.level = level});
        EXPECT_EQ(binding.count(embed::PointStatus::Inside), static_cast<Index>(points.size()));
    }

    std::vector<Point3> posed(const std::vector<Point3>& pose) const {
        return stencils::applyLevelTable(binding.table, pose);
    }

    void expectBackAtRest() const {
        const std::vector<Point3> back = posed(rest.positions);
        for (std::size_t i = 0; i < model.size(); ++i)
            // The bound that the project promises, for a model of size 1.
            EXPECT_LT((vec(back[i]) - vec(model[i])).norm(), 1e-12);
    }
};

}  // namespace espalier::test
