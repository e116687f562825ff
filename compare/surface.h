// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>

#include <vector>

namespace espalier::compare {

/// The surface of a complex: all of a mesh, or the boundary of a lattice.
struct Surface {
    std::vector<Index> vertices;  ///< those in one of the faces, ascending
    std::vector<Index> edges;     ///< likewise
    std::vector<Index> faces;     ///< ascending
};

/// \throws Error if the complex is a curve
Surface surfaceOf(const far::CellComplex& complex);

/// Whether the loop of a face on the boundary of a lattice runs clockwise, seen from outside. Never
/// on a mesh.
bool isWoundInward(const far::CellComplex& complex, Index face);

/// The vertices of a face of the surface in order: as a mesh winds it, or anticlockwise from
/// outside of a lattice.
std::vector<Index> surfaceLoop(const far::CellComplex& complex, Index face);

}  // namespace espalier::compare
