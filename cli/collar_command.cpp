// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/printable.h>
#include <espalier/io/lattice_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "collar_options.h"
#include "commands.h"
#include "files.h"
#include "job.h"
#include "options.h"
#include "pose_selection.h"

namespace espalier::cli {
namespace {

/// Returns the corners of the box of --until or --until-model.
std::optional<std::array<Point3, 2>> boxOf(const CollarCommandOptions& collar, Stages& stages) {
    if (collar.until) {
        const auto& n = *collar.until;
        return std::array<Point3, 2>{{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}}};
    }
    if (collar.untilModel.empty()) return std::nullopt;
    const auto model = readModel(collar.untilModel, *collar.common, stages);
    const BoundingBox box(model->positions());
    return std::array<Point3, 2>{{box.min, box.max}};
}

struct CollarOfLattice {
    CommonOptions common;
    CollarCommandOptions collar;
    std::string lattice;
    std::string output;
};

void runCollar(const CollarOfLattice& options) {
    Job job(options.common,
            {{"LATTICE", options.lattice}, {"--until-model", options.collar.untilModel}});
    job.writesLattice(options.output);
    Stages& stages = job.stages();
    const WithCollar made = ofFile(options.lattice, [&] {
        return withCollar(readLattice(options.lattice, stages), options.collar, stages);
    });
    writeWithCollar(options.output, made, options.common, stages);
}

}  // namespace

void addCollarOptions(CLI::App& command, CollarCommandOptions& collar, CommonOptions& common,
                      const std::string& layers, bool isRequired) {
    collar.common = &common;
    CLI::Option* const count =
        command
            .add_option(layers, collar.layers,
                        std::string(isRequired ? "Layers"
                                               : "Add a collar around the lattice: "
                                                 "layers") +
                            " of cells whose outer vertices are held, so that motion fades out. "
                            "One layer: C0; two or more: C2")
            ->check(inRange(1, cages::kMaxCollarLayers, true))
            ->type_name("LAYERS");
    CLI::Option* const reach =
        command
            .add_option("--reach", collar.reach,
                        "Thickness of the collar: in the units of the model, or as a part of the "
                        "diagonal of the lattice (20%)")
            ->check(CLI::Validator(
                [](std::string& word) {
                    const auto length = lengthOf(word);
                    return length && length->value > 0
                               ? std::string()
                               : "expected a length above 0, such as 0.5 or 20%, got " +
                                     shown(word);
                },
                ""))
            ->type_name("LENGTH");
    CLI::Option* const until =
        addNumbers(command, "--until", collar.until, "X0 Y0 Z0 X1 Y1 Z1",
                   "The collar of a box reaches to the sides of the box with these two opposite "
                   "corners, such as the bounds of the whole mesh")
            ->excludes(reach);
    CLI::Option* const untilModel =
        command
            .add_option("--until-model", collar.untilModel,
                        "As --until, with the box around the points of a model")
            ->excludes(reach)
            ->excludes(until);
    CLI::Option* const open =
        command
            .add_option("--open", collar.open,
                        "Sides without a collar: x, y or z for both ends of an axis, or +x, -x "
                        "(written --open=-x) for one")
            ->delimiter(',')
            ->check(CLI::Validator(
                [](std::string& word) {
                    try {
                        cages::sidesOf({&word, 1});
                        return std::string();
                    } catch (const ArgumentError&) {
                        return "expected an axis x, y or z, or one side of it, such as +x or -z, "
                               "got " +
                               shown(word);
                    }
                },
                ""))
            ->type_name("SIDE ...");
    CLI::Option* const held =
        command
            .add_option("--held", collar.held,
                        "Number of outer layers of vertices that are held; by default two, or one "
                        "if there is one layer of cells")
            ->check(inRange(1, cages::kMaxCollarLayers, true))
            ->type_name("LAYERS");
    if (isRequired)
        count->required();
    else
        for (CLI::Option* const option : {reach, until, untilModel, open, held})
            option->needs(count);
}

WithCollar withCollar(Lattice lattice, const CollarCommandOptions& collar, Stages& stages,
                      const std::optional<shapes::SymmetryPlane>& symmetry) {
    if (!collar.layers) return {std::move(lattice), {}, ""};
    if (!collar.until && collar.untilModel.empty() && collar.reach.empty())
        throw CLI::ValidationError(
            "--reach, --until or --until-model is required: how far the "
            "collar reaches");
    cages::CollarOptions options{.layers = *collar.layers,
                                 .until = boxOf(collar, stages),
                                 .open = cages::sidesOf(collar.open),
                                 .symmetry = symmetry,
                                 .held = collar.held};
    if (!collar.reach.empty()) options.reach = lengthOf(collar.reach)->in(lattice);
    cages::Collar result =
        stages.run("adding the collar", [&] { return cages::collar(lattice, options); });
    const auto [least, most] = result.reach;
    std::string reach = fmt::format("{:.4g}", most);
    if (least < 0.999 * most) reach = fmt::format("{:.4g} to {}", least, reach);
    return {
        std::move(result.lattice),
        {},
        fmt::format("a collar of {} {} and {} held vertices reaches {} away, {}{}", options.layers,
                    options.layers == 1 ? "layer" : "layers", result.held.size(), reach,
                    result.continuity == embed::Continuity::C0 ? "c0" : "c2",
                    result.isGrid ? "" : "; irregular edges on the old boundary")};
}

void writeWithCollar(const std::string& path, const WithCollar& made, const CommonOptions& common,
                     Stages& stages) {
    stages.run("writing", [&] { io::writeLattice(path, made.lattice); });
    if (common.quiet) return;
    fmt::print("{}: {} vertices, {} cells", printable(path), made.lattice.complex.count(0),
               made.lattice.complex.count(3));
    for (const std::string& fact : made.facts) fmt::print("; {}", fact);
    fmt::print("{}{}\n", made.collar.empty() ? "" : "; ", made.collar);
}

void addCollarCommand(CLI::App& shape) {
    const auto [command, options] = addCommand(
        shape, "collar", "A lattice with layers of cells around it, in which motion fades out",
        runCollar);
    command
        .add_option("LATTICE", options.lattice,
                    "The lattice: " + filesToRead(io::FileContent::Lattice))
        ->required();
    addCollarOptions(command, options.collar, options.common, "--layers", true);
    addOutputOption(command, options.output,
                    "The lattice: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    addStrictOption(command, options.common);
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli
