// SPDX-License-Identifier: Apache-2.0
#include "mesh_check.h"

#include <espalier/base/printable.h>
#include <espalier/io/animations/animation_file.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "commands.h"
#include "files.h"
#include "standard_streams.h"

namespace espalier::cli {
namespace {

template <class Value>
OrderedJson valueOrNull(const std::optional<Value>& value) {
    return value ? OrderedJson(value->value) : OrderedJson(nullptr);
}

OrderedJson qualityJson(const solve::MeshQuality& quality) {
    return {{"scaled_jacobian", valueOrNull(quality.smallestScaledJacobian)},
            {"non_orthogonality", valueOrNull(quality.largestNonOrthogonality)},
            {"mean_non_orthogonality", quality.largestNonOrthogonality
                                           ? OrderedJson(quality.meanNonOrthogonality)
                                           : OrderedJson(nullptr)},
            {"severely_non_orthogonal", quality.severelyNonOrthogonal},
            {"beyond_right_angle", quality.beyondRightAngle},
            {"skewness", valueOrNull(quality.largestSkewness)},
            {"smallest_volume", valueOrNull(quality.smallestVolume)},
            {"non_positive_volumes", quality.nonPositiveVolumes.size()},
            {"negative_pyramids", quality.negativePyramids}};
}

OrderedJson cellsJson(const std::vector<Index>& cells) {
    return {{"count", cells.size()},
            {"first", cells.empty() ? OrderedJson(nullptr) : OrderedJson(cells.front())}};
}

template <class Value>
std::string valueText(const std::optional<Value>& value) {
    return value ? fmt::format("{:.4g}", value->value) : "none";
}

/// Returns a share of the way to a pose as text, rounded down, since no cell is inverted up to it.
std::string shareText(double share, int digits = 12) {
    const auto textOf = [&](double value) { return fmt::format("{:.{}g}", value, digits); };
    const std::string text = textOf(share);
    double rounded = 0;
    if (share <= 0 || !io::parseNumber(text, rounded) || rounded <= share) return text;
    // The text is at most half a unit of its last digit above the share.
    const double unit = std::pow(10, std::floor(std::log10(share)) + 1 - digits);
    return textOf(share - unit / 2);
}

}  // namespace

void addMeshOptions(CLI::App& command, MeshOptions& options) {
    const char* group = "Only for meshes of simulations";
    CLI::Option* none =
        command
            .add_flag("--no-inverted", options.noInverted,
                      "Of a mesh with cells: write nothing, with exit code 3, if a pose inverts a "
                      "cell")
            ->group(group);
    command
        .add_flag("--largest-step", options.largestStep,
                  "Of a mesh with cells: go only as far towards the pose as no cell is inverted. "
                  "Patches that "
                  "the pose breaks are broken by a share of it, too")
        ->group(group)
        ->excludes(none);
    addChoice<solve::Criterion>(
        command, "--criterion", options.criterion, solve::kCriterionWords,
        "The poses that these options accept: no cell is inverted anywhere (exact), or the volumes "
        "are positive, and OpenFOAM's checkMesh finds no further error (solver)")
        ->group(group);
}

io::ModelCells readCells(const io::Model& model, Stages& stages) {
    return stages.run("reading", [&] {
        stages.addBytes(0);  // The bytes of the file have been counted.
        return model.readCells();
    });
}

std::string countsText(std::span<const io::ElementCount> counts, Index secondOrder) {
    std::string text;
    for (const auto& [count, name] : counts)
        if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, name);
    if (secondOrder > 0) text += fmt::format("; {} of second order", secondOrder);
    return text;
}

OrderedJson toJson(std::span<const io::ElementCount> counts) {
    OrderedJson json = OrderedJson::object();
    for (const auto& [count, name] : counts) json[name] = count;
    return json;
}

