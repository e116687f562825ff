// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/embedding.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

namespace espalier::test {

using stencils::StencilTable;

inline constexpr far::Rules kLatticeRules[] = {far::Rules::Siggraph96, far::Rules::Cse96,
                                               far::Rules::Mlca};

/// A refined lattice with the positions of its level.
struct Refined {
    far::TopologyRefiner refiner;
    int level;
    std::vector<Point3> base;
    std::vector<Point3> positions;

    Refined(const Lattice& lattice, int levels)
        : refiner(lattice.complex, {.marks = lattice.marks}),
          level(levels),
          base(lattice.positions) {
        refiner.refineUniform(levels);
        positions = pose(base);
    }
    const far::CellComplex& complex() const { return refiner.level(level).complex; }
    std::vector<Point3> pose(const std::vector<Point3>& points) const {
        return stencils::refinePositions(refiner, level, points);
    }
    embed::Embedding embed(const std::vector<Point3>& points,
                           const embed::EmbeddingOptions& options = {}) const {
        return embed::embedPoints(complex(), positions, points, options);
    }
    /// Returns D for embedded points.
    stencils::StencilTable<double> table(const embed::Embedding& embedding) const {
        return embed::buildDeformationTable(refiner, level, embedding);
    }
};

inline Eigen::Vector3d vec(const Point3& p) {
    return Eigen::Vector3d(p.data());
}

inline Point3 toPoint(const Eigen::Vector3d& v) {
    return {v[0], v[1], v[2]};
}

/// A smooth pose that is far from affine.
inline std::vector<Point3> bent(const Lattice& lattice) {
    std::vector<Point3> pose = lattice.positions;
    for (Point3& p : pose)
        p = {p[0] + 0.3 * std::sin(2 * p[1]), p[1] - 0.2 * p[0] * p[2],
             p[2] + 0.3 * std::cos(p[0] + p[1])};
    return pose;
}

/// Returns random convex combinations of the vertices of random cells. Most of them are in their
/// cell.
inline std::vector<Point3> pointsIn(const Refined& refined, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::exponential_distribution<double> weight;
    std::vector<Point3> points;
    for (std::size_t i = 0; i < count; ++i) {
        const Index cell = Index(random() % unsigned(refined.complex().count(3)));
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double total = 0;
        for (const Index vertex : refined.complex().relation(3, 0)[cell]) {
            const double w = weight(random);
            total += w;
            sum += w * vec(refined.positions[vertex]);
        }
        sum /= total;
        points.push_back(toPoint(sum));
    }
    return points;
}

}  // namespace espalier::test
