// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/face_varying.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>

#include <optional>

namespace espalier::stencils {

/// Returns a level of a lattice, a mesh or a curve as a lattice of its own: levelLattice() with
/// refined positions, attributes and texture coordinates of `base`, and its integers carried by
/// levelIntegers().
///
/// If there are texture coordinates, the tags of the result have the mode that refined them, so
/// that further refinement uses the same mode.
///
/// \param refiner of base.complex
/// \param level must exist in `refiner`
/// \param linear mode for texture coordinates; the default is the tag of `base`, and without a tag
///        FaceVaryingLinear::All, OpenSubdiv's default
/// \throws Error as levelLattice(), refineValues() and far::refineFaceVarying(); if a corner names
///         a texture coordinate that does not exist
/// \cost as refineValues(), for the positions and for each attribute
ESPALIER_API Lattice refinedLattice(const far::TopologyRefiner& refiner, int level,
                                    const Lattice& base,
                                    std::optional<far::FaceVaryingLinear> linear = {});

}  // namespace espalier::stencils
