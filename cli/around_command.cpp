// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/printable.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/shapes/around.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "collar_options.h"
#include "commands.h"
#include "files.h"
#include "job.h"
#include "options.h"
#include "pose_selection.h"

namespace espalier::cli {
namespace {

struct AroundCommandOptions {
    CommonOptions common;
    std::vector<std::string> models;
    std::vector<int> cells;
    std::vector<double> part;  ///< two corners of a box; empty for whole models
    std::string symmetry;
    CollarCommandOptions collar;
    shapes::AroundOptions shape;
    std::string output;
};

/// Reads the points of all models that are in the part.
std::vector<Point3> readPoints(const AroundCommandOptions& options, Stages& stages) {
    std::vector<Point3> points;
    BoundingBox part;
    for (std::size_t i = 0; i < options.part.size(); i += 3)
        part.include({options.part[i], options.part[i + 1], options.part[i + 2]});
    const auto isInPart = [&](const Point3& point) {
        return options.part.empty() || part.contains(point);
    };
    for (const std::string& path : options.models) {
        const auto model = readModel(path, options.common, stages);
        std::ranges::copy_if(model->positions(), std::back_inserter(points), isInPart);
    }
    if (points.empty())
        throw io::FileError(options.models.front(),
                            "no point of the models is in the box of --around-part");
    return points;
}

/// Returns the options of the lattice.
/// \throws CLI::ValidationError
shapes::AroundOptions shapeOf(const AroundCommandOptions& options) {
    shapes::AroundOptions shape = options.shape;
    if (const auto plane = mirrorPlaneOf(options.symmetry))
        shape.symmetry = {plane->axis, plane->place};
    for (const int count : options.cells)
        if (count < 1)
            throw CLI::ValidationError("--cells", fmt::format("expected 1 or more, got {}", count));
    if (options.cells.size() == 2)
        throw CLI::ValidationError("--cells", "expected one number or three, got two");
    if (options.cells.size() == 1) shape.cellsAlongLongest = options.cells.front();
    if (options.cells.size() == 3) std::ranges::copy(options.cells, shape.cells.begin());
    return shape;
}

void runAround(const AroundCommandOptions& options) {
    const shapes::AroundOptions shape = shapeOf(options);
    Job job(options.common,
            {{"MODEL", options.models}, {"--until-model", options.collar.untilModel}});
    job.writesLattice(options.output);
    Stages& stages = job.stages();
    const std::vector<Point3> points = readPoints(options, stages);
    shapes::AroundFacts facts;
    WithCollar made = ofFile(options.models.front(), [&] {
        Lattice box = stages.run("building", [&] { return shapes::around(points, shape, &facts); });
        return withCollar(std::move(box), options.collar, stages, shape.symmetry);
    });
    made.facts.push_back(fmt::format("all {} points inside", points.size()));
    if (facts.margin != shape.margin)
        made.facts.back() += fmt::format(", with the margin widened to {:.2g}", facts.margin);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (facts.cells[axis] != facts.wanted[axis])
            made.facts.push_back(
                fmt::format("{} cells along {} instead of {}, for faces in the "
                            "plane of symmetry",
                            facts.cells[axis], "xyz"[axis], facts.wanted[axis]));
    writeWithCollar(options.output, made, options.common, stages);
}

}  // namespace

void addAroundCommand(CLI::App& shape) {
    const auto [command, options] = addCommand(
        shape, "around", "A box of hexahedra around the points of one or more models", runAround);
    command
        .add_option("MODEL", options.models, "The models: " + filesToRead(io::FileContent::Model))
        ->required()
        ->expected(1, 1000);
    CLI::Option* const cells =
        addNumbers(command, "--cells", options.cells, "N|I J K",
                   "One number: cells along the longest side; the other sides get the numbers that "
                   "make the cells closest to cubes. Three numbers: cells along x, y and z")
            ->expected(1, 3)
            ->default_str("4");
    command
        .add_option("--size", options.shape.cellSize,
                    "Largest edge of a cell, in the units of the model")
        ->check(aboveZero())
        ->excludes(cells);
    command
        .add_option("--margin", options.shape.margin,
                    "Distance from the points to the sides of the box, as a fraction of the "
                    "diagonal of the box around the points")
        ->capture_default_str();
    command.add_flag("--oriented", options.shape.oriented,
                     "Turn the box so that its volume is smallest, instead of along the axes");
    addNumbers(command, "--around-part", options.part, "X0 Y0 Z0 X1 Y1 Z1",
               "Use only the points in the box with these two opposite corners")
        ->expected(6);
    command
        .add_option("--symmetry", options.symmetry,
                    "Put faces of the box exactly into the plane of symmetry across an axis (x, y "
                    "or z), or into a plane such as y=0.5: a side of the box if the model is on "
                    "one side of it, else the middle. A collar leaves such a side open")
        ->check(CLI::Validator(
            [](std::string& word) {
                return mirrorPlaneOf(word)
                           ? std::string()
                           : "expected x, y or z, or a plane such as x=0.5, got " + shown(word);
            },
            ""))
        ->type_name("AXIS|AXIS=PLACE")
        ->excludes(command.get_option("--oriented"));
    addCollarOptions(command, options.collar, options.common, "--collar", false);
    addOutputOption(command, options.output,
                    "The lattice: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    addStrictOption(command, options.common);
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli
