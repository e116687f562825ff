// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/shapes/attach.h>

#include <span>

// Adds vertices to a lattice; not installed.
namespace espalier::shapes {

/// Returns the lattice with new vertices after the old ones, with the attributes and integers that
/// NewVertex describes. No cell uses the new vertices yet.
/// \param newVertices their sources exist
ESPALIER_API Lattice withNewVertices(const Lattice& lattice,
                                     std::span<const NewVertex> newVertices);

}  // namespace espalier::shapes