MeshCheck::MeshCheck(const std::filesystem::path& path, const io::Model& model,
                     io::ModelCells cells, const std::filesystem::path& output,
                     std::size_t poseCount, Stages& stages)
    : path_(path),
      output_(output),
      isOpenFoam_(cells.isOpenFoam),
      unchecked_(io::uncheckedElements(cells)) {
    if (cells.cellCount() == 0) return;
    stages.run("checking cells", [&] {
        const bool isAnimation = io::isAnimation(output, poseCount);
        const auto stored = [&model, output, isAnimation](std::vector<Point3> points) {
            return isAnimation ? io::storedInAnimation(output, model, std::move(points))
                               : model.stored(std::move(points));
        };
        check_ = ofFile(path, [&] {
            return solve::MeshCheck(std::move(cells), model.positions(), {isOpenFoam_, stored});
        });
    });
}

solve::MeshVerdict MeshCheck::check(std::vector<Point3>& points, const std::string& poseName,
                                    const MeshOptions& options, Stages& stages) const {
    if (!hasCells()) return {};
    return stages.run("checking cells", [&] {
        const solve::MeshVerdict verdict = ofFile(poseName, [&] {
            return options.largestStep ? check_->shorten(points, options.criterion)
                                       : check_->check(points);
        });
        if (!verdict.isRestValid)
            throw FailedCheck(
                fmt::format("{}: rounded to the floats of this format, cells of {} are inside out "
                            "even at rest; "
                            "write the poses in the format of the mesh",
                            io::shownPath(output_), io::shownPath(path_)));
        return verdict;
    });
}

std::string MeshCheck::cellName() const {
    return check_->mesh().isSurface() ? "face" : "cell";
}

std::string MeshCheck::cellText(Index cell) const {
    return check_->mesh().cellText(cell);
}

std::string MeshCheck::solverName() const {
    return isOpenFoam_ ? "checkMesh" : "a solver";
}

std::string MeshCheck::patchText(const solve::PatchDeviation& deviation) const {
    const far::MeshPatch& patch = check_->mesh().patches[deviation.patch];
    const char* means = !deviation.isFromImage ? "leaves its plane"
                        : deviation.constraint == solve::Constraint::Plane
                            ? "is no longer the mirror image of the other wedge: it is off"
                        : deviation.constraint == solve::Constraint::Sides
                            ? "no longer has opposite points: they are apart"
                            : "is no longer the image of its partner: it is off";
    return fmt::format("the patch {}{} {} by {:.3g}, point {}", printable(patch.name),
                       patch.type.empty() ? "" : " (" + printable(patch.type) + ")", means,
                       deviation.distance, deviation.point);
}

void MeshCheck::requireValid(const solve::MeshVerdict& verdict, const std::string& pose,
                             const MeshOptions& options) const {
    if (check_->accepts(verdict, options.criterion)) return;
    for (const solve::PatchDeviation& deviation : verdict.patches)
        if (deviation.isBroken)
            throw FailedCheck(fmt::format("{}: in this pose, {} of {}; nothing was written",
                                          io::shownPath(pose), patchText(deviation),
                                          io::shownPath(path_)));
    if (options.criterion == solve::Criterion::Solver)
        throw FailedCheck(fmt::format(
            "{}: in this pose of {}, {} finds {} errors more than at rest; nothing was written. "
            "--largest-step goes {} of the way",
            io::shownPath(pose), io::shownPath(path_), solverName(),
            check_->solverErrors(verdict.whole), shareText(verdict.solverStep, 6)));
    const auto& inverted = verdict.validity.inverted;
    if (!inverted.empty())
        throw FailedCheck(fmt::format(
            "{0}: this pose turns {1} of {2} {3}s of {4} inside out, the first {3} "
            "{5}; nothing was "
            "written. --largest-step goes {6} of the way",
            io::shownPath(pose), inverted.size(), check_->mesh().cellCount(), cellName(),
            io::shownPath(path_), cellText(inverted.front()), shareText(verdict.step.length, 6)));
    const auto& before = check_->qualityAtRest().nonPositiveVolumes;
    const Index first = *std::ranges::find_if_not(
        verdict.whole.nonPositiveVolumes,
        [&](Index cell) { return std::ranges::binary_search(before, cell); });
    throw FailedCheck(
        fmt::format("{}: in this pose, cell {} of {} has no positive volume by OpenFOAM's "
                    "formula; nothing was "
                    "written",
                    io::shownPath(pose), cellText(first), io::shownPath(path_)));
}

