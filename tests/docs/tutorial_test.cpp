// SPDX-License-Identifier: Apache-2.0
//
// The C++ of docs/tutorial.md. The page shows
// parts of this file; docs_pages checks that.

#include <espalier/base/error.h>
#include <espalier/bind/bind.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/lattice_file.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/deformer.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/level_lattice.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "support/temporary_folder.h"

namespace {

using namespace espalier;

/// Returns a coil inside the box, and a point far away.
std::vector<Point3> somePoints() {
    std::vector<Point3> points;
    for (int i = 0; i <= 300; ++i) {
        const double turn = 0.1 * i;
        points.push_back({0.8 * std::cos(turn),
                          0.8 * std::sin(turn),
                          0.2 + 0.012 * i});
    }
    points.push_back({9, 0, 0});
    return points;
}

TEST(Tutorial, ALatticeOfYourOwn) {
    far::ComplexBuilder builder(3, 10);
    builder.addCell(far::StandardCell::Hexahedron,
                    {0, 1, 2, 3, 4, 5, 6, 7});
    builder.addCell(far::StandardCell::Wedge,
                    {4, 5, 8, 7, 6, 9});
    const far::CellComplex house = builder.build();

    EXPECT_EQ(house.count(3), 2);
    EXPECT_EQ(house.count(2), 6 + 5 - 1);
    EXPECT_EQ(house.eulerCharacteristic(), 1);

    // A cell without a roof.
    far::ComplexBuilder open(3, 4);
    EXPECT_THROW(open.addCell({{{0, 1, 9}}}),
                 far::TopologyError);
}

TEST(Tutorial, FromALatticeToAPose) {
    const Lattice rest = shapes::box({.cells = {2, 2, 4},
                                      .min = {-1, -1, 0},
                                      .max = {1, 1, 4}});
    EXPECT_EQ(rest.positions.size(), 3U * 3 * 5);

    far::TopologyRefiner refiner(rest.complex,
                                 {.marks = rest.marks});
    refiner.refineUniform(2);
    const auto& [complex, strata, holes] = refiner.level(2);
    const Index cells = complex.count(3);
    const Index corners = strata.count(0, 0);
    EXPECT_EQ(cells, 16 * 8 * 8);
    EXPECT_EQ(corners, 8);

    const auto table = stencils::buildStencils(refiner, 2);
    const Index rows = table.rowCount();
    const auto weights = table.weights(rows - 1);
    EXPECT_EQ(rows, complex.count(0));
    EXPECT_EQ(table.columnCount(), 45);
    // Rounding of about ten weights.
    EXPECT_NEAR(
        std::accumulate(weights.begin(), weights.end(), 0.), 1,
        1e-15);

    const test::TemporaryFolder folder;
    const std::filesystem::path file =
        folder.path() / "level-2.vtu";
    const auto positions =
        stencils::refinePositions(refiner, 2, rest.positions);
    io::writeLattice(file, levelLattice(refiner, 2, positions));
    EXPECT_EQ(io::readLattice(file).positions, positions);

    const std::vector<Point3> points = somePoints();

    const far::TopologyRefiner base(rest.complex,
                                    {.marks = rest.marks});
    const auto binding = bind::bindPoints(
        {base, rest.positions}, points, bind::Level{3});
    const auto& deformation = binding.table;  // D
    const auto outside =
        binding.count(embed::PointStatus::Outside);
    EXPECT_EQ(deformation.rowCount(), 302);
    EXPECT_EQ(deformation.columnCount(), 45);
    EXPECT_EQ(outside, 1);
    EXPECT_THAT(deformation.emptyRows(),
                testing::ElementsAre(301));

    std::vector<Point3> pose = rest.positions;
    for (Point3& vertex : pose)
        vertex[0] += 0.1 * vertex[2] * vertex[2];
    const std::vector<Point3> moved =
        osd::evaluateBinding(binding, pose);
    EXPECT_GT(moved[300][0], points[300][0] + 1);
    EXPECT_EQ(moved[301], points[301]);

    // In an animation, this happens for each pose.
    const osd::Deformer<double> deformer(binding);
    const std::span<const double> from(pose[0].data(),
                                       3 * pose.size());
    std::vector<double> to(3 * points.size());
    deformer.deform(from, to);
    for (std::size_t i = 0; i < 302; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            // Sums of up to 64 products of size 4, in a
            // different order.
            EXPECT_NEAR(to[3 * i + c], moved[i][c], 1e-14);
        }

    // Gradients of Σ z² of the points.
    std::vector<double> byPoints(to.size());
    for (std::size_t i = 2; i < to.size(); i += 3)
        byPoints[i] = 2 * to[i];
    const osd::CompiledAdjoint<double> adjoint(deformation);
    std::vector<double> byVertices(from.size());
    const auto xyz = osd::BufferDescriptor::packed(3);
    adjoint.evaluate(byPoints, xyz, byVertices, xyz,
                     {0, adjoint.rowCount()});
    // ⟨g, D p⟩ = ⟨Dᵀ g, p⟩: sums of about a hundred terms of
    // size 10.
    // Point 301 is outside, so D p is 0 for it.
    EXPECT_NEAR(std::inner_product(to.begin(), to.end() - 3,
                                   byPoints.begin(), 0.),
                std::inner_product(from.begin(), from.end(),
                                   byVertices.begin(), 0.),
                1e-9);

    // Two points are pulled; the floor stays.
    const std::vector<Index> pulled = {150, 300};
    const std::vector<Point3> pulls = {{0.2, 0, 0},
                                       {0, 0, 0.3}};
    solve::FitOptions options;
    options.smoothing = solve::Smoothing::Laplacian;
    options.frozen = {0, 1, 2, 3, 4, 5, 6, 7, 8};
    const auto fit = solve::fitLattice(
        stencils::selectRows(deformation, pulled), pulls,
        rest.complex, options);
    std::vector<Point3> fitted = rest.positions;
    for (std::size_t v = 0; v < fitted.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c)
            fitted[v][c] += fit.displacements[v][c];
    EXPECT_LT(fit.largestMiss, 0.01);
    EXPECT_EQ(fitted[8], rest.positions[8]);

    const solve::ValidityCheck check(complex, positions);
    const auto posed =
        stencils::refinePositions(refiner, 2, fitted);
    const solve::PoseValidity validity = check.check(posed);
    const bool folds = !validity.inverted.empty();
    const solve::LargestStep step =
        check.largestStep(posed, 100);
    EXPECT_FALSE(folds);
    EXPECT_GT(validity.smallest->value, 0.1);
    EXPECT_GT(step.length, 1);
    EXPECT_LT(step.length, 100);
}

}  // namespace
