// SPDX-License-Identifier: Apache-2.0
#include "bind_model.h"

#include <espalier/far/error.h>
#include <espalier/io/file.h>
#include <espalier/stencils/composition.h>

#include <functional>
#include <map>
#include <optional>

#include "byte_counts.h"
#include "choice.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

using Binding = stencils::Binding<double>;
using stencils::PointStatus;

const std::map<std::string, Basis> kBasisWords = {
    {"subdivision", Basis::Subdivision}, {"bezier", Basis::Bezier}, {"bspline", Basis::BSpline}};

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
BoundPoints bindToSubdivision(const BindOptions& options, std::span<const Point3> points,
                              const Lattice& lattice, Stages& stages) {
    const auto refiner = stages.run("refining", [&] {
        auto refined = refineLattice(options.rest, lattice, options.common, options.level);
        stages.addBytes(bytesOf(refined));
        return refined;
    });
    const auto embedding = stages.run("embedding", [&] {
        const auto positions = stencils::refinePositions(refiner, options.level,
                                                         options.common.rules, lattice.positions);
        auto placed =
            stencils::embedPoints(refiner.level(options.level).complex, positions, points,
                                  options.common.embedding, progressOf(stages, points.size()));
        stages.addBytes(bytesOf(placed));
        return placed;
    });
    Binding binding = stages.run("building stencils", [&] {
        auto made = stencils::makeBinding<double>(refiner, options.level, options.common.rules,
                                                  embedding, points);
        stages.addBytes(bytesOf(made.table));
        return made;
    });
    return {std::move(binding), reportOf(embedding)};
}

stencils::TensorLattice tensorLattice(const BindOptions& options, const Lattice& lattice) {
    try {
        return {
            lattice.complex, lattice.positions,
            options.basis == Basis::Bezier ? stencils::Basis::Bezier : stencils::Basis::BSpline};
    } catch (const Error& error) {
        throw io::FileError(options.rest, error.what());
    }
}

/// The same for the lattices of the paper's section 1.
BoundPoints bindToTensorProduct(const BindOptions& options, std::span<const Point3> points,
                                const Lattice& lattice, Stages& stages) {
    // To go on without them would be another deformation than the file asks for.
    if (!lattice.marks.empty())
        throw io::FileError(options.rest, "has marks, which only --basis subdivision heeds");
    std::optional<stencils::TensorLattice> tensor;
    const auto embedding = stages.run("embedding", [&] {
        tensor = tensorLattice(options, lattice);
        auto placed = stencils::embedPoints(*tensor, points, options.common.embedding,
                                            progressOf(stages, points.size()));
        stages.addBytes(bytesOf(placed));
        return placed;
    });
    Binding binding = stages.run("building stencils", [&] {
        auto made = stencils::makeBinding<double>(*tensor, embedding, points);
        stages.addBytes(bytesOf(made.table));
        return made;
    });
    return {std::move(binding), reportOf(embedding)};
}

}  // namespace

void addModelAndRest(CLI::App& command, BindOptions& options) {
    command.add_option("MODEL", options.model, "The model: .obj, .ply, .stl or .vtu")->required();
    command
        .add_option("--rest", options.rest,
                    "The lattice as it lies around the model: .ovm, .vtu or .vtk")
        ->required();
}

void addBindingOptions(CLI::App& command, BindOptions& options) {
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
                       const Lattice& lattice, Stages& stages) {
    const auto bind = options.basis == Basis::Subdivision ? bindToSubdivision : bindToTensorProduct;
    return bind(options, points, lattice, stages);
}

}  // namespace espalier::cli
