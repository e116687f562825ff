// SPDX-License-Identifier: Apache-2.0
#include "mesh_check.h"

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

constexpr std::array<const char*, 5> kKindNames = {"tetrahedra", "pyramids", "wedges", "hexahedra",
                                                   "polyhedra"};

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

/// Returns the point at a share of the way from rest to a pose.
std::vector<Point3> between(std::span<const Point3> rest, std::span<const Point3> pose,
                            double share) {
    std::vector<Point3> points(rest.begin(), rest.end());
    for (std::size_t point = 0; point < points.size(); ++point)
        for (std::size_t c = 0; c < 3; ++c)
            points[point][c] += share * (pose[point][c] - points[point][c]);
    return points;
}

}  // namespace

void addMeshOptions(CLI::App& command, MeshOptions& options) {
    CLI::Option* none =
        command
            .add_flag("--no-inverted", options.noInverted,
                      "Of a mesh with cells: write nothing, with exit code 3, if a pose inverts a "
                      "cell")
            ->group("Only for meshes of volumes");
    command
        .add_flag("--largest-step", options.largestStep,
                  "Of a mesh with cells: go only as far towards the pose as no cell is inverted")
        ->group("Only for meshes of volumes")
        ->excludes(none);
}

io::ModelVolume readVolume(const io::Model& model, Stages& stages) {
    return stages.run("reading", [&] {
        stages.addBytes(0);  // The bytes of the file have been counted.
        return model.readVolume();
    });
}

MeshCheck::MeshCheck(const std::filesystem::path& path, const io::Model& model,
                     io::ModelVolume volume, const std::filesystem::path& output,
                     std::size_t poseCount, Stages& stages)
    : path_(path),
      output_(output),
      isAnimation_(io::isAnimation(output, poseCount)),
      model_(model),
      volume_(std::move(volume)) {
    if (!hasCells()) return;
    stages.run("checking cells", [&] {
        const far::VolumeMesh& mesh = volume_.mesh;
        for (Index cell = 0; cell < mesh.cellCount(); ++cell) {
            const auto kind = mesh.kind(cell);
            ++kinds_[kind ? static_cast<std::size_t>(*kind) : 4];
        }
        check_ = ofFile(path, [&] { return solve::ValidityCheck(mesh, model.positions()); });
        before_ = solve::meshQuality(mesh, model.positions());
    });
}

bool MeshCheck::isSound(const solve::PoseValidity& validity,
                        const solve::MeshQuality& quality) const {
    // OpenFOAM computes new centres of faces in the pose. With these centres, a polyhedron with
    // bent faces may have no positive volume, although each of its tetrahedra in `validity` is
    // valid.
    return validity.inverted.empty() &&
           std::ranges::includes(before_.nonPositiveVolumes, quality.nonPositiveVolumes);
}

std::vector<Point3> MeshCheck::stored(std::vector<Point3> points) const {
    return isAnimation_ ? io::storedInAnimation(output_, model_, std::move(points))
                        : model_.stored(std::move(points));
}

MeshVerdict MeshCheck::check(std::vector<Point3>& points, const std::string& poseName,
                             const MeshOptions& options, Stages& stages) const {
    if (!hasCells()) return {};
    return stages.run("checking cells", [&] {
        MeshVerdict verdict;
        const std::vector<Point3> pose = stored(points);
        verdict.validity = ofFile(poseName, [&] { return check_->check(pose); });
        verdict.step = check_->largestStep(pose);
        verdict.quality = solve::meshQuality(volume_.mesh, pose);
        if (!options.largestStep) return verdict;
        // The step is proved for exact points. Rounding to the numbers of the file can make it
        // shorter; then it is shortened by ever larger parts.
        verdict.written = verdict.step.length;
        solve::PoseValidity validity = verdict.validity;
        for (double shorten = 0x1p-40; verdict.written > 0; shorten *= 2) {
            points = verdict.written == 1
                         ? pose
                         : stored(between(model_.positions(), pose, verdict.written));
            if (verdict.written < 1) {
                validity = check_->check(points);
                verdict.quality = solve::meshQuality(volume_.mesh, points);
            }
            if (isSound(validity, verdict.quality)) return verdict;
            verdict.written = std::max(0.0, verdict.step.length * (1 - shorten));
        }
        points = stored({model_.positions().begin(), model_.positions().end()});
        verdict.quality = solve::meshQuality(volume_.mesh, points);
        if (!isSound(check_->check(points), verdict.quality))
            throw FailedCheck(
                fmt::format("{}: rounded to the floats of this format, cells of {} are inside out "
                            "even at rest; "
                            "write the poses in the format of the mesh",
                            io::shownPath(output_), io::shownPath(path_)));
        return verdict;
    });
}

