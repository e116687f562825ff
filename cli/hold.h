// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/embed/continuity.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "bind_model.h"
#include "run_report.h"

// --hold and --continuity of `espalier fit`: a part of the model and of the lattice that stays.

namespace espalier::cli {

/// The box of --hold: points of the model and boundary faces of the lattice in it must not move.
struct HoldOptions {
    std::optional<std::array<double, 6>> box;  ///< lowest coordinates, then highest
    embed::Continuity continuity = embed::Continuity::C0;
};

/// The points and faces that lie in the box of --hold.
struct HeldPart {
    std::vector<Index> points;  ///< points of the model, ascending
    std::vector<Index> faces;   ///< boundary faces of the lattice, ascending
};

/// Adds --hold and --continuity, which need --basis subdivision.
void addHoldOptions(CLI::App& command, HoldOptions& hold, BindOptions& options);

/// Finds the points and faces in the box of --hold; nothing without --hold.
/// \param points of the model
/// \throws Error if the corners of the box are exchanged, or the box contains no point and no face
HeldPart findHeldPart(const HoldOptions& hold, const BindOptions& options,
                      std::span<const Point3> points, const Lattice& lattice);

/// Returns the lattice vertices that must not move, ascending. Runs in the stage "holding" if
/// anything is held.
/// \param points of the model
/// \param rows the rows of D of the held points
/// \throws Error if all held points are outside the lattice and no face is held
std::vector<Index> heldVertices(const HeldPart& part, const HoldOptions& hold,
                                const BindOptions& options, std::span<const Point3> points,
                                const stencils::StencilTable<double>& rows, const Lattice& lattice,
                                Stages& stages);

}  // namespace espalier::cli
