// SPDX-License-Identifier: Apache-2.0
//
// A model in a lattice of elastic material sags under its own weight:
//
//     elastic_lattice MODEL REST HELD WEIGHT OUT [POSE]
//
// The material fills the lattice and has no weight. The vertices up to x = HELD are fixed. WEIGHT
// is the weight of the whole model, spread equally over its points, in units of Young's modulus
// times the unit of length squared; it pulls towards −z. Elasticity is linear, which is accurate
// for displacements that are small compared with the model.
//
// D moves the points with the lattice, so Dᵀ carries the forces on the points to the lattice: both
// do the same work.

#include <espalier/base/error.h>
#include <espalier/bind/bind.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/solve/design_variables.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/sparse_matrix.h>

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <array>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <span>
#include <string>
#include <vector>

using namespace espalier;

namespace {

constexpr int kLevel = 2;         // Its cells are the finite elements, and contain the points.
constexpr double kPoisson = 0.3;  // Poisson's ratio

using Sparse = Eigen::SparseMatrix<double>;

/// Returns the stiffness of a hexahedron with Young's modulus 1, over the displacements of its
/// corners: corner by corner, x, y, z. Uses Gauss's rule with 2 × 2 × 2 points.
Eigen::Matrix<double, 24, 24> cellStiffness(const embed::Trilinear::Corners& corners) {
    const double lambda = kPoisson / ((1 + kPoisson) * (1 - 2 * kPoisson));
    const double mu = 1 / (2 * (1 + kPoisson));
    Eigen::Matrix<double, 24, 24> result = Eigen::Matrix<double, 24, 24>::Zero();
    for (int point = 0; point < 8; ++point) {
        const Eigen::Vector3d sides(point & 1, point >> 1 & 1, point >> 2);
        const Eigen::Vector3d uvw = (sides.array() - 0.5) / std::sqrt(3.0) + 0.5;
        const Eigen::Matrix3d jacobian = embed::Trilinear(corners).jacobian(uvw);
        const auto byPlace = embed::Trilinear::weightDerivatives(uvw);
        Eigen::Matrix<double, 3, 8> gradients;  // Derivatives of the corners' weights.
        for (int axis = 0; axis < 3; ++axis)
            gradients.row(axis) = Eigen::Map<const Eigen::RowVectorXd>(byPlace[axis].data(), 8);
        gradients = jacobian.transpose().inverse() * gradients;
        const double volume = std::abs(jacobian.determinant()) / 8;
        for (Eigen::Index i = 0; i < 8; ++i)
            for (Eigen::Index j = 0; j < 8; ++j) {
                const Eigen::Vector3d a = gradients.col(i), b = gradients.col(j);
                result.block<3, 3>(3 * i, 3 * j) +=
                    volume * (lambda * a * b.transpose() + mu * b * a.transpose() +
                              mu * a.dot(b) * Eigen::Matrix3d::Identity());
            }
    }
    return result;
}

/// Returns the stiffness matrix of a refined lattice, over 3 coordinates of each vertex.
Sparse stiffness(const far::CellComplex& complex, std::span<const Point3> positions) {
    std::vector<Eigen::Triplet<double>> entries;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto vertices = far::hexahedronVertices(complex, CellId(cell));
        if (!vertices)
            throw Error("cell " + std::to_string(cell) + " of level " + std::to_string(kLevel) +
                        " is not a hexahedron, the only finite element of this example");
        embed::Trilinear::Corners corners;
        std::array<Index, 24> rows;
        for (std::size_t i = 0; i < 24; ++i) {
            const Index vertex = (*vertices)[i / 3];
            corners[i / 3] = Eigen::Vector3d(positions[vertex].data());
            rows[i] = 3 * vertex + static_cast<Index>(i % 3);
        }
        const auto matrix = cellStiffness(corners);
        for (std::size_t i = 0; i < 24; ++i)
            for (std::size_t j = 0; j < 24; ++j)
                entries.emplace_back(
                    rows[i], rows[j],
                    matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
    }
    const Eigen::Index size = 3 * static_cast<Eigen::Index>(complex.count(0));
    Sparse result(size, size);
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
}

/// Returns B, 3 · vertices × variables: all coordinates may move, except the coordinates of
/// vertices up to x = `held`.
stencils::StencilTable<double> movements(std::span<const Point3> positions, double held) {
    solve::DesignVariables variables(static_cast<Index>(positions.size()));
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (positions[v][0] <= held) variables.freeze(static_cast<Index>(v));
    return variables.matrix();
}

Sparse toEigen(const stencils::StencilTable<double>& table) {
    return stencils::SparseView<double>(table).matrix();
}

/// Returns the displacements under a load.
/// \throws Error if something can move without resistance
Eigen::VectorXd solve(const Sparse& stiffness, const Eigen::VectorXd& load) {
    if (load.size() == 0) return load;  // Everything is fixed.
    const Eigen::SimplicialLDLT<Sparse> factors(stiffness);
    // Movements without resistance, for example a hinge, leave pivots that are only rounding: below
    // 2e-12 of the largest for lattices of up to 1,000 cells. If the lattice is held, pivots are
    // much larger: the softest lattice tested, a bar of 1,000 × 1 × 1 cells, has none below 4e-4.
    const Eigen::VectorXd pivots = factors.vectorD().cwiseAbs();
    if (factors.info() != Eigen::Success || !(pivots.minCoeff() > 1e-10 * pivots.maxCoeff()))
        throw Error("the vertices that are held do not hold the lattice");
    return factors.solve(load);
}

double numberOf(const char* text) {
    char* end = nullptr;
    const double number = std::strtod(text, &end);
    if (end == text || *end != 0 || !std::isfinite(number))
        throw Error(std::string("'") + text + "' is not a finite number");
    return number;
}

void run(int count, char** arguments) {
    if (count < 6 || count > 7)
        throw Error("usage: elastic_lattice MODEL REST HELD WEIGHT OUT [POSE]");
    const auto model = io::readModel(arguments[1]);
    const double held = numberOf(arguments[3]), weight = numberOf(arguments[4]);
    Lattice lattice = io::readLattice(arguments[2]);
    far::TopologyRefiner refiner(lattice.complex, {.marks = lattice.marks});
    const auto binding =
        bind::bindPoints({refiner, lattice.positions}, model->positions(), bind::Level{kLevel},
                         {.embedding = {.outside = embed::OutsidePolicy::Error}});
    const stencils::StencilTable<double>& deformation = binding.table;
    refiner.refineUniform(kLevel);
    const auto levelTable = stencils::buildStencils(refiner, kLevel);

    // The variables move the level by (S ⊗ I₃) B, and the points by (D ⊗ I₃) B.
    const auto movable = movements(lattice.positions, held);
    const Sparse toLevel = toEigen(solve::buildJacobian(levelTable, movable));
    const Sparse toPoints = toEigen(solve::buildJacobian(deformation, movable));

    Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, deformation.rowCount());
    forces.row(2).setConstant(-weight / deformation.rowCount());
    const Sparse matrix = toLevel.transpose() *
                          stiffness(refiner.level(kLevel).complex,
                                    stencils::applyLevelTable(levelTable, lattice.positions)) *
                          toLevel;
    const Eigen::VectorXd load = toPoints.transpose() * forces.reshaped();
    const Eigen::VectorXd solution = solve(matrix, load);

    const Eigen::VectorXd displacements = toEigen(movable) * solution;
    Eigen::Map<Eigen::VectorXd>(lattice.positions.front().data(), displacements.size()) +=
        displacements;
    model->write(arguments[5], osd::evaluateBinding(binding, lattice.positions));
    if (count > 6) io::writeLattice(arguments[6], lattice);

    std::cout << "largest displacement: "
              << (toPoints * solution).reshaped(3, forces.cols()).colwise().norm().maxCoeff()
              << '\n';
}

}  // namespace

int main(int count, char** arguments) {
    try {
        run(count, arguments);
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
}
