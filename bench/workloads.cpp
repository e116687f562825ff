// SPDX-License-Identifier: Apache-2.0
#include "workloads.h"

#include <espalier/embed/tensor_product.h>
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace espalier::bench {

namespace {

Workload workload(stencils::StencilTable<double> table) {
    auto inFloat = stencils::convertTable<float>(table);
    return {{std::move(inFloat), {}}, {std::move(table), {}}};
}

}  // namespace

std::vector<Point3> model(int pointCount) {
    const auto side = static_cast<int>(std::lround(std::sqrt(pointCount)));
    std::vector<Point3> points;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const double u = 2 * std::numbers::pi * i / side;
            const double v = 2 * std::numbers::pi * j / side;
            const double tube = 0.09 * (1 + 0.3 * std::sin(7 * u + 3 * v));
            const double around = 0.24 + tube * std::cos(v);
            points.push_back({0.5 + around * std::cos(u), 0.5 + around * std::sin(u),
                              0.5 + 0.1 * std::sin(3 * u) + tube * std::sin(v)});
        }
    return points;
}

std::vector<Point3> randomPoints() {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.001, 0.999);
    std::vector<Point3> points(kMillion);
    for (Point3& point : points) point = {uniform(random), uniform(random), uniform(random)};
    return points;
}

bool givesBack(std::span<const Point3> moved, std::span<const Point3> points) {
    if (moved.size() != points.size()) return false;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            if (!(std::abs(moved[i][c] - points[i][c]) <= 1e-12)) return false;
    return true;
}

Mesh torus(Index side) {
    Mesh mesh{side * side, {}};
    for (Index j = 0; j < side; ++j)
        for (Index i = 0; i < side; ++i) {
            const Index right = (i + 1) % side, above = (j + 1) % side;
            mesh.loops.push_back(
                {j * side + i, j * side + right, above * side + right, above * side + i});
        }
    return mesh;
}

Workload surface(int rowCount) {
    constexpr int kLevel = 3;
    const Mesh mesh =
        torus(static_cast<Index>(std::lround(std::sqrt(rowCount / std::pow(4, kLevel)))));
    far::TopologyRefiner refiner(far::buildMesh(mesh.vertexCount, mesh.loops));
    refiner.refineUniform(kLevel);
    return workload(stencils::buildStencils(refiner, kLevel));
}

Lattice regularLattice() {
    return shapes::box({.cells = {10, 10, 10}});
}

RefinedBox::RefinedBox() : refiner_(regularLattice().complex) {
    refiner_.refineUniform(kLevel);
    positions_ = stencils::refinePositions(refiner_, kLevel, regularLattice().positions);
}

template <class Real>
stencils::StencilTable<Real> regularTable(int pointCount) {
    const Lattice box = regularLattice();
    const embed::TensorLattice lattice(box.complex, box.positions, embed::Basis::BSpline);
    return stencils::convertTable<Real>(
        embed::buildDeformationTable(lattice, embed::embedPoints(lattice, model(pointCount))));
}

template stencils::StencilTable<float> regularTable(int);
template stencils::StencilTable<double> regularTable(int);

Workload regularModel() {
    return workload(regularTable<double>(kMillion));
}

Lattice irregularLattice() {
    return shapes::cylinder({.sectors = 8,
                             .pattern = {.rings = 3},
                             .layers = 6,
                             .radius = 0.6,
                             .from = {0.5, 0.5, 0},
                             .to = {0.5, 0.5, 1}});
}

Workload irregularModel() {
    constexpr int kLevel = 3;
    const Lattice cylinder = irregularLattice();
    far::TopologyRefiner refiner(cylinder.complex);
    refiner.refineUniform(kLevel);
    const auto rest = stencils::refinePositions(refiner, kLevel, cylinder.positions);
    const auto embedding = embed::embedPoints(refiner.level(kLevel).complex, rest, model());
    Workload made = workload(embed::buildDeformationTable(refiner, kLevel, embedding));
    made.inDouble.factors = embed::buildFactoredTable(refiner, kLevel, embedding);
    made.inFloat.factors = stencils::convertTable<float>(*made.inDouble.factors);
    return made;
}

template <class Real>
std::vector<Real> randomValues(const stencils::StencilTable<Real>& table, int components) {
    std::mt19937 random(1);
    std::uniform_real_distribution<Real> uniform(-1, 1);
    std::vector<Real> values(static_cast<std::size_t>(table.columnCount()) *
                             static_cast<std::size_t>(components));
    for (Real& value : values) value = uniform(random);
    return values;
}

template std::vector<float> randomValues(const stencils::StencilTable<float>&, int);
template std::vector<double> randomValues(const stencils::StencilTable<double>&, int);

}  // namespace espalier::bench
