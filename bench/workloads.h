// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/factored_table.h>
#include <espalier/stencils/stencil_table.h>

#include <optional>
#include <span>
#include <vector>

namespace espalier::bench {

/// A table in one precision, and its factors if it has some.
template <class Real>
struct Tables {
    stencils::StencilTable<Real> table;
    std::optional<stencils::FactoredTable<Real>> factors;
};

/// A table to apply, in both precisions.
struct Workload {
    Tables<float> inFloat;
    Tables<double> inDouble;
};

/// A mesh as the vertex loops of its faces.
struct Mesh {
    Index vertexCount = 0;
    std::vector<std::vector<Index>> loops;
};

/// A torus of side × side quadrilaterals.
Mesh torus(Index side);

/// Returns S_3 of a torus of quadrilaterals, with about `rowCount` rows of 13 entries each.
Workload surface(int rowCount);

constexpr int kMillion = 1'000'000;

/// Returns points of a torus that meanders through the unit cube: about `pointCount`, in the order
/// of a mesh.
std::vector<Point3> model(int pointCount = kMillion);

/// Returns a million points all over the unit cube, in random order.
std::vector<Point3> randomPoints();

/// True if the rest positions reproduce the points, up to the rounding of both.
bool givesBack(std::span<const Point3> moved, std::span<const Point3> points);

/// Returns the table of the model of a million points in a box of 10 × 10 × 10 cells, bound by
/// B-splines, so that each row has 64 entries. A subdivided lattice has such rows between the
/// planes of its base vertices.
Workload regularModel();

/// Returns the table of such a model with about `pointCount` points.
template <class Real>
stencils::StencilTable<Real> regularTable(int pointCount);

/// Returns the box of the regular model.
Lattice regularLattice();

/// Level 3 of the regular lattice: 512,000 cells.
class RefinedBox {
public:
    RefinedBox();
    const far::CellComplex& complex() const { return refiner_.level(kLevel).complex; }
    const std::vector<Point3>& positions() const { return positions_; }

    static constexpr int kLevel = 3;

private:
    far::TopologyRefiner refiner_;
    std::vector<Point3> positions_;
};

/// Returns a cylinder with an irregular axis and irregular ends.
Lattice irregularLattice();

/// Returns the table of the same model, bound to this cylinder on level 3. Has factors.
Workload irregularModel();

/// Returns `components` random values for each column of a table.
template <class Real>
std::vector<Real> randomValues(const stencils::StencilTable<Real>& table, int components);

}  // namespace espalier::bench
