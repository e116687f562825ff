// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/binding.h>
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

/// What weighs the vertices of the lattice: subdivision, or what there was before it.
enum class Basis { Subdivision, Bezier, BSpline };

/// What the commands take that bind a model to a lattice.
struct BindOptions {
    CommonOptions common;
    std::string model;
    std::string rest;
    Basis basis = Basis::Subdivision;
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

/// What binding found.
struct BindingReport {
    Index inside, outside, notConverged;
    double largestResidual;
};

/// A model frozen to a lattice.
struct BoundPoints {
    embed::Binding binding;
    BindingReport report;
    std::vector<embed::PointStatus> statuses;  ///< one per point
    /// limit::LimitTable::gradients; 0 × 0 if they were not asked for, or bound to a level.
    std::array<stencils::StencilTable<double>, 3> gradients = {};
};

/// What else binding may make.
enum class Gradients { No, OfLimit };

/// Freezes points to a lattice that was read from options.rest. Errors in the lattice name it.
/// Stage: binding.
BoundPoints bindPoints(const BindOptions& options, std::span<const Point3> points,
                       const Lattice& lattice, Stages& stages, Gradients gradients = Gradients::No);

/// The matrix that bindPoints() finds, left in its factors; nothing for a basis without any: those
/// other than subdivision, and the limit. Stage: binding in factors.
std::optional<stencils::FactoredTable<double>> bindInFactors(const BindOptions& options,
                                                             std::span<const Point3> points,
                                                             const Lattice& lattice,
                                                             Stages& stages);

}  // namespace espalier::cli