void MeshCheck::warn(const solve::MeshVerdict& verdict, const std::string& pose) const {
    for (const solve::PatchDeviation& deviation : verdict.patches)
        if (deviation.isBroken)
            printError(fmt::format("warning: in {}, {}. --no-inverted refuses it",
                                   io::shownPath(pose), patchText(deviation))
                           .c_str());
    const auto& inverted = verdict.validity.inverted;
    if (inverted.empty() || verdict.written < 1) return;
    const std::string ofSolver = check_->solverErrors(verdict.whole) > 0
                                     ? fmt::format("--criterion solver as far as {} accepts it, {}",
                                                   solverName(), shareText(verdict.solverStep, 6))
                                     : fmt::format("{} accepts the whole pose", solverName());
    printError(
        fmt::format("warning: {0} turns {1} of {2} {3}s of the mesh inside out, the first {3} "
                    "{4}. --largest-step goes as far as no {3} is inverted, {5} of the way ({6}); "
                    "--no-inverted writes nothing",
                    io::shownPath(pose), inverted.size(), check_->mesh().cellCount(), cellName(),
                    cellText(inverted.front()), shareText(verdict.step.length, 6), ofSolver)
            .c_str());
}

std::string MeshCheck::text(const solve::MeshVerdict& verdict, const std::string& pose) const {
    std::string text;
    const auto line = [&]<class... Values>(fmt::format_string<Values...> format,
                                           Values&&... values) {
        fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
    };
    const solve::PoseValidity& validity = verdict.validity;
    const solve::LargestStep& step = verdict.step;
    line("mesh of {}\n", io::shownPath(pose));
    if (hasCells())
        line("  {:<17} {}\n", cellName() + "s",
             countsText(io::cellCounts(check_->mesh()), io::secondOrderCount(check_->mesh())));
    for (const auto& [count, name] : unchecked_) line("  not checked       {} {}\n", count, name);
    if (!hasCells()) return text;
    const std::string cell = cellName();
    if (const auto& bad = check_->badAtRest(); !bad.empty())
        line("  folded at rest    {}, the first {} {}; they do not count below\n", bad.size(), cell,
             cellText(bad.front()));
    if (validity.inverted.empty())
        line("  inverted          0\n");
    else
        line("  inverted          {}, the first {} {}\n", validity.inverted.size(), cell,
             cellText(validity.inverted.front()));
    Index kept = 0;
    for (const solve::PatchDeviation& deviation : verdict.patches) {
        kept += deviation.isBroken ? 0 : 1;
        if (deviation.isBroken) line("  broken            {}\n", patchText(deviation));
    }
    if (kept > 0)
        line("  constraints       {} of {} symmetry, wedge, empty and periodic patches are kept\n",
             kept, verdict.patches.size());
    for (const std::size_t patch : check_->patchesBrokenAtRest())
        line("  not checked       the patch {}, which breaks its constraint at rest\n",
             printable(check_->mesh().patches[patch].name));
    const char* measure = check_->mesh().isSurface() ? "area" : "volume";
    if (validity.smallest)
        line("  worst ratio       {:.3g} ({} in the pose : at rest), {} {}\n",
             validity.smallest->value, measure, cell, cellText(validity.smallest->cell));
    if (validity.comparesNeighbours) {
        line(
            "  compared          with neighbouring faces, since the mesh is no plane that stays "
            "one; "
            "steps are not proved\n");
        if (const Index isolated = check_->validity().isolatedFaces(); isolated > 0)
            line("  not checked       {} faces that share no point with others\n", isolated);
    }
    if (step.limitingCell)
        line("  largest step      {}{} of the pose inverts no {}; then {} {} {}\n",
             step.isTight || validity.comparesNeighbours ? "" : "at least ", shareText(step.length),
             cell, cell, cellText(*step.limitingCell),
             step.isTight || validity.comparesNeighbours ? "folds" : "may fold");
    else if (validity.comparesNeighbours)
        line("  largest step      1: the whole pose inverts no {}\n", cell);
    else
        line("  largest step      1: no share of the pose inverts a {}\n", cell);
    if (const Index errors = check_->solverErrors(verdict.whole); errors > 0)
        line("  for {:<13} {} errors; {} of the pose has none\n", solverName(), errors,
             shareText(verdict.solverStep, 3));
    else if (!validity.inverted.empty())
        line("  for {:<13} 0 errors in the whole pose\n", solverName());
    if (verdict.written < 1)
        line("  written           {} of the pose\n", shareText(verdict.written));
    line("  quality                before      after\n");
    const auto row = [&line](const char* name, const std::string& before, const std::string& now,
                             const char* meaning) {
        line("    {:<19} {:>9}  {:>9}  {}\n", name, before, now, meaning);
    };
    const solve::MeshQuality &before = check_->qualityAtRest(), &after = verdict.quality;
    row("scaled Jacobian", valueText(before.smallestScaledJacobian),
        valueText(after.smallestScaledJacobian), "at least");
    if (check_->mesh().isSurface()) {
        row("areas not above 0", std::to_string(before.nonPositiveVolumes.size()),
            std::to_string(after.nonPositiveVolumes.size()), "faces");
        return text;
    }
    row("non-orthogonality", valueText(before.largestNonOrthogonality),
        valueText(after.largestNonOrthogonality), "degrees at most");
    row("  its mean", fmt::format("{:.4g}", before.meanNonOrthogonality),
        fmt::format("{:.4g}", after.meanNonOrthogonality), "degrees");
    row("skewness", valueText(before.largestSkewness), valueText(after.largestSkewness), "at most");
    row("volumes not above 0", std::to_string(before.nonPositiveVolumes.size()),
        std::to_string(after.nonPositiveVolumes.size()), "cells, by OpenFOAM's formula");
    row("pyramids below 0", std::to_string(before.negativePyramids),
        std::to_string(after.negativePyramids), "sides of faces, as checkMesh counts them");
    return text;
}

