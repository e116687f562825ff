// SPDX-License-Identifier: Apache-2.0
#include "posing.h"

#include <espalier/base/printable.h>
#include <espalier/io/displacements.h>
#include <espalier/shapes/cell_selection.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/limb.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "options.h"

namespace espalier::cli {

void Posing::select(std::optional<Selection> selection) {
    if (selection && selection->part) {
        const shapes::Limb limb = selection->part(lattice_);
        const auto& [x, y, z] = limb.section.center;
        found_.push_back(fmt::format(
            "{}: {} of {} vertices, beyond a section of area {:.4g} at {:.4g} {:.4g} {:.4g}",
            printable(selection->text), limb.vertices.size(), lattice_.positions.size(),
            limb.section.area, x, y, z));
        selectVertices(*selection, limb.vertices);
    } else if (selection && selection->change) {
        if (!selection_)
            throw CLI::ValidationError(
                kSelect, printable(selection->text) +
                             ": the whole lattice is selected; give another --select before it");
        selectVertices(*selection, selection->change(lattice_, selectedVertices()));
    }
    selection_ = std::move(selection);
    falloff_ = {};
    center.reset();
    pivot.reset();
    range.reset();
    toward.reset();
    if (selection_) checkCount();
}

void Posing::setFalloff(const shapes::Falloff& falloff) {
    constexpr const char* kOption = "--falloff";
    if (!(falloff.radius > 0))
        throw CLI::ValidationError(
            kOption, fmt::format("expected a radius above 0, got {}", falloff.radius));
    if (!selection_)
        throw CLI::ValidationError(kOption,
                                   "the whole lattice is selected; give --select before --falloff");
    if (!selection_->takesFalloff)
        throw CLI::ValidationError(
            kOption, "the values of an attribute are the weights already, without falloff");
    falloff_ = falloff;
}

void Posing::displace(const std::string& path) {
    const auto displacements =
        io::readDisplacements(path, static_cast<Index>(lattice_.positions.size()));
    operate([&](const auto& positions, const shapes::pose::Options& options) {
        return shapes::pose::displace(positions, displacements, options.weights);
    });
}

void Posing::mirror(const MirrorPlane& at) {
    operate([&](const auto& positions, const shapes::pose::Options& options) {
        shapes::pose::Mirrored result =
            shapes::pose::mirror(lattice_.positions, positions, at.axis, options.weights, at.place);
        const std::string without =
            result.withoutImage == 0
                ? ""
                : fmt::format("; {} without a mirror image {}", result.withoutImage,
                              result.withoutImage == 1 ? "stays" : "stay");
        found_.push_back(fmt::format("mirror: {} of {} selected vertices at {} = {:.4g}{}",
                                     result.withImage, result.withImage + result.withoutImage,
                                     "xyz"[at.axis], result.plane, without));
        return std::move(result.positions);
    });
}

void Posing::selectVertices(Selection& selection, std::vector<Index> vertices) {
    selection.weights = [vertices = std::move(vertices)](const Lattice& lattice,
                                                         const shapes::Falloff& falloff) {
        return shapes::selectAlongCells(lattice.complex, lattice.positions, vertices, falloff);
    };
}

std::vector<Index> Posing::selectedVertices() const {
    std::vector<Index> vertices;
    const auto selected = selection_->weights(lattice_, {});
    for (std::size_t v = 0; v < selected.size(); ++v)
        if (selected[v] > 0) vertices.push_back(static_cast<Index>(v));
    return vertices;
}

void Posing::checkCount() {
    const auto count = selectedVertices().size();
    if (count == 0)
        throw CLI::ValidationError(
            kSelect,
            fmt::format("{}: expected at least one vertex there; the lattice has none. {}",
                        printable(selection_->text),
                        selection_->change ? "Give fewer steps"
                                           : "Give a larger region, such as a radius of 10%, "
                                             "or grow another selection"));
    constexpr std::size_t kFew = 2;
    if (count <= kFew && !selection_->isExplicit)
        notes_.push_back(fmt::format(
            "note: --select {} selects {} of {} vertices; a larger region, or "
            "--select grow 1 after it, selects more",
            printable(selection_->text), count == 1 ? "one" : "two", lattice_.positions.size()));
}

Point3 Posing::pivotPoint() const {
    if (pivot->kind == Pivot::Kind::Point) return pivot->point;
    if (pivot->kind == Pivot::Kind::Vertex) {
        if (pivot->vertex >= std::ssize(positions_))
            throw CLI::ValidationError(
                "--about",
                fmt::format("vertex {}: expected 0 to {}", pivot->vertex, positions_.size() - 1));
        return positions_[pivot->vertex];
    }
    if (pivot->kind == Pivot::Kind::Joint) {
        const Index face =
            shapes::nearestInnerFace(lattice_.complex, lattice_.positions, pivot->point);
        const auto part = shapes::selectBeyond(lattice_.complex, lattice_.positions, face).vertices;
        return shapes::selectionBorder(lattice_.complex, positions_, part).center;
    }
    if (!selection_)
        throw CLI::ValidationError("--about",
                                   "border: the whole lattice is selected, and has no border; "
                                   "give --select before it");
    return shapes::selectionBorder(lattice_.complex, positions_, selectedVertices()).center;
}

std::vector<double> Posing::weights() const {
    if (movesHeld_)
        return selection_ ? selection_->weights(lattice_, falloff_) : std::vector<double>();
    auto weights = selection_
                       ? shapes::weightsWithHeld(lattice_, selection_->weights(lattice_, falloff_))
                       : shapes::weightsWithHeld(lattice_);
    if (std::ranges::none_of(weights, [](double w) { return w > 0; }))
        throw CLI::ValidationError(
            kSelect,
            "all selected vertices are held, as the lattice says; select others, or give "
            "--move-held");
    return weights;
}

}  // namespace espalier::cli
