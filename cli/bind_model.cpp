// SPDX-License-Identifier: Apache-2.0
#include "bind_model.h"

#include <espalier/base/error.h>
#include <espalier/embed/local_binding.h>
#include <espalier/io/files/file.h>
#include <espalier/limit/limit_binding.h>

#include <functional>
#include <map>
#include <utility>

#include "byte_counts.h"
#include "choice.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

using Binding = embed::Binding;
using embed::PointStatus;

const std::map<std::string, Basis> kBasisWords = {
    {"subdivision", Basis::Subdivision}, {"bezier", Basis::Bezier}, {"bspline", Basis::BSpline}};

/// Of an embedding or of a bound model.
template <class Found>
BindingReport reportOf(const Found& found, double largestResidual) {
    return {found.count(PointStatus::Inside), found.count(PointStatus::Outside),
            found.count(PointStatus::NotConverged), largestResidual};
}

/// Shows how far the stage is that embeds so many points.
std::function<void(Offset)> progressOf(Stages& stages, std::size_t pointCount) {
    return [&stages, pointCount](Offset done) { stages.showProgress(done, pointCount); };
}

/// MacCracken & Joy 1996, section 5.
/// \param bind embed::bindPoints(), or bindFactored()
template <class Bind>
auto refineAndBind(Bind bind, const BindOptions& options, std::span<const Point3> points,
                   const Lattice& lattice, Stages& stages) {
    const auto base = refineLattice(options.rest, lattice, options.common, 0);
    return bind(base, lattice.positions, options.level, options.common.rules, points,
                options.common.embedding, progressOf(stages, points.size()));
}

BoundPoints bindToSubdivision(const BindOptions& options, std::span<const Point3> points,
                              const Lattice& lattice, Stages& stages) {
    auto bound = refineAndBind(embed::bindPoints, options, points, lattice, stages);
    const BindingReport report = reportOf(bound, bound.largestResidual);
    return {std::move(bound.binding), report, std::move(bound.statuses)};
}

BoundPoints bindToLimit(const BindOptions& options, std::span<const Point3> points,
                        const Lattice& lattice, Gradients gradients, Stages& stages) {
    const auto base = refineLattice(options.rest, lattice, options.common, 0);
    auto bound = limit::bindLimit(base, lattice.positions, options.common.rules, points,
                                  {.embedding = options.common.embedding,
                                   .tolerance = options.common.embedding.tolerance,
                                   .gradients = gradients == Gradients::OfLimit},
                                  progressOf(stages, points.size()));
    const BindingReport report = reportOf(bound, bound.largestResidual);
    auto gradientTables = std::move(bound.binding.table.gradients);
    return {limit::withoutGradients(std::move(bound.binding)), report, std::move(bound.statuses),
            std::move(gradientTables)};
}

embed::TensorLattice tensorLattice(const BindOptions& options, const Lattice& lattice) {
    return ofFile(options.rest, [&] {
        return embed::TensorLattice(
            lattice.complex, lattice.positions,
            options.basis == Basis::Bezier ? embed::Basis::Bezier : embed::Basis::BSpline);
    });
}

/// The same for the lattices of the paper's section 1.
BoundPoints bindToTensorProduct(const BindOptions& options, std::span<const Point3> points,
                                const Lattice& lattice, Stages& stages) {
    // To go on without them would be another deformation than the file asks for.
    if (!lattice.marks.empty())
        throw io::FileError(options.rest, "has marks, which only --basis subdivision heeds");
    const embed::TensorLattice tensor = tensorLattice(options, lattice);
    const auto embedding = embed::embedPoints(tensor, points, options.common.embedding,
                                              progressOf(stages, points.size()));
    std::vector<PointStatus> statuses;
    statuses.reserve(embedding.points.size());
    for (const auto& point : embedding.points) statuses.push_back(point.status);
    return {embed::makeBinding(tensor, embedding, points),
            reportOf(embedding, embedding.largestResidual()), std::move(statuses)};
}

}  // namespace

void addModelAndRest(CLI::App& command, BindOptions& options) {
    command.add_option("MODEL", options.model, "The model: .obj, .ply, .stl or .vtu")->required();
    command
        .add_option("--rest", options.rest,
                    "The lattice as it lies around the model: .ovm, .vtu or .vtk")
        ->required();
}

void addBasisOptions(CLI::App& command, BindOptions& options) {
    addChoice<Basis>(command, "--basis", options.basis, kBasisWords,
                     "What weighs the lattice: its subdivision; or, of a box that lies on a "
                     "parallelepiped, Bernstein polynomials or cubic B-splines");
    command
        .add_flag(
            "--limit", options.limit,
            "Bind to the volume that refining goes to, not to a level on the way; --tolerance "
            "also says how close. Normals and tangents then go with the points")
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
        option->group("With --basis subdivision only");
    addEmbeddingOptions(command, options.common);
}

void checkBasis(const BindOptions& options) {
    if (options.basis == Basis::Subdivision) return;
    for (const CLI::Option* option : options.ofSubdivision)
        if (option->count() > 0)
            throw CLI::ValidationError(option->get_name(),
                                       "is of use with --basis subdivision only");
}

BoundPoints bindPoints(const BindOptions& options, std::span<const Point3> points,
                       const Lattice& lattice, Stages& stages, Gradients gradients) {
    return stages.run("binding", [&] {
        BoundPoints bound = options.basis != Basis::Subdivision
                                ? bindToTensorProduct(options, points, lattice, stages)
                            : options.limit
                                ? bindToLimit(options, points, lattice, gradients, stages)
                                : bindToSubdivision(options, points, lattice, stages);
        stages.addBytes(bytesOf(bound.binding.table));
        return bound;
    });
}

std::optional<stencils::FactoredTable<double>> bindInFactors(const BindOptions& options,
                                                             std::span<const Point3> points,
                                                             const Lattice& lattice,
                                                             Stages& stages) {
    if (options.basis != Basis::Subdivision || options.limit) return std::nullopt;
    return stages.run("binding in factors", [&] {
        auto bound = refineAndBind(embed::bindFactored, options, points, lattice, stages);
        stages.addBytes(bytesOf(bound.binding.table));
        return std::move(bound.binding.table);
    });
}

}  // namespace espalier::cli
