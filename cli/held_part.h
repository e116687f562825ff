// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/continuity.h>

#include <array>
#include <optional>

#include "bind_model.h"

namespace espalier::cli {

/// A part of a model, and of the boundary of its lattice, that is to stay as it is: what lies in a
/// box.
struct HoldOptions {
    std::optional<std::array<double, 6>> box;  ///< its least coordinates, then its largest
    stencils::Continuity continuity = stencils::Continuity::C0;
};

/// Adds --hold and --continuity to a command that binds with the basis of subdivision only.
void addHoldOptions(CLI::App& command, HoldOptions& hold, BindOptions& options);

/// The vertices of the lattice that must stay, ascending. None without --hold.
/// \param points of the model
/// \throws Error if the box is none, or neither a point nor a face of the boundary lies in it
std::vector<far::Index> heldVertices(const HoldOptions& hold, const BindOptions& options,
                                     std::span<const Point3> points, const Lattice& lattice);

}  // namespace espalier::cli