void MeshCheck::requireValid(const MeshVerdict& verdict, const std::string& pose) const {
    const auto firstOf = [&](const std::vector<Index>& now) {
        const auto& before = before_.nonPositiveVolumes;
        return *std::ranges::find_if_not(
            now, [&](Index cell) { return std::ranges::binary_search(before, cell); });
    };
    const auto& inverted = verdict.validity.inverted;
    if (!inverted.empty())
        throw FailedCheck(fmt::format(
            "{}: this pose turns {} of {} cells of {} inside out, the first cell {}; nothing was "
            "written. --largest-step goes {} of the way",
            io::shownPath(pose), inverted.size(), volume_.mesh.cellCount(), io::shownPath(path_),
            inverted.front(), shareText(verdict.step.length, 6)));
    if (!isSound(verdict.validity, verdict.quality))
        throw FailedCheck(
            fmt::format("{}: in this pose, cell {} of {} has no positive volume by OpenFOAM's "
                        "formula; nothing was "
                        "written",
                        io::shownPath(pose), firstOf(verdict.quality.nonPositiveVolumes),
                        io::shownPath(path_)));
}

void MeshCheck::warn(const MeshVerdict& verdict, const std::string& pose) const {
    const auto& inverted = verdict.validity.inverted;
    if (inverted.empty() || verdict.written < 1) return;
    printError(
        fmt::format("warning: {} turns {} of {} cells of the mesh inside out, the first cell "
                    "{}. --largest-step goes as far as no cell is inverted, {} of the "
                    "way; --no-inverted writes nothing",
                    io::shownPath(pose), inverted.size(), volume_.mesh.cellCount(),
                    inverted.front(), shareText(verdict.step.length, 6))
            .c_str());
}

std::string MeshCheck::kindsText() const {
    std::string text;
    for (std::size_t kind = 0; kind < kinds_.size(); ++kind)
        if (kinds_[kind] > 0)
            text +=
                fmt::format("{}{} {}", text.empty() ? "" : ", ", kinds_[kind], kKindNames[kind]);
    return text;
}

std::string MeshCheck::text(const MeshVerdict& verdict, const std::string& pose) const {
    std::string text;
    const auto line = [&]<class... Values>(fmt::format_string<Values...> format,
                                           Values&&... values) {
        fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
    };
    const auto& [validity, step, after, written] = verdict;
    line("mesh of {}\n", io::shownPath(pose));
    if (hasCells()) line("  cells             {}\n", kindsText());
    if (volume_.curvedCells > 0)
        line("  not checked       {} cells with curved edges\n", volume_.curvedCells);
    if (volume_.unknownElements > 0)
        line("  not checked       {} elements of unknown types\n", volume_.unknownElements);
    if (!hasCells()) return text;
    if (const auto& bad = check_->badAtRest(); !bad.empty())
        line("  folded at rest    {}, the first cell {}; they do not count below\n", bad.size(),
             bad.front());
    if (validity.inverted.empty())
        line("  inverted          0\n");
    else
        line("  inverted          {}, the first cell {}\n", validity.inverted.size(),
             validity.inverted.front());
    if (validity.smallest)
        line("  worst ratio       {:.3g} (volume in the pose : at rest), cell {}\n",
             validity.smallest->value, validity.smallest->cell);
    if (step.limitingCell)
        line("  largest step      {}{} of the pose inverts no cell; then cell {} {}\n",
             step.isTight ? "" : "at least ", shareText(step.length), *step.limitingCell,
             step.isTight ? "folds" : "may fold");
    else
        line("  largest step      1: no share of the pose inverts a cell\n");
    if (written < 1) line("  written           {} of the pose\n", shareText(written));
    line("  quality               before      after\n");
    const auto row = [&line](const char* name, const std::string& before, const std::string& now,
                             const char* meaning) {
        line("    {:<18} {:>9}  {:>9}  {}\n", name, before, now, meaning);
    };
    row("scaled Jacobian", valueText(before_.smallestScaledJacobian),
        valueText(after.smallestScaledJacobian), "at least");
    row("non-orthogonality", valueText(before_.largestNonOrthogonality),
        valueText(after.largestNonOrthogonality), "degrees at most");
    row("  its mean", fmt::format("{:.4g}", before_.meanNonOrthogonality),
        fmt::format("{:.4g}", after.meanNonOrthogonality), "degrees");
    row("skewness", valueText(before_.largestSkewness), valueText(after.largestSkewness),
        "at most");
    row("volumes below 0", std::to_string(before_.nonPositiveVolumes.size()),
        std::to_string(after.nonPositiveVolumes.size()), "cells, by OpenFOAM's formula");
    row("pyramids below 0", std::to_string(before_.negativePyramids),
        std::to_string(after.negativePyramids), "sides of faces, as checkMesh counts them");
    return text;
}

OrderedJson MeshCheck::toJson(const MeshVerdict& verdict, const std::string& pose) const {
    OrderedJson cells = OrderedJson::object();
    for (std::size_t kind = 0; kind < kinds_.size(); ++kind) cells[kKindNames[kind]] = kinds_[kind];
    OrderedJson json = {{"pose", pose},
                        {"cells", cells},
                        {"curved_cells", volume_.curvedCells},
                        {"unknown_elements", volume_.unknownElements}};
    if (!hasCells()) return json;
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
        {"written", verdict.written},
        {"quality", {{"before", qualityJson(before_)}, {"after", qualityJson(verdict.quality)}}}});
    return json;
}

}  // namespace espalier::cli
