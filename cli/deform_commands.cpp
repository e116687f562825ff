// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/numbered_path.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>

#include <memory>

#include "commands.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

using Binding = stencils::Binding<double>;
using stencils::PointStatus;

struct Options {
    CommonOptions common;
    std::string model;
    std::string rest;
    std::vector<std::string> poses;
    std::string output;
    int level = 3;
};

/// What binding found, for the report.
struct BindingReport {
    far::Index inside, outside, notConverged;
    double largestResidual;
};

/// Freezes a model to the lattice of options.rest (MacCracken & Joy 1996, section 5).
Binding bindModel(const Options& options, const io::Model& model, const Lattice& lattice,
                  Stages& stages, BindingReport& report) {
    const auto points = model.positions();
    const auto refiner = stages.run("refining", [&] {
        return refineLattice(options.rest, lattice, options.common, options.level);
    });
    const auto embedding = stages.run("embedding", [&] {
        const auto positions = stencils::refinePositions(refiner, options.level,
                                                         options.common.rules, lattice.positions);
        return stencils::embedPoints(refiner.level(options.level).complex, positions, points,
                                     options.common.embedding, [&](far::Offset done) {
                                         stages.showProgress(static_cast<std::size_t>(done),
                                                             points.size());
                                     });
    });
    report = {embedding.count(PointStatus::Inside), embedding.count(PointStatus::Outside),
              embedding.count(PointStatus::NotConverged), embedding.largestResidual()};
    return stages.run("building stencils", [&] {
        return stencils::makeBinding<double>(refiner, options.level, options.common.rules,
                                             embedding, points);
    });
}

void printReport(const BindingReport& report, const Binding& binding) {
    const auto& table = binding.table;
    const double bound = table.rowCount() - static_cast<double>(binding.kept.size());
    const auto bytes =
        table.offsets().size_bytes() + table.columns().size_bytes() + table.weights().size_bytes();
    fmt::print("points            {} inside, {} outside, {} not converged\n", report.inside,
               report.outside, report.notConverged);
    if (!binding.kept.empty()) fmt::print("kept in place     {}\n", binding.kept.size());
    fmt::print("largest residual  {:.2g}\n", report.largestResidual);
    fmt::print("matrix            {} × {}, {:.1f} entries a bound row, {}\n", table.rowCount(),
               table.columnCount(), bound > 0 ? static_cast<double>(table.entryCount()) / bound : 0,
               formatBytes(bytes));
}

void printStages(const Stages& stages) {
    for (const auto& [name, seconds] : stages.finished())
        fmt::print("{:<17} {:.3f} s\n", name, seconds);
    fmt::print("peak memory       {}\n", formatBytes(peakMemory()));
}

/// The name of the file of each pose; checked before any work is done.
std::vector<std::filesystem::path> outputPaths(const Options& options) {
    std::vector<std::filesystem::path> paths;
    const int count = static_cast<int>(options.poses.size());
    std::vector<std::string> inputs = options.poses;
    inputs.push_back(options.model);
    if (!options.rest.empty()) inputs.push_back(options.rest);
    for (int i = 0; i < count; ++i) {
        paths.push_back(io::numberedPath(options.output, i, count));
        checkOutput(paths.back(), inputs);
    }
    return paths;
}

void writePose(const io::Model& model, const Binding& binding, const std::vector<Point3>& pose,
               const std::filesystem::path& path, Stages& stages) {
    const auto points = stages.run("applying", [&] { return osd::evaluateBinding(binding, pose); });
    stages.run("writing", [&] { model.write(path, points); });
}

void runDeform(const Options& options) {
    const far::ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    const auto paths = outputPaths(options);
    const auto model = stages.run("reading", [&] { return io::readModel(options.model); });
    model->checkTarget(paths.front());
    const Lattice lattice = stages.run("reading", [&] { return io::readLattice(options.rest); });
    // All poses before any is written: a bad one leaves nothing half done.
    const auto poses = stages.run("reading", [&] {
        std::vector<std::vector<Point3>> all;
        for (const std::string& pose : options.poses)
            all.push_back(readPose(pose, lattice, options.rest));
        return all;
    });
    BindingReport report{};
    const Binding binding = bindModel(options, *model, lattice, stages, report);
    for (std::size_t i = 0; i < poses.size(); ++i)
        writePose(*model, binding, poses[i], paths[i], stages);
    if (options.common.quiet) return;
    printReport(report, binding);
    printStages(stages);
}

void runBind(const Options& options) {
    const far::ThreadLimit limit(options.common.threads);
    checkOutput(options.output, {options.model, options.rest}, ".espb");
    Stages stages(options.common.quiet);
    const std::string bytes = stages.run("reading", [&] { return io::readFile(options.model); });
    const auto model = stages.run("reading", [&] { return io::readModel(options.model, bytes); });
    const Lattice lattice = stages.run("reading", [&] { return io::readLattice(options.rest); });
    BindingReport report{};
    io::BoundModel bound;
    bound.binding = bindModel(options, *model, lattice, stages, report);
    bound.modelName = std::filesystem::path(options.model).filename().string();
    bound.modelBytes = bytes;
    stages.run("writing", [&] { io::writeBoundModel(options.output, bound); });
    if (options.common.quiet) return;
    printReport(report, bound.binding);
    printStages(stages);
}

void runApply(const Options& options) {
    const far::ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    const auto paths = outputPaths(options);
    const io::BoundModel bound =
        stages.run("reading", [&] { return io::readBoundModel(options.model); });
    const auto model =
        stages.run("reading", [&] { return io::readModel(bound.modelName, bound.modelBytes); });
    model->checkTarget(paths.front());
    if (model->positions().size() != static_cast<std::size_t>(bound.binding.table.rowCount()))
        throw io::FileError(options.model, "holds a model of other points than were bound");
    const auto poses = stages.run("reading", [&] {
        std::vector<std::vector<Point3>> all;
        for (const std::string& path : options.poses) {
            Lattice pose = io::readLattice(path);
            if (far::topologyHash(pose.complex) != bound.binding.topologyHash)
                throw io::FileError(
                    path,
                    fmt::format("is not a pose of the lattice that {} was bound to, which has "
                                "{} vertices: this one has {}, or its cells differ",
                                options.model, bound.binding.table.columnCount(),
                                pose.complex.count(0)));
            all.push_back(std::move(pose.positions));
        }
        return all;
    });
    for (std::size_t i = 0; i < poses.size(); ++i)
        writePose(*model, bound.binding, poses[i], paths[i], stages);
    if (!options.common.quiet) printStages(stages);
}

void addModelAndRest(CLI::App& command, Options& options) {
    command.add_option("MODEL", options.model, "The model: .obj, .ply, .stl or .vtu")->required();
    command
        .add_option("--rest", options.rest,
                    "The lattice as it lies around the model: .ovm, .vtu or .vtk")
        ->required();
    addLevelOption(command, options.level, 1);
}

void addPosesAndOutput(CLI::App& command, Options& options) {
    command
        .add_option("--to", options.poses,
                    "The lattice as it is deformed: same topology; one or more")
        ->required();
    command
        .add_option("-o,--output", options.output,
                    "The deformed model, in the format of the model; of several, %04d gives the "
                    "number its place")
        ->required();
}

}  // namespace

void addDeformCommands(CLI::App& program) {
    {
        auto options = std::make_shared<Options>();
        CLI::App& command = *program.add_subcommand(
            "deform", "Bind a model to a lattice, and apply each pose of the lattice to it");
        addModelAndRest(command, *options);
        addPosesAndOutput(command, *options);
        addRefinementOptions(command, options->common);
        addEmbeddingOptions(command, options->common);
        addRunOptions(command, options->common);
        command.callback([options] { runDeform(*options); });
    }
    {
        auto options = std::make_shared<Options>();
        CLI::App& command =
            *program.add_subcommand("bind", "Bind a model to a lattice, and keep the binding");
        addModelAndRest(command, *options);
        command.add_option("-o,--output", options->output, "The bound model: .espb")->required();
        addRefinementOptions(command, options->common);
        addEmbeddingOptions(command, options->common);
        addRunOptions(command, options->common);
        command.callback([options] { runBind(*options); });
    }
    {
        auto options = std::make_shared<Options>();
        CLI::App& command =
            *program.add_subcommand("apply", "Apply poses of its lattice to a bound model");
        command.add_option("BINDING", options->model, "The bound model: .espb")->required();
        addPosesAndOutput(command, *options);
        addRunOptions(command, options->common);
        command.callback([options] { runApply(*options); });
    }
}

}  // namespace espalier::cli
