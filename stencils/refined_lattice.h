// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/face_varying.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>

namespace espalier::stencils {

/// Returns a level of a lattice, a mesh or a curve as a lattice of its own: levelLattice() with
/// refined positions, attributes and texture coordinates of `base`, and its integers carried by
/// levelIntegers().
///
/// \param refiner of base.complex
/// \param level must exist in `refiner`
/// \param linear for texture coordinates; the default is OpenSubdiv's default
/// \throws Error as levelLattice() and refineValues()
/// \cost as refineValues(), for the positions and for each attribute
ESPALIER_API Lattice refinedLattice(const far::TopologyRefiner& refiner, int level,
                                    const Lattice& base,
                                    far::FaceVaryingLinear linear = far::FaceVaryingLinear::All);

}  // namespace espalier::stencils
