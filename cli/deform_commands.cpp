// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/printable.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/directions.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/numbered_path.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>
#include <fmt/format.h>

#include <functional>
#include <memory>
#include <optional>

#include "bind_model.h"
#include "byte_counts.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "pipeline.h"
#include "run_report.h"

namespace espalier::cli {
namespace {

using Binding = embed::Binding;

struct DeformOptions : BindOptions {
    std::vector<std::string> poses;
    std::string output;
    ReportFormat report = ReportFormat::Text;
};

/// The name of the file of each pose; checked before any work is done.
std::vector<std::filesystem::path> posePaths(const DeformOptions& options) {
    std::vector<std::filesystem::path> paths;
    const int count = static_cast<int>(options.poses.size());
    const bool isBound = options.rest.empty();
    std::vector<Input> inputs = {{isBound ? "BINDING" : "MODEL", options.model}};
    if (!isBound) inputs.push_back({"--rest", options.rest});
    for (const Input& pose : inputsOf("--to", options.poses)) inputs.push_back(pose);
    checkInputs(inputs);
    for (int i = 0; i < count; ++i) {
        paths.push_back(io::numberedPath(options.output, i, count));
        checkOutput(paths.back(), inputs);
    }
    checkDistinct(paths);
    return paths;
}

/// Reads all poses, each with `read`, before any is written: a bad one leaves nothing half done.
/// If consecutive poses have the same notes, only the notes of the first are printed.
std::vector<std::vector<Point3>> readPoses(
    const DeformOptions& options, Stages& stages,
    const std::function<std::vector<Point3>(const std::string&, io::ReadNotes&)>& read) {
    std::vector<std::vector<Point3>> poses;
    io::ReadNotes before;
    for (const std::string& path : options.poses) {
        io::ReadNotes notes;
        poses.push_back(stages.run("reading", [&] {
            stages.addFile(path);
            return read(path, notes);
        }));
        if (notes != before) printNotes(path, notes);
        before = std::move(notes);
    }
    return poses;
}

/// The deformation gradient of each point for a pose of the lattice.
std::vector<io::DeformationGradient> gradientsAt(const io::BoundGradients& gradients,
                                                 const std::vector<Point3>& pose) {
    // Of the displacements, so that what does not move has the identity to the last bit.
    std::vector<double> moved;
    for (std::size_t v = 0; v < pose.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) moved.push_back(pose[v][c] - gradients.rest[v][c]);
    const Index count = gradients.tables[0].rowCount();
    std::vector<io::DeformationGradient> result(count, {1, 0, 0, 0, 1, 0, 0, 0, 1});
    const auto layout = osd::BufferDescriptor::packed(3);
    std::vector<double> column(3 * result.size());
    for (std::size_t j = 0; j < 3; ++j) {
        osd::CpuEvaluator::evaluate(gradients.tables[j], std::span<const double>(moved), layout,
                                    std::span(column), layout, {0, count});
        for (std::size_t point = 0; point < result.size(); ++point)
            for (std::size_t i = 0; i < 3; ++i) result[point][3 * i + j] += column[3 * point + i];
    }
    return result;
}

/// \param gradients which carry the model's directions with the pose, if there are any
void writePose(const io::Model& model, const Binding& binding,
               const std::optional<io::BoundGradients>& gradients, const std::vector<Point3>& pose,
               const std::filesystem::path& path, Stages& stages) {
    std::vector<io::DeformationGradient> atPoints;
    const auto points = stages.run("applying", [&] {
        auto moved = osd::evaluateBinding(binding, pose);
        if (gradients) atPoints = gradientsAt(*gradients, pose);
        stages.addBytes(bytesOf(binding.table) + (pose.size() + moved.size()) * sizeof(Point3));
        return moved;
    });
    stages.run("writing", [&] {
        if (gradients)
            model.write(path, points, atPoints);
        else
            model.write(path, points);
        stages.addFile(path);
    });
}

/// A model bound to the lattice of the options. Gradients are there if they have directions to
/// carry.
struct Bound {
    BoundPoints points;
    std::optional<io::BoundGradients> gradients = {};
};

Bound bindModel(const DeformOptions& options, const io::Model& model, const Lattice& lattice,
                Stages& stages) {
    const bool carries = options.limit && model.hasDirections();
    Bound bound{bindPoints(options, model.positions(), lattice, stages,
                           carries ? Gradients::OfLimit : Gradients::No)};
    if (carries)
        bound.gradients = io::BoundGradients{std::move(bound.points.gradients), lattice.positions};
    return bound;
}

void runDeform(const DeformOptions& options) {
    checkBasis(options);
    const ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    const auto paths = posePaths(options);
    const auto model = readModel(options.model, stages);
    model->checkTarget(paths.front());
    const Lattice lattice = readLattice(options.rest, stages);
    const auto poses =
        readPoses(options, stages, [&](const std::string& path, io::ReadNotes& notes) {
            return readPose(path, lattice, options.rest, notes);
        });
    const Bound bound = bindModel(options, *model, lattice, stages);
    for (std::size_t i = 0; i < poses.size(); ++i)
        writePose(*model, bound.points.binding, bound.gradients, poses[i], paths[i], stages);
    if (!options.common.quiet)
        print({bound.points.report, bound.points.binding, stages, peakMemory()}, options.report);
}

void runBind(const DeformOptions& options) {
    checkBasis(options);
    const ThreadLimit limit(options.common.threads);
    const std::vector<Input> inputs = {{"MODEL", options.model}, {"--rest", options.rest}};
    checkInputs(inputs);
    checkOutput(options.output, inputs, {".espb"});
    Stages stages(options.common.quiet);
    io::BoundModel file;
    const auto model = stages.run("reading", [&] {
        file.modelBytes = io::readFile(options.model);
        stages.addBytes(file.modelBytes.size());
        return io::readModel(options.model, file.modelBytes);
    });
    const Lattice lattice = readLattice(options.rest, stages);
    Bound bound = bindModel(options, *model, lattice, stages);
    file.binding = std::move(bound.points.binding);
    file.gradients = std::move(bound.gradients);
    file.modelName = std::filesystem::path(options.model).filename().string();
    stages.run("writing", [&] {
        io::writeBoundModel(options.output, file);
        stages.addFile(options.output);
    });
    if (!options.common.quiet)
        print({bound.points.report, file.binding, stages, peakMemory()}, options.report);
}

/// Reads a pose of the lattice that a model was bound to.
std::vector<Point3> readPoseOf(const Binding& binding, const std::string& path,
                               const DeformOptions& options, io::ReadNotes& notes) {
    Lattice pose = io::readLattice(path, &notes);
    if (far::topologyHash(pose.complex) != binding.topologyHash)
        throw io::FileError(
            path, fmt::format("is not a pose of the lattice that {} was bound to, which has "
                              "{} vertices: this one has {}, or its cells differ",
                              printable(options.model), binding.table.columnCount(),
                              pose.complex.count(0)));
    return std::move(pose.positions);
}

void runApply(const DeformOptions& options) {
    const ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    const auto paths = posePaths(options);
    io::BoundModel bound;
    const auto model = stages.run("reading", [&] {
        stages.addFile(options.model);
        bound = io::readBoundModel(options.model);
        return io::readModel(bound.modelName, bound.modelBytes);
    });
    model->checkTarget(paths.front());
    if (model->positions().size() != static_cast<std::size_t>(bound.binding.table.rowCount()))
        throw io::FileError(options.model, "holds a model of other points than were bound");
    const auto poses =
        readPoses(options, stages, [&](const std::string& path, io::ReadNotes& notes) {
            return readPoseOf(bound.binding, path, options, notes);
        });
    for (std::size_t i = 0; i < poses.size(); ++i)
        writePose(*model, bound.binding, bound.gradients, poses[i], paths[i], stages);
    if (!options.common.quiet)
        print({std::nullopt, bound.binding, stages, peakMemory()}, options.report);
}

void addPosesAndOutput(CLI::App& command, DeformOptions& options) {
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
        auto options = std::make_shared<DeformOptions>();
        CLI::App& command = *program.add_subcommand(
            "deform", "Bind a model to a lattice, and apply each pose of the lattice to it");
        addModelAndRest(command, *options);
        addPosesAndOutput(command, *options);
        addBindingOptions(command, *options);
        addRunOptions(command, options->common);
        addReportOption(command, options->report);
        command.callback([options] { runDeform(*options); });
    }
    {
        auto options = std::make_shared<DeformOptions>();
        CLI::App& command =
            *program.add_subcommand("bind", "Bind a model to a lattice, and keep the binding");
        addModelAndRest(command, *options);
        command.add_option("-o,--output", options->output, "The bound model: .espb")->required();
        addBindingOptions(command, *options);
        addRunOptions(command, options->common);
        addReportOption(command, options->report);
        command.callback([options] { runBind(*options); });
    }
    {
        auto options = std::make_shared<DeformOptions>();
        CLI::App& command =
            *program.add_subcommand("apply", "Apply poses of its lattice to a bound model");
        command.add_option("BINDING", options->model, "The bound model: .espb")->required();
        addPosesAndOutput(command, *options);
        addRunOptions(command, options->common);
        addReportOption(command, options->report);
        command.callback([options] { runApply(*options); });
    }
}

}  // namespace espalier::cli
