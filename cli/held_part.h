// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/continuity.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "bind_model.h"
#include "run.h"

namespace espalier::cli {

/// A part of a model, and of the boundary of its lattice, that is to stay as it is: what lies in a
/// box.
struct HoldOptions {
    std::optional<std::array<double, 6>> box;  ///< its least coordinates, then its largest
    embed::Continuity continuity = embed::Continuity::C0;
};

/// Adds --hold and --continuity to a command that binds with the basis of subdivision only.
void addHoldOptions(CLI::App& command, HoldOptions& hold, BindOptions& options);

/// What lies in the box.
struct HeldPart {
    std::vector<Index> points;  ///< of the model, ascending
    std::vector<Index> faces;   ///< of the lattice's boundary, ascending
};

/// Finds what is to be held. Nothing without --hold.
/// \param points of the model
/// \throws Error if the box is none, or neither a point nor a face of the boundary lies in it
HeldPart findHeldPart(const HoldOptions& hold, const BindOptions& options,
                      std::span<const Point3> points, const Lattice& lattice);

/// The vertices of the lattice that must stay, ascending. Stage: holding, if there is a part.
/// \param points of the model
/// \param rows of D, of the points of the part, as the options say to bind them
/// \throws Error if there is a part but none of it asks for a vertex
std::vector<Index> heldVertices(const HeldPart& part, const HoldOptions& hold,
                                const BindOptions& options, std::span<const Point3> points,
                                const stencils::StencilTable<double>& rows, const Lattice& lattice,
                                Stages& stages);

}  // namespace espalier::cli
