// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/io/animations/animation_file.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/directions.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <espalier/io/numbered_path.h>
#include <espalier/io/pose_file.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "bind_model.h"
#include "commands.h"
#include "files.h"
#include "job.h"
#include "kept_patches.h"
#include "mesh_check.h"
#include "run_report.h"
#include "standard_streams.h"

namespace espalier::cli {
namespace {

struct DeformOptions : BindOptions {
    MeshOptions mesh;
    std::vector<std::string> poses;
    std::vector<std::string> slides;  ///< the patches whose points slide
    std::string output;
    bool keepNormals = false;     ///< normals, tangents and splats stay as they are
    double framesPerSecond = 24;  ///< the frame rate of an animation
    ReportFormat report = ReportFormat::Text;
};

bool isAnimation(const DeformOptions& options) {
    return io::isAnimation(options.output, options.poses.size());
}

/// Returns the output file of each pose; of an animation, its only file.
std::vector<std::filesystem::path> posePaths(const DeformOptions& options) {
    if (isAnimation(options)) return {options.output};
    std::vector<std::filesystem::path> paths;
    const int count = static_cast<int>(options.poses.size());
    for (int i = 0; i < count; ++i) paths.push_back(io::numberedPath(options.output, i, count));
    return paths;
}

/// Tells the job which files will be written.
void addOutputs(Job& job, const DeformOptions& options,
                const std::vector<std::filesystem::path>& paths) {
    for (const auto& path : paths)
        for (const auto& file : isAnimation(options) ? std::vector{path} : io::modelTargets(path))
            job.writes(file);
}

/// Throws if the model cannot be written to the output. Names the data that an output in another
/// format lacks on standard error. Call this between stages.
void checkTarget(const io::Model& model, const DeformOptions& options) {
    const std::string losses = isAnimation(options) ? io::lossesInAnimation(options.output, model)
                                                    : model.checkTarget(posePaths(options).front());
    if (!losses.empty()) printError(losses.c_str());
}

/// The points of a model in each pose, and how normals, tangents and splats turn: from a binding,
/// or from deformModel().
class PosedModel {
public:
    PosedModel(const bind::Binding& binding, const std::vector<std::vector<Point3>>& poses)
        : binding_(&binding), poses_(poses) {}
    PosedModel(osd::DeformedPoints& deformed, const std::vector<std::vector<Point3>>& poses)
        : deformed_(&deformed), poses_(poses) {}

    std::size_t poseCount() const { return poses_.size(); }
    const std::vector<Point3>& pose(std::size_t pose) const { return poses_[pose]; }

    /// \param isLast the points of this pose are not asked for again
    std::vector<Point3> points(std::size_t pose, bool isLast, Stages& stages) const {
        if (deformed_ != nullptr) {
            auto& points = deformed_->poses[pose].points;
            return isLast ? std::move(points) : points;
        }
        return stages.run("applying", [&] {
            auto points = osd::evaluateBinding(*binding_, poses_[pose]);
            stages.addBytes(bytesOf(binding_->table) +
                            (poses_[pose].size() + points.size()) * sizeof(Point3));
            return points;
        });
    }

    /// Returns the gradients of a pose, which are not asked for again.
    std::vector<DeformationGradient> gradients(std::size_t pose) const {
        if (deformed_ != nullptr) return std::move(deformed_->poses[pose].gradients);
        return osd::evaluateGradients(*binding_, poses_[pose]);
    }

private:
    const bind::Binding* binding_ = nullptr;  // One of these two is null.
    osd::DeformedPoints* deformed_ = nullptr;
    const std::vector<std::vector<Point3>>& poses_;
};

/// A model that is written in each pose.
struct Deformation {
    const io::Model& model;
    PosedModel posed;
    KeptPatches& kept;
    bool turnsDirections;  ///< normals, tangents and splats follow