OrderedJson MeshCheck::toJson(const solve::MeshVerdict& verdict, const std::string& pose) const {
    const far::SimulationMesh none, &mesh = hasCells() ? check_->mesh() : none;
    OrderedJson json = {{"pose", pose},
                        {"cells", cli::toJson(io::cellCounts(mesh))},
                        {"second_order", io::secondOrderCount(mesh)},
                        {"not_checked", cli::toJson(unchecked_)}};
    if (!hasCells()) return json;
    for (const far::MeshPart& part : mesh.parts)
        json["parts"].push_back({{"name", part.name}, {"first_cell", part.firstCell}});
    OrderedJson patches = OrderedJson::array(), broken = OrderedJson::array();
    for (const solve::PatchDeviation& deviation : verdict.patches)
        patches.push_back({{"name", mesh.patches[deviation.patch].name},
                           {"type", mesh.patches[deviation.patch].type},
                           {"distance", deviation.distance},
                           {"point", deviation.point},
                           {"broken", deviation.isBroken}});
    for (const std::size_t patch : check_->patchesBrokenAtRest())
        broken.push_back(mesh.patches[patch].name);
    json["patches"] = std::move(patches);
    json["patches_not_checked"] = std::move(broken);
    const auto& smallest = verdict.validity.smallest;
    const auto& limiting = verdict.step.limitingCell;
    json.update(OrderedJson{
        {"bad_at_rest", cellsJson(check_->badAtRest())},
        {"inverted", cellsJson(verdict.validity.inverted)},
        {"smallest_ratio",
         smallest ? OrderedJson{{"cell", smallest->cell}, {"volume_ratio", smallest->value}}
                  : OrderedJson(nullptr)},
        {"largest_step",
         {{"length", verdict.step.length},
          {"limiting_cell", limiting ? OrderedJson(*limiting) : OrderedJson(nullptr)},
          {"is_tight", verdict.step.isTight}}},
        {"solver",
         {{"errors", check_->solverErrors(verdict.whole)}, {"largest_step", verdict.solverStep}}},
        {"written", verdict.written},
        {"quality",
         {{"before", qualityJson(check_->qualityAtRest())},
          {"after", qualityJson(verdict.quality)}}}});
    return json;
}

}  // namespace espalier::cli
