// SPDX-License-Identifier: Apache-2.0
#include "kept_patches.h"

#include <espalier/base/printable.h>
#include <espalier/base/vector3.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model_part.h>
#include <espalier/osd/binding_evaluator.h>
#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "files.h"

namespace espalier::cli {
namespace {

/// Returns "plane", or "4 planes, 2 cylinders".
std::string textOf(const std::vector<solve::SlideShape>& shapes) {
    std::map<std::string_view, int> counts;
    for (const solve::SlideShape& shape : shapes) ++counts[solve::nameOf(shape.kind)];
    if (shapes.size() == 1) return std::string(counts.begin()->first);
    std::string text;
    for (const auto& [name, count] : counts)
        text +=
            fmt::format("{}{} {}{}", text.empty() ? "" : ", ", count, name, count == 1 ? "" : "s");
    return text;
}

std::string lineOf(const char* label, Index count, const std::string& patches, const char* does,
                   const solve::SlidingPoints::Correction& largest) {
    std::string text =
        fmt::format("{:<17} {} {} of {}", label, count, count == 1 ? "point" : "points", patches);
    if (largest.point)
        text += fmt::format("; the poses would {} by up to {:.3g} (point {})", does,
                            largest.distance, *largest.point);
    return text + "\n";
}

OrderedJson pointOrNull(const std::optional<Index>& point) {
    return point ? OrderedJson(*point) : OrderedJson(nullptr);
}

}  // namespace

void addSlideOption(CLI::App& command, std::vector<std::string>& patches) {
    command
        .add_option("--slide", patches,
                    "Keep the points of these patches, markers or groups of MODEL in their planes, "
                    "cylinders, lines or circles. Of a patch with edges, such as the four walls of "
                    "a channel, each side. espalier info lists the names")
        ->allow_extra_args(false)
        ->type_name("NAME");
}

KeptPatches::KeptPatches(const std::string& path, const io::Model& model,
                         const std::vector<std::string>& slides, Stages& stages)
    : path_(path) {
    if (slides.empty()) return;
    stages.run("sliding", [&] {
        std::vector<far::MeshPatch> patches;
        for (const std::string& name : slides) patches.push_back(io::patchOf(path, model, name));
        ofFile(path, [&] { sliding_.emplace(patches, model.positions()); });
    });
}

void KeptPatches::measureHeld(const BindOptions& options, const io::Model& model,
                              const Lattice& lattice, Stages& stages) {
    if (options.part.holds.empty()) return;
    holds_ = options.part.holds;
    heldCount_ = static_cast<Index>(io::heldPointsOf(options.model, model, options.part).size());
    held_ = bindHeldPoints(options, model, lattice, stages);
}

void KeptPatches::keep(std::vector<Point3>& points, const std::vector<Point3>& pose) {
    if (sliding_) {
        const auto correction = ofFile(path_, [&] { return sliding_->slide(points); });
        if (correction.distance > largestSlid_.distance) largestSlid_ = correction;
    }
    if (!held_) return;
    const std::vector<Point3> moved = osd::evaluateBinding(*held_, pose);
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const double distance = length(difference(moved[i], held_->points[i]));
        if (distance > largestHeld_.distance) largestHeld_ = {distance, static_cast<Index>(i)};
    }
}

void KeptPatches::requireStraight() const {
    if (!sliding_) return;
    const auto curved = sliding_->curvedPatch();
    if (!curved) return;
    throw io::FileError(
        path_, fmt::format("the patch {} is curved, and points on the straight way to a pose leave "
                           "it: --largest-step works with --slide of planes and lines. Give "
                           "--no-inverted instead, or a smaller pose",
                           inQuotes(sliding_->patches()[*curved].name)));
}

std::string KeptPatches::text() const {
    std::string text;
    if (held_) {
        std::string names;
        for (const std::string& name : holds_)
            names += (names.empty() ? "" : ", ") + printable(name);
        text += lineOf("held", heldCount_, names, "move them", largestHeld_);
    }
    if (sliding_) {
        std::string names;
        for (const auto& patch : sliding_->patches())
            names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", printable(patch.name),
                                 textOf(patch.shapes));
        text += lineOf("slid", sliding_->pointCount(), names, "take them off", largestSlid_);
    }
    return text;
}

void KeptPatches::addTo(OrderedJson& json) const {
    if (held_)
        json["held"] = {{"points", heldCount_},
                        {"patches", holds_},
                        {"largest_move", largestHeld_.distance},
                        {"point", pointOrNull(largestHeld_.point)}};
    if (!sliding_) return;
    OrderedJson patches = OrderedJson::array();
    for (const auto& patch : sliding_->patches()) {
        OrderedJson shapes = OrderedJson::array();
        for (const solve::SlideShape& shape : patch.shapes)
            shapes.push_back(solve::nameOf(shape.kind));
        patches.push_back({{"name", patch.name}, {"shapes", std::move(shapes)}});
    }
    json["slid"] = {{"points", sliding_->pointCount()},
                    {"patches", std::move(patches)},
                    {"largest_move", largestSlid_.distance},
                    {"point", pointOrNull(largestSlid_.point)}};
}

}  // namespace espalier::cli
