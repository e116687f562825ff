// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/cages/cage.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "collar_options.h"
#include "commands.h"
#include "files.h"
#include "job.h"
#include "options.h"

namespace espalier::cli {
namespace {

struct CageCommandOptions {
    CommonOptions common;
    std::vector<std::string> models;
    cages::CageOptions cage;
    CollarCommandOptions collar;
    std::string output;
};

void runCage(const CageCommandOptions& options) {
    Job job(options.common,
            {{"MODEL", options.models}, {"--until-model", options.collar.untilModel}});
    job.writesLattice(options.output);
    Stages& stages = job.stages();
    std::vector<Point3> points;
    io::ModelFaces faces;
    for (const std::string& path : options.models) {
        const auto model = readModel(path, options.common, stages);
        io::ModelFaces own = model->readSurface().faces;
        // The mesh of a volume may have cells only.
        if (own.count() == 0) own = io::boundaryFaces(model->readCells().volume);
        if (own.count() == 0)
            throw io::FileError(path,
                                "has no faces, so that it bounds no solid; make a box around "
                                "its points: espalier shape around");
        faces.append(own, static_cast<Index>(points.size()));
        points.insert(points.end(), model->positions().begin(), model->positions().end());
    }
    cages::ModelSymmetry symmetry;
    WithCollar made = ofFile(options.models.front(), [&] {
        Lattice cage = stages.run("building", [&] {
            return cages::cage({points, faces.corners, faces.ends}, options.cage, &symmetry);
        });
        return withCollar(std::move(cage), options.collar, stages);
    });
    if (const std::string text = cages::symmetryText(symmetry); !text.empty())
        made.facts.push_back(text);
    writeWithCollar(options.output, made, options.common, stages);
}

}  // namespace

void addCageCommand(CLI::App& shape) {
    const auto [command, options] =
        addCommand(shape, "cage",
                   "A lattice of hexahedra that follows the shape of one or more models", runCage);
    command
        .add_option("MODEL", options.models, "The models: " + filesToWrite(io::FileContent::Model))
        ->required()
        ->expected(1, 1000);
    CLI::Option* const vertices =
        command
            .add_option(
                "--vertices", options.cage.vertices,
                "Number of vertices, 8 to 100,000; the result has between 0.8 and 1.2 times "
                "as many")
            ->check(inRange(8, 100000, true))
            ->capture_default_str();
    command
        .add_option("--size", options.cage.cellSize,
                    "Edge of the cells before they are fitted, in the units of the model")
        ->check(aboveZero())
        ->excludes(vertices);
    command
        .add_option("--margin", options.cage.margin,
                    "Least distance from the model to the boundary of the lattice, as a fraction "
                    "of the diagonal of the box around the model: 0 to 1")
        ->check(inRange(0, 1))
        ->capture_default_str();
    command
        .add_option("--shell", options.cage.shell,
                    "Make a lattice around the surface only, at least this thick, in the units of "
                    "the model")
        ->check(aboveZero());
    command.add_flag("--keep-apart", options.cage.keepApart,
                     "Keep parts of the model separate that are nearer to each other than a cell");
    addChoice<cages::Symmetric>(
        command, "--symmetric", options.cage.symmetric, cages::kSymmetricWords,
        "Planes about which the lattice is symmetric, across the axes and through the middle of "
        "the box around the model; auto: about which the model is symmetric");
    command
        .add_option("--symmetry", options.cage.symmetry,
                    "Largest distance of a mirrored point from the model that counts as "
                    "symmetric, as a fraction of the diagonal: 0 to 1")
        ->check(inRange(0, 1))
        ->capture_default_str();
    addCollarOptions(command, options.collar, options.common, "--collar", false);
    addOutputOption(command, options.output,
                    "The lattice: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    addStrictOption(command, options.common);
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli
