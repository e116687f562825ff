// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/complex_builder.h>

#include <span>
#include <vector>

// Adds the cells of a complex to a ComplexBuilder; not installed.
namespace espalier::shapes {

using Loop = std::vector<Index>;

/// Adds all cells of a lattice, faces of a mesh or edges of a curve to a builder of the same
/// dimension; vertex v becomes newVertex[v].
void addAll(const far::CellComplex& complex, std::span<const Index> newVertex,
            far::ComplexBuilder& builder);

}  // namespace espalier::shapes
