// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/bind/bind.h>
#include <espalier/io/model_part.h>
#include <espalier/osd/binding_evaluator.h>
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

/// The options of commands that bind a model to a lattice.
struct BindOptions {
    CommonOptions common;
    std::string model;
    std::string rest;
    std::optional<embed::Basis> basis;  ///< nothing for subdivision
    int level = 3;
    bool limit = false;                       ///< bind to the limit volume instead of a level
    io::ModelPart part;                       ///< the part of the model that follows
    std::vector<CLI::Option*> ofSubdivision;  ///< the options that need --basis subdivision
};

/// Adds MODEL and --rest to a command.
void addModelAndRest(CLI::App& command, BindOptions& options);

/// Adds --basis and --limit to a command that already has -n and the options of refinement.
void addBasisOptions(CLI::App& command, BindOptions& options);

/// Adds -n and the options of refinement, basis and embedding to a command.
void addBindingOptions(CLI::App& command, BindOptions& options);

/// Adds --weights, --only, --hold and --falloff to a command.
void addPartOptions(CLI::App& command, io::ModelPart& part, CommonOptions& options);

/// Refuses options that the chosen basis cannot use.
/// \throws CLI::ValidationError
void checkBasis(const BindOptions& options);

/// Binds points to a lattice that was read from options.rest, in the stage "binding". Errors in the
/// lattice name its file.
/// \param hasGradients whether the binding gets its gradients
bind::Binding bindPoints(const BindOptions& options, std::span<const Point3> points,
                         const Lattice& lattice, Stages& stages, bool hasGradients = false,
                         bind::PointWeights weights = {});

/// Does the same for the points of a model, with the weights of options.part.
bind::Binding bindModel(const BindOptions& options, const io::Model& model, const Lattice& lattice,
                        Stages& stages, bool hasGradients = false);

/// Deforms a model by a few poses, as bindModel() and osd::evaluateBinding() do, but makes no
/// matrix, in the stage "deforming".
osd::DeformedPoints deformModel(const BindOptions& options, const io::Model& model,
                                const Lattice& lattice, std::span<const std::vector<Point3>> poses,
                                Stages& stages, bool hasGradients);

/// Binds the points that options.part holds, and no others, as if it did not hold them, in the
/// stage "binding held points": the binding tells how far a pose would move them. Points outside
/// the lattice stay.
bind::Binding bindHeldPoints(const BindOptions& options, const io::Model& model,
                             const Lattice& lattice, Stages& stages);

/// Prints a warning to standard error if points stay in place because they are outside the lattice:
/// the parts of a model that move may come apart from them. Prints nothing if the command line has
/// --quiet, or an --outside that keeps points in place by choice.
/// Prints nothing either if the binding is from a file.
void warnOfPointsOutside(const bind::BindingStatistics& binding, const CommonOptions& options);

/// Binds like bindModel(), in the stage "binding in factors", but returns the matrix as a product
/// of two tables. Returns nothing for the limit and for a basis other than subdivision.
std::optional<stencils::FactoredTable<double>> bindInFactors(const BindOptions& options,
                                                             std::span<const Point3> points,
                                                             const Lattice& lattice,
                                                             Stages& stages);

}  // namespace espalier::cli
