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

#include <functional>
#include <map>
#include <memory>
#include <span>

#include "choice.h"
#include "commands.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

using Binding = stencils::Binding<double>;
using stencils::PointStatus;

/// What weighs the vertices of the lattice: subdivision, or what there was before it.
enum class Basis { Subdivision, Bezier, BSpline };

const std::map<std::string, Basis> kBasisWords = {
    {"subdivision", Basis::Subdivision}, {"bezier", Basis::Bezier}, {"bspline", Basis::BSpline}};

struct Options {
    CommonOptions common;
    std::string model;
    std::string rest;
    std::vector<std::string> poses;
    std::string output;
    Basis basis = Basis::Subdivision;
    int level = 3;
    std::vector<const CLI::Option*> ofSubdivision;  ///< those that no other basis has a use for
};

/// What binding found, for the report.
struct BindingReport {
    far::Index inside, outside, notConverged;
    double largestResidual;
};

template <class Place>
BindingReport reportOf(const stencils::PlacedPoints<Place>& embedding) {
    return {embedding.count(PointStatus::Inside), embedding.count(PointStatus::Outside),
            embedding.count(PointStatus::NotConverged), embedding.largestResidual()};
}

/// Shows how far the stage is that embeds so many points.
std::function<void(far::Offset)> progressOf(Stages& stages, std::size_t pointCount) {
    return [&stages, pointCount](far::Offset done) {
        stages.showProgress(static_cast<std::size_t>(done), pointCount);
    };
}

/// MacCracken & Joy 1996, section 5.
Binding bindToSubdivision(const Options& options, std::span<const Point3> points,
                          const Lattice& lattice, Stages& stages, BindingReport& report) {
    const auto refiner = stages.run("refining", [&] {
        return refineLattice(options.rest, lattice, options.common, options.level);
    });
    const auto embedding = stages.run("embedding", [&] {
        const auto positions = stencils::refinePositions(refiner, options.level,
                                                         options.common.rules, lattice.positions);
        return stencils::embedPoints(refiner.level(options.level).complex, positions, points,
                                     options.common.embedding, progressOf(stages, points.size()));
    });
    report = reportOf(embedding);
    return stages.run("building stencils", [&] {
        return stencils::makeBinding<double>(refiner, options.level, options.common.rules,
                                             embedding, points);
    });
}

stencils::TensorLattice tensorLattice(const Options& options, const Lattice& lattice) {
    try {
        return {
            lattice.complex, lattice.positions,
            options.basis == Basis::Bezier ? stencils::Basis::Bezier : stencils::Basis::BSpline};
    } catch (const Error& error) {
        throw io::FileError(options.rest, error.what());
    }
}

/// The same for the lattices of the paper's section 1.
Binding bindToTensorProduct(const Options& options, std::span<const Point3> points,
                            const Lattice& lattice, Stages& stages, BindingReport& report) {
    // To go on without them would be another deformation than the file asks for.
    if (!lattice.marks.empty())
        throw io::FileError(options.rest, "has marks, which only --basis subdivision heeds");
    const auto tensor = stages.run("embedding", [&] { return tensorLattice(options, lattice); });
    const auto embedding = stages.run("embedding", [&] {
        return stencils::embedPoints(tensor, points, options.common.embedding,
                                     progressOf(stages, points.size()));
    });
    report = reportOf(embedding);
    return stages.run("building stencils",
                      [&] { return stencils::makeBinding<double>(tensor, embedding, points); });
}

/// Freezes a model to the lattice of options.rest.
Binding bindModel(const Options& options, const io::Model& model, const Lattice& lattice,
                  Stages& stages, BindingReport& report) {
    const auto bind = options.basis == Basis::Subdivision ? bindToSubdivision : bindToTensorProduct;
    return bind(options, model.positions(), lattice, stages, report);
}

/// Refuses options that the basis has no use for, rather than pass over them.
void checkBasis(const Options& options) {
    if (options.basis == Basis::Subdivision) return;
    for (const CLI::Option* option : options.ofSubdivision)
        if (option->count() > 0)
            throw CLI::ValidationError(option->get_name(),
                                       "is of use with --basis subdivision only");
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
    checkBasis(options);
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
    checkBasis(options);
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

/// --basis, and the options of the only basis that has any.
void addBasis(CLI::App& command, Options& options) {
    addChoice<Basis>(command, "--basis", options.basis, kBasisWords,
                     "What weighs the lattice: its subdivision; or, of a box that lies on a "
                     "parallelepiped, Bernstein polynomials or cubic B-splines");
    const auto others = static_cast<std::ptrdiff_t>(command.get_options().size());
    addLevelOption(command, options.level, 1);
    addRefinementOptions(command, options.common);
    const auto all = command.get_options();
    for (auto option = all.begin() + others; option != all.end(); ++option) {
        (*option)->group("With --basis subdivision only");
        options.ofSubdivision.push_back(*option);
    }
}

}  // namespace

void addDeformCommands(CLI::App& program) {
    {
        auto options = std::make_shared<Options>();
        CLI::App& command = *program.add_subcommand(
            "deform", "Bind a model to a lattice, and apply each pose of the lattice to it");
        addModelAndRest(command, *options);
        addPosesAndOutput(command, *options);
        addBasis(command, *options);
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
        addBasis(command, *options);
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
