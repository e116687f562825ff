// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/point.h>
#include <espalier/far/strata.h>

#include <string>
#include <vector>

namespace espalier {

/// A quantity on the vertices of a lattice besides their position: texture coordinates, material
/// parameters. It is refined and applied by the same tables as positions.
///
/// \cite MacCracken & Joy 1996, section 8
struct VertexAttribute {
    std::string name;
    int components = 1;
    std::vector<double> values;  ///< `components` a vertex, vertex by vertex
};

/// A complex (mostly of dimension 3) placed in space.
struct Lattice {
    far::CellComplex complex;
    std::vector<Point3> positions;  ///< one a vertex
    far::Marks marks;
    std::vector<VertexAttribute> attributes;
};

}  // namespace espalier
