// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/factored_table.h>
#include <espalier/stencils/stencil_table.h>

#include <optional>
#include <span>
#include <vector>

namespace espalier::bench {

/// A table to apply, in one precision; and its factors, where it has some.
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

/// A mesh as its faces' loops of vertices.
struct Mesh {
    Index vertexCount = 0;
    std::vector<std::vector<Index>> loops;
};

/// A torus of side × side quadrilaterals.
Mesh torus(Index side);

/// S_3 of a torus of quadrilaterals, of about so many rows; 13 entries each.
Workload surface(int rowCount);

constexpr int kMillion = 1'000'000;

/// A torus that meanders through the unit cube, of about so many points in the order of a mesh.
std::vector<Point3> model(int pointCount = kMillion);

/// A million points all over the unit cube, in no order.
std::vector<Point3> randomPoints();

/// Whether the rest positions gave the points back, to the rounding of both.
bool givesBack(std::span<const Point3> moved, std::span<const Point3> points);

/// The model of a million points bound to a box of 10 × 10 × 10 cells by B-splines, so that each
/// row has 64 entries; as a subdivided lattice has between the planes of its base vertices.
Workload regularModel();

/// The table of such a model of about so many points.
template <class Real>
stencils::StencilTable<Real> regularTable(int pointCount);

/// The box.
Lattice regularLattice();

/// A cylinder, whose axis is irregular, as are its ends.
Lattice irregularLattice();

/// The same model bound to it at level 3. Has factors.
Workload irregularModel();

/// Values for the columns of a table, `components` each.
template <class Real>
std::vector<Real> randomValues(const stencils::StencilTable<Real>& table, int components);

}  // namespace espalier::bench
