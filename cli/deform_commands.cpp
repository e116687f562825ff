// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/printable.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/directions.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <espalier/io/numbered_path.h>
#include <espalier/io/pose_file.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>
#include <fmt/format.h>

#include <optional>

#include "bind_model.h"
#include "commands.h"
#include "files.h"
#include "run_report.h"
#include "standard_streams.h"

namespace espalier::cli {
namespace {

using embed::Binding;

struct DeformOptions : BindOptions {
    std::vector<std::string> poses;
    std::string output;
    ReportFormat report = ReportFormat::Text;
};

/// Returns the output file of each pose. Checks all inputs and outputs before any work is done.
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

/// Throws if the model cannot be written to the output. Names the data that an output in another
/// format lacks on standard error. Call this between stages.
void checkTarget(const io::Model& model, const std::filesystem::path& output) {
    if (const std::string losses = model.checkTarget(output); !losses.empty())
        printError(losses.c_str());
}

/// Returns the deformation gradient of each point for a pose of the lattice.
std::vector<io::DeformationGradient> gradientsAt(const io::BoundGradients& gradients,
                                                 const std::vector<Point3>& rest,
                                                 const std::vector<Point3>& pose) {
    // Computed from displacements, so that points that do not move have exactly the identity.
    std::vector<double> moved;
    for (std::size_t v = 0; v < pose.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) moved.push_back(pose[v][c] - rest[v][c]);
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

/// Applies a pose and writes the deformed model.
/// \param rest the lattice at rest; empty if it is not known
/// \param gradients deform the normals and tangents of the model, if there are any
void writePose(const io::Model& model, const Binding& binding, const std::vector<Point3>& rest,
               const std::optional<io::BoundGradients>& gradients, const std::vector<Point3>& pose,
               const std::filesystem::path& path, Stages& stages) {
    std::vector<io::DeformationGradient> atPoints;
    const auto points = stages.run("applying", [&] {
        auto moved = rest.empty() ? osd::evaluateBinding(binding, pose)
                                  : osd::evaluateBinding(binding, {model.positions(), rest}, pose);
        if (gradients) atPoints = gradientsAt(*gradients, rest, pose);
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

void runDeform(const DeformOptions& options) {
    checkBasis(options);
    const ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    const auto paths = posePaths(options);
    const auto model = stages.read(options.model, [&] { return io::readModel(options.model); });
    checkTarget(*model, paths.front());
    const Lattice rest = readLattice(options.rest, stages);
    const auto poses = readPoses(options.poses, rest, options.rest, stages);
    const auto [bound, gradients] = bindModel(options, model->positions(), rest, stages,
                                              options.limit && model->hasDirections());
    for (std::size_t i = 0; i < poses.size(); ++i)
        writePose(*model, bound.binding, rest.positions, gradients, poses[i], paths[i], stages);
    print({&bound, bound.binding, stages, peakMemory()}, options.report, options.common);
}

void runBind(const DeformOptions& options) {
    checkBasis(options);
    const ThreadLimit limit(options.common.threads);
    const std::vector<Input> inputs = {{"MODEL", options.model}, {"--rest", options.rest}};
    checkInputs(inputs);
    checkOutput(options.output, inputs, {".espb"});
    Stages stages(options.common.quiet);
    io::BoundModel file;
    file.modelName = std::filesystem::path(options.model).filename().string();
    const auto model = stages.run("reading", [&] {
        file.modelBytes = io::readFile(options.model);
        stages.addBytes(file.modelBytes.size());
        return io::readModel(options.model, file.modelBytes);
    });
    const Lattice rest = readLattice(options.rest, stages);
    auto [bound, gradients] = bindModel(options, model->positions(), rest, stages,
                                        options.limit && model->hasDirections());
    file.binding = std::move(bound.binding);
    file.gradients = std::move(gradients);
    file.rest = rest.positions;
    file.faces = io::facesOf(rest.complex);
    stages.run("writing", [&] {
        io::writeBoundModel(options.output, file);
        stages.addFile(options.output);
    });
    print({&bound, file.binding, stages, peakMemory()}, options.report, options.common);
}

void runApply(const DeformOptions& options) {
    const ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    const auto paths = posePaths(options);
    io::BoundModel bound;
    const auto model = stages.read(options.model, [&] {
        bound = io::readBoundModel(options.model);
        return io::readModel(bound.modelName, bound.modelBytes);
    });
    checkTarget(*model, paths.front());
    const auto& table = bound.binding.table;
    if (std::ssize(model->positions()) != table.rowCount())
        throw io::FileError(options.model,
                            "is damaged: its model does not have the points that were bound");
    const auto read = [&](const std::string& path, io::ReadNotes* notes) {
        return io::readPose(path, bound, printable(options.model), notes);
    };
    const auto poses = readPoses(options.poses, read, stages);
    for (std::size_t i = 0; i < poses.size(); ++i)
        writePose(*model, bound.binding, bound.rest, bound.gradients, poses[i], paths[i], stages);
    print({nullptr, bound.binding, stages, peakMemory()}, options.report, options.common);
}

void addPosesAndOutput(CLI::App& command, DeformOptions& options) {
    command
        .add_option(
            "--to", options.poses,
            "The poses: one or more deformed lattices with the topology of the lattice at rest, or "
            "cages of it (.obj, .ply)")
        ->required();
    addOutputOption(
        command, options.output,
        "The deformed model, in the format of MODEL or, by its extension, in another model format. "
        "With several poses, %04d in the name stands for the number of the pose, and .0000, .0001 "
        "... is added without it")
        ->required();
}

void addRunAndReport(CLI::App& command, DeformOptions& options) {
    addRunOptions(command, options.common);
    addReportOption(command, options.report);
}

}  // namespace

void addDeformCommands(CLI::App& program) {
    const auto [deform, deformOptions] = addCommand(
        program, "deform",
        "Deform a model: bind it to a lattice at rest, then apply each pose of the lattice",
        runDeform);
    addModelAndRest(deform, deformOptions);
    addPosesAndOutput(deform, deformOptions);
    addBindingOptions(deform, deformOptions);
    addRunAndReport(deform, deformOptions);

    const auto [bind, bindOptions] = addCommand(
        program, "bind",
        "Bind a model to a lattice at rest, and write the binding, for espalier apply", runBind);
    addModelAndRest(bind, bindOptions);
    addOutputOption(bind, bindOptions.output, "The bound model: .espb")->required();
    addBindingOptions(bind, bindOptions);
    addRunAndReport(bind, bindOptions);

    const auto [apply, applyOptions] =
        addCommand(program, "apply", "Deform a bound model by each pose of its lattice", runApply);
    apply.add_option("BINDING", applyOptions.model, "The bound model: .espb")->required();
    addPosesAndOutput(apply, applyOptions);
    addRunAndReport(apply, applyOptions);
}

}  // namespace espalier::cli
