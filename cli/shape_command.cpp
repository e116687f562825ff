// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/io/lattice_file.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/solids.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <numbers>

#include "commands.h"
#include "files.h"
#include "job.h"
#include "options.h"

namespace espalier::cli {
namespace {

/// Adds the command of one shape. `addOptions` adds its options. When the command runs, `make`
/// makes the lattice.
template <class Options>
void addShape(CLI::App& parent, const std::string& name, const std::string& help,
              const std::function<void(CLI::App&, Options&)>& addOptions,
              const std::function<Lattice(const Options&)>& make) {
    struct State {
        Options shape;
        std::string output;
        CommonOptions common;
    };
    auto state = std::make_shared<State>();
    CLI::App& command = *parent.add_subcommand(name, help);
    addOptions(command, state->shape);
    addOutputOption(command, state->output,
                    "The lattice: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    command.add_flag("--quiet", state->common.quiet, "Print nothing but errors");
    command.callback([state, make] {
        Job job(state->common, {});
        job.writesLattice(state->output);
        Stages& stages = job.stages();
        const Lattice lattice = stages.run("building", [&] { return make(state->shape); });
        stages.run("writing", [&] { io::writeLattice(state->output, lattice); });
        if (!state->common.quiet)
            fmt::print("{}: {} vertices, {} cells\n", printable(state->output),
                       lattice.complex.count(0), lattice.complex.count(3));
    });
}

/// Adds an option whose default is shown in the help.
template <class Value>
void add(CLI::App& command, const std::string& name, Value& value, const std::string& help) {
    command.add_option(name, value, help)->capture_default_str();
}

/// Adds an option for several numbers, whose default is shown in the help.
template <class Value>
void addAll(CLI::App& command, const std::string& name, Value& value, const std::string& names,
            const std::string& help) {
    addNumbers(command, name, value, names, help)
        ->default_str(fmt::format("{}", fmt::join(value, ",")));
}

void addPattern(CLI::App& command, shapes::DiskPattern& pattern) {
    add(command, "--rings", pattern.rings, "Rings of cells in the disk, counting the core");
    addChoice<shapes::Core>(command, "--core", pattern.core, shapes::kCoreWords,
                            "Core of the disk: wedges around a vertex, or one polygonal prism");
}

/// Returns the joint of the numbers x, y, z, radius and perhaps twist (degrees).
shapes::ArmJoint jointOf(const std::vector<double>& numbers) {
    if (numbers.size() != 4 && numbers.size() != 5)
        throw CLI::ValidationError(
            "--joint",
            fmt::format("expected 4 or 5 numbers X Y Z RADIUS [TWIST], got {}", numbers.size()));
    const double degrees = numbers.size() == 5 ? numbers[4] : 0;
    return {{numbers[0], numbers[1], numbers[2]}, numbers[3], degrees * std::numbers::pi / 180};
}

void addRoundShapes(CLI::App& shape) {
    addShape<shapes::CylinderOptions>(
        shape, "cylinder",
        "A disk of cells swept along an axis (Figures 1 and 5 of MacCracken & Joy 1996)",
        [](CLI::App& command, shapes::CylinderOptions& options) {
            add(command, "--sectors", options.sectors, "Sides of the disk");
            addPattern(command, options.pattern);
            add(command, "--layers", options.layers, "Layers of cells");
            add(command, "--radius", options.radius, "Radius of the outermost vertices");
            addAll(command, "--from", options.from, "X Y Z", "Centre of the first end");
            addAll(command, "--to", options.to, "X Y Z", "Centre of the last end");
        },
        shapes::cylinder);
    addShape<shapes::TorusOptions>(
        shape, "torus", "A ring around the z axis, of a square or a disk of cells",
        [](CLI::App& command, shapes::TorusOptions& options) {
            add(command, "--segments", options.segments, "Cells around the ring");
            addChoice<shapes::TorusSection>(command, "--section", options.section,
                                            shapes::kTorusSectionWords,
                                            "Cross-section: a square (grid) or a disk");
            add(command, "--grid", options.gridCells,
                "Cells along each side of the square (--section grid)");
            add(command, "--sides", options.sides, "Sides of the disk (--section disk)");
            addPattern(command, options.pattern);
            add(command, "--major-radius", options.majorRadius, "Radius of the ring");
            add(command, "--minor-radius", options.minorRadius,
                "Radius of the disk, or half the side of the square");
        },
        shapes::torus);
    addShape<shapes::StarOptions>(
        shape, "star",
        "A flat star, or with equal radii the round shape that it is a pose of (Figure 7)",
        [](CLI::App& command, shapes::StarOptions& options) {
            add(command, "--points", options.points, "Points of the star");
            addPattern(command, options.pattern);
            add(command, "--layers", options.layers, "Layers of cells");
            add(command, "--inner-radius", options.innerRadius, "Radius of the notches");
            add(command, "--outer-radius", options.outerRadius, "Radius of the points");
            add(command, "--height", options.height, "Thickness");
        },
        shapes::star);
}

void addJointedShapes(CLI::App& shape) {
    addShape<shapes::BarbellOptions>(
        shape, "barbell", "Two ends joined by a bar (Figure 8)",
        [](CLI::App& command, shapes::BarbellOptions& options) {
            add(command, "--end-segments", options.endSegments, "Edges around an end");
            add(command, "--bar-segments", options.barSegments, "Cells along the bar");
            add(command, "--bar-across", options.barAcross, "Cells across the bar");
            addPattern(command, options.pattern);
            add(command, "--layers", options.layers, "Layers of cells");
            add(command, "--end-radius", options.endRadius, "Radius of an end");
            add(command, "--bar-length", options.barLength, "Length of the bar, from end to end");
            add(command, "--bar-half-width", options.barHalfWidth, "Half the width of the bar");
            add(command, "--roundness", options.roundness,
                "Roundness of the ends, from 0 (square) to 1 (round)");
            add(command, "--height", options.height, "Thickness");
        },
        shapes::barbell);
    struct Arm {
        shapes::ArmOptions options;
        std::vector<std::vector<double>> joints;
    };
    addShape<Arm>(
        shape, "arm", "A tube around a limb (Figure 9)",
        [](CLI::App& command, Arm& arm) {
            addNumbers(command, "--joint", arm.joints, "X Y Z RADIUS [TWIST]",
                       "A joint of the limb; its twist is in degrees. Repeat the option for each "
                       "joint, from the shoulder to the hand");
            add(command, "--segments", arm.options.segments, "Cells from joint to joint");
            add(command, "--sides", arm.options.sides, "Sides of the cross-section");
            addPattern(command, arm.options.pattern);
            addAll(command, "--up", arm.options.up, "X Y Z",
                   "Direction in which the first vertex of the cross-section lies");
        },
        [](const Arm& arm) {
            shapes::ArmOptions options = arm.options;
            if (!arm.joints.empty()) options.joints.clear();
            for (const auto& joint : arm.joints) options.joints.push_back(jointOf(joint));
            return shapes::arm(options);
        });
}

void addSolids(CLI::App& shape) {
    using Regular = shapes::RegularSolidOptions;
    const auto addRadius = [](CLI::App& command, Regular& options) {
        add(command, "--radius", options.radius, "Radius of the sphere through the vertices");
    };
    addShape<Regular>(shape, "tetrahedron", "One cell of four triangles", addRadius,
                      shapes::tetrahedron);
    addShape<Regular>(shape, "cube", "One cell of six squares", addRadius, shapes::cube);
    addShape<Regular>(shape, "octahedron",
                      "One cell of eight triangles; 4 edges meet at each vertex", addRadius,
                      shapes::octahedron);
    addShape<Regular>(shape, "dodecahedron", "One cell of twelve pentagons", addRadius,
                      shapes::dodecahedron);
    addShape<Regular>(shape, "icosahedron",
                      "One cell of twenty triangles; 5 edges meet at each vertex", addRadius,
                      shapes::icosahedron);
    using Polygonal = shapes::PolygonalSolidOptions;
    const auto addPolygon = [](CLI::App& command, Polygonal& options) {
        add(command, "--sides", options.sides, "Sides of the polygon");
        add(command, "--radius", options.radius, "Radius of the polygon");
        add(command, "--height", options.height, "Height of the solid");
    };
    addShape<Polygonal>(shape, "prism", "One cell between two polygons", addPolygon, shapes::prism);
    addShape<Polygonal>(shape, "pyramid", "One cell between a polygon and an apex", addPolygon,
                        shapes::pyramid);
    addShape<Polygonal>(shape, "bipyramid", "One cell with an apex on each side of a polygon",
                        addPolygon, shapes::bipyramid);
}

struct MergeCommandOptions {
    CommonOptions common;
    std::vector<std::string> lattices;
    shapes::MergeOptions merge;
    bool allowSeparate = false;
    std::string output;
};

/// Throws if a lattice shares no face with the first one, directly or through other lattices:
/// parts that look joined would come apart under a pose.
void requireJoined(const MergeCommandOptions& options, const shapes::MergeJoints& joints,
                   const std::string& counts) {
    const auto apart = std::ranges::find_if(joints.groups, [](auto group) { return group != 0; });
    if (apart == joints.groups.end()) return;
    throw io::FileError(
        options.lattices[apart - joints.groups.begin()],
        fmt::format("is not joined to {}: no face is in both, directly or through another lattice "
                    "({}). Where parts touch, the vertices and faces of one must be those of the "
                    "other, within --tolerance; --allow-separate accepts parts that are apart",
                    printable(options.lattices.front()), counts));
}

void runMerge(const MergeCommandOptions& options) {
    Job job(options.common, {{"LATTICE", options.lattices}});
    job.writesLattice(options.output);
    Stages& stages = job.stages();
    std::vector<Lattice> lattices;
    shapes::MergeOptions merge = options.merge;
    for (const std::string& path : options.lattices) {
        lattices.push_back(readLattice(path, stages));
        merge.names.push_back(io::shownPath(path));
    }
    const Lattice merged = stages.run("building", [&] { return shapes::merge(lattices, merge); });
    const shapes::MergeJoints joints = shapes::findJoints(lattices, merged);
    const auto countOf = [](Index count, const char* one, const char* several) {
        return fmt::format("{} {}", count, count == 1 ? one : several);
    };
    const std::string counts = countOf(joints.weldedVertices, "vertex", "vertices") + " welded, " +
                               countOf(joints.sharedFaces, "face", "faces") + " shared";
    if (!options.allowSeparate) requireJoined(options, joints, counts);
    stages.run("writing", [&] { io::writeLattice(options.output, merged); });
    if (!options.common.quiet)
        fmt::print("{}: {} vertices, {} cells; {}\n", printable(options.output),
                   merged.complex.count(0), merged.complex.count(3), counts);
}

void addMerge(CLI::App& shape) {
    const auto [command, options] = addCommand(
        shape, "merge", "Merge lattices into one: vertices at the same place are joined", runMerge);
    command
        .add_option("LATTICE", options.lattices,
                    "Two or more lattices: " + filesToRead(io::FileContent::Lattice))
        ->required()
        ->expected(2, 1000);
    add(command, "--tolerance", options.merge.tolerance,
        "Largest distance between vertices that are joined, as a fraction of the diagonal of "
        "the box around all lattices");
    command.add_flag("--allow-separate", options.allowSeparate,
                     "Accept lattices that share no face with the others; otherwise they are an "
                     "error");
    addOutputOption(command, options.output,
                    "The lattice: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    command.add_flag("--quiet", options.common.quiet, "Print nothing but errors");
}

}  // namespace

void addShapeCommand(CLI::App& program) {
    CLI::App& shape = *program.add_subcommand("shape",
                                              "Make a lattice around a model or one of the "
                                              "built-in lattices, or merge lattices into one");
    shape.require_subcommand(1);
    addShape<shapes::BoxOptions>(
        shape, "box", "A box of hexahedra (Figure 1 of MacCracken & Joy 1996)",
        [](CLI::App& command, shapes::BoxOptions& options) {
            addAll(command, "--cells", options.cells, "I J K", "Cells along x, y and z");
            addAll(command, "--min", options.min, "X Y Z", "Lowest corner");
            addAll(command, "--max", options.max, "X Y Z", "Highest corner");
        },
        shapes::box);
    addAroundCommand(shape);
    addCageCommand(shape);
    addCollarCommand(shape);
    addRoundShapes(shape);
    addJointedShapes(shape);
    addSolids(shape);
    addMerge(shape);
}

}  // namespace espalier::cli