    /// \param isLast the points of this pose are not asked for again
    std::vector<Point3> points(std::size_t pose, bool isLast, Stages& stages) const {
        auto points = posed.points(pose, isLast, stages);
        if (kept.needsPoints()) stages.run("sliding", [&] { kept.keep(points, posed.pose(pose)); });
        return points;
    }

    void write(const std::filesystem::path& path, const std::vector<Point3>& points,
               std::size_t pose, Stages& stages) const {
        stages.run("writing", [&] {
            if (turnsDirections)
                model.write(path, points, posed.gradients(pose));
            else
                model.write(path, points);
            for (const auto& file : io::modelTargets(path)) stages.addFile(file);
        });
    }
};

/// Calls f, which checks the cells of a mesh that have been read. If the user has not asked for the
/// check, an error of it, such as coordinates that are too large for it, becomes a warning that
/// begins with `what`, and does not stop the deformation.
template <class F>
void orWarning(const DeformOptions& options, const std::string& what, F f) {
    try {
        f();
    } catch (const MemoryError&) {
        throw;
    } catch (const Error& error) {
        if (options.mesh.isRequired()) throw;
        printError(("warning: " + what + error.what()).c_str());
    }
}

/// The reports on the mesh in each pose.
struct MeshReports {
    std::string text;
    OrderedJson json = OrderedJson::array();
};

/// Applies all poses and writes the deformed models. Checks the cells of the model, if it has any.
/// \param check may be null
MeshReports writePoses(const Deformation& deformation, const DeformOptions& options,
                       const std::vector<std::filesystem::path>& paths, const MeshCheck* check,
                       Stages& stages) {
    // Refuse a pose before the first one is written.
    const std::size_t poseCount = deformation.posed.poseCount();
    for (std::size_t i = 0; check && options.mesh.noInverted && i < poseCount; ++i) {
        auto points = deformation.points(i, false, stages);
        check->requireValid(check->check(points, options.poses[i], options.mesh, stages),
                            options.poses[i], options.mesh);
    }
    MeshReports reports;
    const auto pointsOf = [&](std::size_t i) {
        auto points = deformation.points(i, true, stages);
        if (!check) return points;
        orWarning(options, "cells not checked: ", [&] {
            const solve::MeshVerdict verdict =
                check->check(points, options.poses[i], options.mesh, stages);
            reports.text += check->text(verdict, options.poses[i]);
            reports.json.push_back(check->toJson(verdict, options.poses[i]));
            if (!options.common.quiet) check->warn(verdict, options.poses[i]);
        });
        return points;
    };
    if (isAnimation(options)) {
        // Frames are applied while the file is written; the stages cannot be nested.
        std::vector<std::vector<Point3>> frames;
        for (std::size_t i = 0; i < poseCount; ++i) frames.push_back(pointsOf(i));
        stages.run("writing", [&] {
            io::Animation animation = {[&](std::size_t i) { return std::move(frames[i]); },
                                       frames.size(), options.framesPerSecond};
            if (deformation.turnsDirections)
                animation.gradients = [&](std::size_t i) { return deformation.posed.gradients(i); };
            io::writeAnimation(options.output, deformation.model, animation);
            stages.addFile(options.output);
        });
        return reports;
    }
    for (std::size_t i = 0; i < poseCount; ++i) deformation.write(paths[i], pointsOf(i), i, stages);
    return reports;
}

/// Returns the check if the model has cells; null if not.
/// \throws FileError if an option asks for a check of a model without cells that can be checked
const MeshCheck* requiredCheck(const std::optional<MeshCheck>& check,
                               const DeformOptions& options) {
    if (!check) return nullptr;
    if (check->hasCells()) return &*check;
    if (!options.mesh.isRequired()) return check->unchecked().empty() ? nullptr : &*check;
    const char* option = options.mesh.noInverted ? "--no-inverted" : "--largest-step";
    if (!check->unchecked().empty())
        throw io::FileError(options.model, concat("has ", check->unchecked()[0].count, " ",
                                                  check->unchecked()[0].name, ", which ", option,
                                                  " cannot check, and no other cells"));
    throw io::FileError(
        options.model, concat("has no cells of a volume, so there is nothing to check for ", option,
                              options.rest.empty() ? "; the faces of an OpenFOAM mesh are not "
                                                     "in a binding: use espalier deform"
                                                   : ""));
}

/// Returns true if the output has no place for normals and tangents.
bool dropsDirections(const DeformOptions& options) {
    return isAnimation(options) && !io::animationHoldsNormals(options.output);
}

/// Returns true if normals, tangents and splats of the model should follow its points.
bool asksForDirections(const io::Model& model, const DeformOptions& options) {
    return model.hasDirections() && !options.keepNormals && !dropsDirections(options);
}

/// Returns true if they do.
bool turnsDirections(const io::Model& model, const bind::BindingStatistics& binding,
                     const DeformOptions& options) {
    return binding.hasGradients && asksForDirections(model, options);
}

/// Finds the patches that slide.
/// \throws FileError if one cannot slide, or another option cannot go with it
KeptPatches findKeptPatches(const io::Model& model, const DeformOptions& options, Stages& stages) {
    KeptPatches kept(options.model, model, options.slides, stages);
    if (kept.slidesAny() && asksForDirections(model, options))
        throw io::FileError(options.model,
                            "has normals, tangents or splats, which follow the lattice and not the "
                            "points that slide. Add --keep-normals to leave them as they are");
    if (options.mesh.largestStep) kept.requireStraight();
    return kept;
}

/// Returns "5 normals, 5 tangents and 5 splats", without those of which there are none.
std::string listOf(const io::DirectionCounts& counts) {
    std::string all;
    std::size_t left = counts.count();
    const auto add = [&](std::size_t count, const char* what) {
        left -= count;
        if (count > 0)
            all += fmt::format("{}{} {}{}",
                               all.empty() ? ""
                               : left > 0  ? ", "
                                           : " and ",
                               count, what, count == 1 ? "" : "s");
    };
    add(counts.normals, "normal");
    add(counts.tangents, "tangent");
    add(counts.splats, "splat");
    return all;
}

/// Says what happens to the normals, tangents and splats of a model; nothing if it has none.
std::string directionsReport(const io::Model& model, const bind::BindingStatistics& binding,
                             const DeformOptions& options) {
    const io::DirectionCounts counts = model.directions();
    if (counts.count() == 0) return {};
    const std::string all = listOf(counts);
    const bool isOne = counts.count() == 1;
    if (dropsDirections(options))
        return fmt::format("{} {} not in the animation, which holds points only", all,
                           isOne ? "is" : "are");
    const char* const stay = isOne ? "stays" : "stay";
    if (options.keepNormals) return fmt::format("{} {}, as --keep-normals asks", all, stay);
    if (!binding.hasGradients)
        return fmt::format("{} {}: the model was bound with --keep-normals", all, stay);
    const Index kept = binding.emptyRowCount;
    std::string exceptions;
    const auto except = [&](Index count, const char* where) {
        if (count > 0)
            exceptions += fmt::format("; those of {} {} {} stay", count,
                                      count == 1 ? "point" : "points", where);
    };
    except(kept, "left in place");
    except(binding.identityCount - kept, "where the lattice at rest is flat");
    if (counts.keptHarmonics > 0)
        exceptions += fmt::format("; harmonics f_rest stay, because there are {}, not 9, 24 or 45",
                                  counts.keptHarmonics);
    return fmt::format("{} {} with the model{}", all, isOne ? "turns" : "turn", exceptions);
}

void print(const RunReport& report, const KeptPatches& kept, const MeshReports& meshes,
           const DeformOptions& options) {
    if (options.common.quiet) return;
    if (options.report == ReportFormat::Json) {
        OrderedJson json = toJson(report);
        kept.addTo(json);
        if (!meshes.json.empty()) json["meshes"] = meshes.json;
        fmt::print("{}\n", json.dump(2));
    } else {
        printText(report);
        fmt::print("{}{}", kept.text(), meshes.text);
    }
    const bool isApplied = options.rest.empty();  // espalier bind has warned
    if (!isApplied) warnOfPointsOutside(report.binding, options.common);
}

void runDeform(const DeformOptions& options) {
    checkBasis(options);
    Job job(options.common,
            {{"MODEL", options.model}, {"--rest", options.rest}, {"--to", options.poses}});
    const auto paths = posePaths(options);
    addOutputs(job, options, paths);
    Stages& stages = job.stages();
    const auto model = readModel(options.model, options.common, stages);
    checkTarget(*model, options);
    const Lattice rest = readLattice(options.rest, stages);
    const auto poses = readPoses(options.poses, rest, options.rest, stages);
    KeptPatches kept = findKeptPatches(*model, options, stages);
    const bool hasGradients = asksForDirections(*model, options);
    // Few poses need no matrix.
    std::optional<bind::Binding> binding;
    osd::DeformedPoints deformed;
    if (poses.size() > osd::kMostPosesWithoutTable)
        binding = bindModel(options, *model, rest, stages, hasGradients);
    else
        deformed = deformModel(options, *model, rest, poses, stages, hasGradients);
    if (!options.common.quiet) kept.measureHeld(options, *model, rest, stages);
    const bool isChecked = !options.common.quiet || options.mesh.isRequired();
    std::optional<MeshCheck> check;
    if (isChecked) {
        io::ModelCells cells = readCells(*model, stages);
        orWarning(options, "cells not checked: ", [&] {
            check.emplace(options.model, *model, std::move(cells), options.output,
                          options.poses.size(), stages);
        });
    }
    RunReport report = binding ? reportOf(*binding, stages)
                               : RunReport{deformed.statistics, std::nullopt, stages, peakMemory()};
    report.directions = directionsReport(*model, report.binding, options);
    const MeshReports meshes =
        writePoses({*model, binding ? PosedModel(*binding, poses) : PosedModel(deformed, poses),
                    kept, turnsDirections(*model, report.binding, options)},
                   options, paths, requiredCheck(check, options), stages);
    report.peakMemory = peakMemory();
    print(report, kept, meshes, options);
}

void runBind(const DeformOptions& options) {
    checkBasis(options);
    Job job(options.common, {{"MODEL", options.model}, {"--rest", options.rest}});
    job.writes(options.output, {".espb"});
    Stages& stages = job.stages();
    io::BoundModel file;
    const std::filesystem::path modelPath = io::modelFile(options.model);
    file.modelName = io::modelName(modelPath);
    const auto model = stages.run("reading", [&] {
        file.modelBytes = io::readModelBytes(modelPath);
        stages.addBytes(file.modelBytes.size());
        return io::readModel(modelPath, file.modelBytes);
    });
    tellNotes(options.model, *model, options.common);
    // A bound model cannot hold such a point; deform can leave it as it is.
    for (std::size_t i = 0; i < model->positions().size(); ++i)
        for (const double coordinate : model->positions()[i])
            if (!std::isfinite(coordinate))
                throw io::FileError(options.model, concat("point ", i,
                                                          " is not finite, and a bound model can "
                                                          "hold finite points only; use espalier "
                                                          "deform"));
    const Lattice rest = readLattice(options.rest, stages);
    file.binding = bindModel(options, *model, rest, stages, asksForDirections(*model, options));
    file.faces = io::facesOf(rest.complex);
    stages.run("writing", [&] {
        io::writeBoundModel(options.output, file);
        stages.addFile(options.output);
    });
    RunReport report = reportOf(file.binding, stages);
    report.directions = directionsReport(*model, report.binding, options);
    print(report, options.report, options.common);
}

void runApply(const DeformOptions& options) {
    Job job(options.common, {{"BINDING", options.model}, {"--to", options.poses}});
    const auto paths = posePaths(options);
    addOutputs(job, options, paths);
    Stages& stages = job.stages();
    io::BoundModel bound;
    const auto model = stages.read(options.model, [&] {
        bound = io::readBoundModel(options.model);
        return io::modelOf(bound, options.model);
    });
    tellNotes(options.model, *model, options.common);
    checkTarget(*model, options);
    const auto read = [&](const std::string& path, io::ReadNotes* notes) {
        return io::readPose(path, bound, printable(options.model), notes);
    };
    const auto poses = readPoses(options.poses, read, stages);
    KeptPatches kept = findKeptPatches(*model, options, stages);
    // Checking takes much longer than applying, so only on request.
    std::optional<MeshCheck> check;
    if (options.mesh.isRequired())
        check.emplace(options.model, *model, readCells(*model, stages), options.output,
                      options.poses.size(), stages);
    RunReport report = reportOf(bound.binding, stages);
    report.directions = directionsReport(*model, report.binding, options);
    const MeshReports meshes = writePoses({*model, PosedModel(bound.binding, poses), kept,
                                           turnsDirections(*model, report.binding, options)},
                                          options, paths, requiredCheck(check, options), stages);
    report.peakMemory = peakMemory();
    print(report, kept, meshes, options);
}

void addPosesAndOutput(CLI::App& command, DeformOptions& options) {
    command
        .add_option(
            "--to", options.poses,
            "The poses: one or more deformed lattices with the topology of the lattice at rest, or "
            "editor meshes of it (" +
                filesToWrite(io::FileContent::EditorMesh) + ")")
        ->required();
    addOutputOption(
        command, options.output,
        "The deformed model, in the format of MODEL or, by its extension, in another model format. "
        "With several poses, %04d in the name stands for the number of the pose, and .0000, .0001 "
        "... is added without it. Or all poses in one file, an animation: " +
            filesToWrite(io::FileContent::Animation))
        ->required();
    command
        .add_option("--frame-rate", options.framesPerSecond, "Poses per second in an .mdd or .glb")
        ->check(aboveZero())
        ->capture_default_str();
}

void addKeepNormals(CLI::App& command, DeformOptions& options) {
    command.add_flag("--keep-normals", options.keepNormals,
                     "Leave normals, tangents and splats of the model as they are. By default they "
                     "turn with the points");
}

void addRunAndReport(CLI::App& command, DeformOptions& options) {
    addStrictOption(command, options.common);
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
    addPartOptions(deform, deformOptions.part, deformOptions.common);
    addSlideOption(deform, deformOptions.slides);
    addKeepNormals(deform, deformOptions);
    addMeshOptions(deform, deformOptions.mesh);
    addRunAndReport(deform, deformOptions);

    const auto [bind, bindOptions] = addCommand(
        program, "bind",
        "Bind a model to a lattice at rest, and write the binding, for espalier apply", runBind);
    addModelAndRest(bind, bindOptions);
    addOutputOption(bind, bindOptions.output, "The bound model: .espb")->required();
    addBindingOptions(bind, bindOptions);
    addPartOptions(bind, bindOptions.part, bindOptions.common);
    addKeepNormals(bind, bindOptions);
    addRunAndReport(bind, bindOptions);

    const auto [apply, applyOptions] =
        addCommand(program, "apply", "Deform a bound model by each pose of its lattice", runApply);
    apply.add_option("BINDING", applyOptions.model, "The bound model: .espb")->required();
    addPosesAndOutput(apply, applyOptions);
    addSlideOption(apply, applyOptions.slides);
    addKeepNormals(apply, applyOptions);
    addMeshOptions(apply, applyOptions.mesh);
    addRunAndReport(apply, applyOptions);
}

}  // namespace espalier::cli
