// SPDX-License-Identifier: Apache-2.0
#include "bind_model.h"

#include <espalier/base/printable.h>
#include <espalier/embed/local_binding.h>
#include <espalier/io/files/file.h>
#include <espalier/solve/validity.h>
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "files.h"
#include "standard_streams.h"

namespace espalier::cli {
namespace {

/// Returns what the options bind to.
bind::Target targetOf(const BindOptions& options) {
    if (options.basis) return *options.basis;
    if (options.limit) return bind::Limit{options.common.embedding.tolerance};
    return bind::Level{options.level};
}

/// Warns on standard error if cells of the lattice are folded at rest. Returns without a check for
/// a basis other than subdivision, whose lattices are boxes without folds.
void warnOfFoldsAtRest(const BindOptions& options, const Lattice& lattice) {
    if (options.common.quiet || options.basis) return;
    // The check takes 8 µs a cell, and so at most half a second.
    constexpr Index kMaxCells = 100'000;
    const Index cellCount = lattice.complex.count(3);
    const std::string path = printable(options.rest);
    if (cellCount > kMaxCells) {
        printError(fmt::format("note: the {} cells of '{}' were not checked for folds at rest; "
                               "espalier info does so",
                               cellCount, path)
                       .c_str());
        return;
    }
    const auto base = refineLattice(options.rest, lattice, options.common, 0);
    const std::vector<Index> cells = solve::cellsBadAtRest(base, lattice.positions);
    if (cells.empty()) return;
    printError(fmt::format("warning: {} of {} cells of '{}' {} flat, folded or inside out at rest "
                           "(first: cell {}). A point there may be in several cells or in none, "
                           "and neighbouring points may move apart",
                           cells.size(), cellCount, path, cells.size() == 1 ? "is" : "are",
                           cells.front())
                   .c_str());
}

/// Returns a callback that shows the progress of binding `pointCount` points.
std::function<void(Offset)> progressOf(Stages& stages, std::size_t pointCount) {
    return [&stages, pointCount](Offset done) { stages.showProgress(done, pointCount); };
}

/// Returns the weights that the options ask for, in the stage "weighting"; none if they ask for the
/// whole model.
bind::PointWeights weightsOf(const BindOptions& options, const io::Model& model, Stages& stages,
                             bool hasGradients) {
    bind::PointWeights weights;
    if (!options.part.isWhole())
        weights = stages.run("weighting", [&] {
            return io::weightsOf(options.model, model, options.part, hasGradients);
        });
    if (hasGradients && !options.common.quiet)
        if (const std::string note = io::noteOnSlopes(options.model, model, weights); !note.empty())
            printError(("note: " + note).c_str());
    return weights;
}

/// Calls f(lattice, options of the library) in a stage. Errors in the lattice name its file.
template <class F>
auto runBinding(const BindOptions& options, std::size_t pointCount, const Lattice& lattice,
                Stages& stages, bool hasGradients, bind::PointWeights weights, const char* stage,
                F f) {
    warnOfFoldsAtRest(options, lattice);
    return stages.run(stage, [&] {
        const auto base = refineLattice(options.rest, lattice, options.common, 0);
        const bind::BindOptions chosen = {.embedding = options.common.embedding,
                                          .gradients = hasGradients,
                                          .weights = std::move(weights),
                                          .falloff = options.common.falloff,
                                          .progress = progressOf(stages, pointCount)};
        const auto run = [&] { return f(embed::RestLattice{base, lattice.positions}, chosen); };
        // A basis has demands on the lattice: the errors name its file.
        return options.basis ? ofFile(options.rest, run) : run();
    });
}

}  // namespace

void addModelAndRest(CLI::App& command, BindOptions& options) {
    command.add_option("MODEL", options.model, "The model: " + filesToRead(io::FileContent::Model))
        ->required();
    command
        .add_option(
            "--rest", options.rest,
            "The lattice at rest, around the model: " + filesToRead(io::FileContent::Lattice))
        ->required();
}

void addBasisOptions(CLI::App& command, BindOptions& options) {
    addChoice<std::optional<embed::Basis>>(
        command, "--basis", options.basis, embed::kBasisWords,
        "What moves the points. subdivision: the refined lattice; bezier, bspline: the Bézier "
        "volume "
        "or the uniform cubic B-splines of a box lattice, which at rest must be a parallelepiped "
        "divided evenly");
    command
        .add_flag(
            "--limit", options.limit,
            "Bind to the limit of refinement instead of a level. --tolerance also sets how close "
            "to the limit points are placed")
        ->excludes(command.get_option("-n"));
    for (const char* name :
         {"-n", "--limit", "--boundary", "--creasing", "--triangles", "--sharp-edges", "--rules"})
        options.ofSubdivision.push_back(command.get_option(name));
}

void addBindingOptions(CLI::App& command, BindOptions& options) {
    addLevelOption(command, options.level, 1);
    addRefinementOptions(command, options.common);
    addBasisOptions(command, options);
    for (CLI::Option* option : options.ofSubdivision)
        option->group("Only with --basis subdivision");
    addEmbeddingOptions(command, options.common);
}

void checkBasis(const BindOptions& options) {
    if (!options.basis) return;
    for (const CLI::Option* option : options.ofSubdivision)
        if (option->count() > 0)
            throw CLI::ValidationError(option->get_name(), "works with --basis subdivision only");
}

void addPartOptions(CLI::App& command, io::ModelPart& part, CommonOptions& options) {
    command
        .add_option("--weights", part.weights,
                    "Multiply the displacement of each point by a number of 0 to 1 that MODEL has "
                    "for it: a property of a PLY, an array of VTK's point data (NAME, or NAME:0 "
                    "for the first of several numbers), an attribute of glTF, or the red, green "
                    "or blue of an OBJ. espalier info lists them")
        ->type_name("NAME");
    command
        .add_option(
            "--only", part.groups,
            "Move only the points of these parts of MODEL: groups, objects and materials "
            "of an OBJ; meshes, nodes and materials of glTF; the patches, markers or groups "
            "of a mesh. espalier info lists them")
        ->allow_extra_args(false)
        ->type_name("GROUP");
    command
        .add_option("--hold", part.holds,
                    "Keep the points of these parts of MODEL still: the patches, markers or groups "
                    "of a mesh, or parts as for --only. espalier info lists them")
        ->allow_extra_args(false)
        ->type_name("NAME");
    command
        .add_option(
            "--falloff", options.falloff,
            "Let points outside the lattice follow it with a weight that falls smoothly from 1 at "
            "the lattice to 0 at the distance R, in the units of the model")
        ->check(aboveZero())
        ->type_name("R")
        ->excludes(command.get_option("--outside"));
}

bind::Binding bindPoints(const BindOptions& options, std::span<const Point3> points,
                         const Lattice& lattice, Stages& stages, bool hasGradients,
                         bind::PointWeights weights) {
    return runBinding(options, points.size(), lattice, stages, hasGradients, std::move(weights),
                      "binding",
                      [&](const embed::RestLattice& rest, const bind::BindOptions& chosen) {
                          auto binding = bind::bindPoints(rest, points, targetOf(options), chosen);
                          stages.addBytes(bytesOf(binding.table));
                          return binding;
                      });
}

bind::Binding bindModel(const BindOptions& options, const io::Model& model, const Lattice& lattice,
                        Stages& stages, bool hasGradients) {
    return bindPoints(options, model.positions(), lattice, stages, hasGradients,
                      weightsOf(options, model, stages, hasGradients));
}

osd::DeformedPoints deformModel(const BindOptions& options, const io::Model& model,
                                const Lattice& lattice, std::span<const std::vector<Point3>> poses,
                                Stages& stages, bool hasGradients) {
    const std::span<const Point3> points = model.positions();
    return runBinding(options, points.size(), lattice, stages, hasGradients,
                      weightsOf(options, model, stages, hasGradients), "deforming",
                      [&](const embed::RestLattice& rest, const bind::BindOptions& chosen) {
                          stages.addBytes(poses.size() * points.size_bytes());
                          return osd::deformPoints(rest, points, targetOf(options), chosen, poses);
                      });
}

void warnOfPointsOutside(const bind::BindingStatistics& binding, const CommonOptions& options) {
    using enum embed::PointStatus;
    const Offset outside = binding.emptyOutsideCount;
    if (options.quiet || outside == 0) return;
    if (options.falloff > 0 || options.embedding.outside == embed::OutsidePolicy::Nearest) {
        const bool isOne = outside == 1;
        printError(fmt::format("warning: {} of {} points outside the lattice {} too far away, or "
                               "beside a cell that is too flat, to move with the nearest cell: the "
                               "absolute values of {} weights would sum to more than {}. {} in "
                               "place",
                               outside, binding.count(Outside), isOne ? "is" : "are",
                               isOne ? "its" : "their", embed::kMaxRowSum,
                               isOne ? "It stays" : "They stay")
                       .c_str());
        return;
    }
    if (options.outside->count() > 0) return;
    const Offset all = binding.rowCount;
    printError(
        fmt::format("warning: {} of {} points {} outside the lattice and {} in place{}. Use "
                    "--outside nearest to move them with the nearest cell, --outside keep if they "
                    "should stay, or make a lattice around the whole model: espalier shape around",
                    outside, all, outside == 1 ? "is" : "are", outside == 1 ? "stays" : "stay",
                    outside < all ? ", so a pose may tear the model" : "")
            .c_str());
}

bind::Binding bindHeldPoints(const BindOptions& options, const io::Model& model,
                             const Lattice& lattice, Stages& stages) {
    return stages.run("binding held points", [&] {
        io::ModelPart part = options.part;
        part.factors.assign(model.positions().size(), 0);
        for (const Index point : io::heldPointsOf(options.model, model, part))
            part.factors[point] = 1;
        part.holds.clear();
        embed::EmbeddingOptions embedding = options.common.embedding;
        if (embedding.outside == embed::OutsidePolicy::Error)
            embedding.outside = embed::OutsidePolicy::Keep;
        const auto base = refineLattice(options.rest, lattice, options.common, 0);
        return bind::bindPoints({base, lattice.positions}, model.positions(), targetOf(options),
                                {.embedding = embedding,
                                 .weights = io::weightsOf(options.model, model, part, false),
                                 .falloff = options.common.falloff});
    });
}

std::optional<stencils::FactoredTable<double>> bindInFactors(const BindOptions& options,
                                                             std::span<const Point3> points,
                                                             const Lattice& lattice,
                                                             Stages& stages) {
    if (options.basis || options.limit) return std::nullopt;
    return stages.run("binding in factors", [&] {
        const auto base = refineLattice(options.rest, lattice, options.common, 0);
        auto bound = embed::bindFactored({base, lattice.positions}, points,
                                         {.level = options.level,
                                          .embedding = options.common.embedding,
                                          .progress = progressOf(stages, points.size())});
        stages.addBytes(bytesOf(bound.table));
        return std::move(bound.table);
    });
}

}  // namespace espalier::cli
