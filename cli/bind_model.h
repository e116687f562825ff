// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/local_binding.h>
#include <espalier/io/binding_file.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/factored_table.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "options.h"
#include "run.h"

namespace espalier::cli {

/// What the commands take that bind a model to a lattice.
struct BindOptions {
    CommonOptions common;
    std::string model;
    std::string rest;
    std::optional<embed::Basis> basis;  ///< none: subdivision
    int level = 3;
    bool limit = false;                       ///< to the limit volume instead of a level
    std::vector<CLI::Option*> ofSubdivision;  ///< the options that no other basis has a use for
};

/// Adds MODEL and --rest to a command.
void addModelAndRest(CLI::App& command, BindOptions& options);

/// Adds --basis and --limit to a command that has -n and the options of refinement.
void addBasisOptions(CLI::App& command, BindOptions& options);

/// Adds -n, and the options of refinement, of the basis and of the embedding.
void addBindingOptions(CLI::App& command, BindOptions& options);

/// Refuses options that the basis has no use for, rather than pass over them.
/// \throws CLI::ValidationError
void checkBasis(const BindOptions& options);

/// Points that are bound to a lattice.
struct ModelBinding {
    embed::BindingResult points;
    std::optional<io::BoundGradients> gradients = {};  ///< if they were asked for
};

/// Binds points to a lattice that was read from options.rest. Errors in the lattice name it.
/// Stage: binding.
/// \param hasGradients whether to make the gradients of a binding to the limit
ModelBinding bindModel(const BindOptions& options, std::span<const Point3> points,
                       const Lattice& lattice, Stages& stages, bool hasGradients = false);

/// The matrix that bindModel() finds, left in its factors; nothing for the limit and for the
/// bases other than subdivision. Stage: binding in factors.
std::optional<stencils::FactoredTable<double>> bindInFactors(const BindOptions& options,
                                                             std::span<const Point3> points,
                                                             const Lattice& lattice,
                                                             Stages& stages);

}  // namespace espalier::cli
