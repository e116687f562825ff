// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/limit/limit_binding.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "support/delaunay.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

// A point never moves much farther than the vertices of the lattice, however bad the lattice is.

namespace espalier::embed {
namespace {

using test::NamedLattice;

/// Binds points under a policy.
using Bind = std::function<BoundRows<>(std::span<const Point3>, OutsidePolicy)>;

double rowSum(const stencils::StencilTable<double>& table, Index row) {
    double sum = 0;
    for (const double weight : table.weights(row)) sum += std::abs(weight);
    return sum;
}

/// Returns points in the bounding box of a lattice, enlarged by its size on all sides; half of them
/// are in the box itself.
std::vector<Point3> pointsAround(const Lattice& lattice, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    Eigen::AlignedBox3d box;
    for (const Point3& position : lattice.positions) box.extend(test::vec(position));
    std::vector<Point3> points;
    for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Vector3d at(uniform(random), uniform(random), uniform(random));
        const Eigen::Vector3d wide = i % 2 == 0 ? at : Eigen::Vector3d(3 * at.array() - 1);
        points.push_back(test::toPoint(box.min() + wide.cwiseProduct(box.sizes())));
    }
    return points;
}

/// Checks what the header promises of each row and each status, under every policy.
/// \return the number of points that are carried
Index expectBounded(const std::string& name, const Lattice& lattice, const Bind& bind,
                    std::size_t pointCount) {
    const auto points = pointsAround(lattice, pointCount, 7);
    const BoundRows<> kept = bind(points, OutsidePolicy::Keep);
    const BoundRows<> carried = bind(points, OutsidePolicy::Nearest);
    Index carriedCount = 0;
    for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
        EXPECT_EQ(kept.statuses[i], carried.statuses[i]) << name << " point " << i;
        EXPECT_LE(rowSum(kept.table, i), kMaxRowSum) << name << " point " << i;
        EXPECT_LE(rowSum(carried.table, i), kMaxRowSum) << name << " point " << i;
        const bool isInside = kept.statuses[i] == PointStatus::Inside;
        EXPECT_EQ(!kept.table.columns(i).empty(), isInside) << name << " point " << i;
        if (isInside)
            EXPECT_FALSE(carried.table.columns(i).empty()) << name << " point " << i;
        else
            carriedCount += !carried.table.columns(i).empty();
    }
    return carriedCount;
}

/// Does the same on levels and in the limit.
Index expectBoundedEverywhere(const NamedLattice& named, std::size_t pointCount) {
    const auto& [name, lattice] = named;
    const far::TopologyRefiner base(lattice.complex, {.marks = lattice.marks});
    Index carried = 0;
    for (const int level : {1, 3})
        carried += expectBounded(
            name + ", level " + std::to_string(level), lattice,
            [&](std::span<const Point3> points, OutsidePolicy outside) {
                return bindPoints({base, lattice.positions}, points,
                                  {.level = level, .embedding = {.outside = outside}});
            },
            pointCount);
    return carried + expectBounded(
                         name + ", limit", lattice,
                         [&](std::span<const Point3> points, OutsidePolicy outside) {
                             return limit::bindLimit({base, lattice.positions}, points,
                                                     {.embedding = {.outside = outside}});
                         },
                         pointCount);
}

// Delaunay lattices have slivers: tetrahedra as flat as can be. Refinement folds cells beside them,
// also where the tetrahedra are valid. Moved vertices fold the tetrahedra themselves.
void expectBoundedInDelaunayLattices(unsigned seedCount, std::size_t pointCount) {
    Index carried = 0;
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (unsigned seed = 1; seed <= seedCount; ++seed)
        for (const Index vertexCount : {6, 12, 36}) {
            Lattice lattice = test::delaunayLattice(vertexCount, seed);
            const std::string name =
                "seed " + std::to_string(seed) + ", " + std::to_string(vertexCount) + " vertices";
            carried += expectBoundedEverywhere({name, lattice}, pointCount);
            for (Point3& position : lattice.positions)
                for (double& coordinate : position) coordinate += 0.1 * normal(random);
            carried += expectBoundedEverywhere({name + ", folded", lattice}, pointCount);
        }
    EXPECT_GT(carried, 0);
}

TEST(BoundedRows, OfDelaunayLattices) {
    expectBoundedInDelaunayLattices(2, test::kIsSlow ? 4 : 16);
}

TEST(BoundedRowsOfManyPoints, OfDelaunayLattices) {
    expectBoundedInDelaunayLattices(20, 200);
}

TEST(BoundedRows, OfBoxesWithABasis) {
    const Lattice box = shapes::box({.cells = {4, 3, 5}});
    for (const Basis basis : {Basis::Bezier, Basis::BSpline}) {
        const TensorLattice lattice(box.complex, box.positions, basis);
        const Index carried = expectBounded(
            "box", box,
            [&](std::span<const Point3> points, OutsidePolicy outside) {
                return bindPoints(lattice, points, {.embedding = {.outside = outside}});
            },
            300);
        EXPECT_GT(carried, 50);
    }
}

}  // namespace
}  // namespace espalier::embed
