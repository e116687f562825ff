// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "pipeline.h"
#include "run_report.h"

namespace espalier::cli {
namespace {

using far::Index;
using nlohmann::ordered_json;

struct Options {
    CommonOptions common;
    std::string pose;
    std::string rest;
    int level = 3;  ///< that of `deform`, whose cells these are
    double maxStep = 2;
    std::string output;
    ReportFormat report = ReportFormat::Text;
};

/// What was checked, and what came out.
struct Checked {
    const far::TopologyRefiner& refiner;
    int level;
    std::vector<Point3> rest, pose;  ///< of the level
    std::vector<Index> badAtRest;
    solve::PoseValidity validity;
    solve::LargestStep step;
    double maxStep;

    const far::CellComplex& complex() const { return refiner.level(level).complex; }
    Index baseCell(Index cell) const { return solve::baseCellOf(refiner, level, cell); }

    Point3 centre(Index cell, const std::vector<Point3>& positions) const {
        const auto vertices = complex().relation(3, 0)[cell];
        Point3 sum{};
        for (const Index vertex : vertices)
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += positions[static_cast<std::size_t>(vertex)][c] /
                          static_cast<double>(vertices.size());
        return sum;
    }
    double ratio(Index cell) const { return validity.ratios[static_cast<std::size_t>(cell)]; }
};

/// \param positions that tell where the cell is
ordered_json toJson(const Checked& checked, Index cell, const std::vector<Point3>& positions) {
    ordered_json json = {{"cell", cell},
                         {"base_cell", checked.baseCell(cell)},
                         {"centre", checked.centre(cell, positions)}};
    if (!std::isnan(checked.ratio(cell))) json["volume_ratio"] = checked.ratio(cell);
    return json;
}

/// An object:
///
///     level, cells           which, and how many there are
///     bad_at_rest            [{cell, base_cell, centre}]: at rest
///     inverted               [{cell, base_cell, centre, volume_ratio}]: of the pose
///     smallest_volume_ratio  one such
///     largest_step           {length, max, limiting_cell}: as parts of the way from rest to pose,
///                            and one such, or null where the length is the most
ordered_json toJson(const Checked& checked) {
    ordered_json badAtRest = ordered_json::array(), inverted = ordered_json::array();
    for (const Index cell : checked.badAtRest)
        badAtRest.push_back(toJson(checked, cell, checked.rest));
    for (const Index cell : checked.validity.inverted)
        inverted.push_back(toJson(checked, cell, checked.pose));
    const auto& limiting = checked.step.limitingCell;
    return {
        {"level", checked.level},
        {"cells", checked.complex().count(3)},
        {"bad_at_rest", badAtRest},
        {"inverted", inverted},
        {"smallest_volume_ratio", toJson(checked, checked.validity.smallest->cell, checked.pose)},
        {"largest_step",
         {{"length", checked.step.length},
          {"max", checked.maxStep},
          {"limiting_cell",
           limiting ? toJson(checked, *limiting, checked.pose) : ordered_json()}}}};
}

/// "cell 12 of base cell 0".
std::string name(const Checked& checked, Index cell) {
    return fmt::format("cell {} of base cell {}", cell, checked.baseCell(cell));
}

/// How many cells there are of a kind, and the first few of them.
void printCells(const Checked& checked, const char* title, const std::vector<Index>& cells,
                const std::vector<Point3>& positions) {
    constexpr std::size_t kFew = 5;
    fmt::print("{:<21} {}\n", title, cells.size());
    for (std::size_t i = 0; i < std::min(cells.size(), kFew); ++i) {
        fmt::print("  {} at ({:.4g})", name(checked, cells[i]),
                   fmt::join(checked.centre(cells[i], positions), ", "));
        if (!std::isnan(checked.ratio(cells[i])))
            fmt::print(": volume ratio {:.3g}", checked.ratio(cells[i]));
        fmt::print("\n");
    }
    if (cells.size() > kFew) fmt::print("  and {} more\n", cells.size() - kFew);
}

void printText(const Checked& checked) {
    fmt::print("{:<21} {}\n", fmt::format("cells of level {}", checked.level),
               checked.complex().count(3));
    printCells(checked, "bad at rest", checked.badAtRest, checked.rest);
    printCells(checked, "inverted", checked.validity.inverted, checked.pose);
    const auto& [cell, ratio] = *checked.validity.smallest;
    fmt::print("smallest volume ratio {:.3g} in {}\n", ratio, name(checked, cell));
    if (const auto& limiting = checked.step.limitingCell)
        fmt::print("largest valid step    {:.6g} of the way, for {}\n", checked.step.length,
                   name(checked, *limiting));
    else
        fmt::print("largest valid step    {:.6g} of the way or more\n", checked.step.length);
}

/// The pose refined, and at each vertex the smallest volume ratio of the cells around it; 0 if all
/// of them are bad at rest.
Lattice withRatios(const Checked& checked, const CommonOptions& options, Lattice base) {
    base.attributes.clear();
    Lattice refined = refinedLattice(checked.refiner, checked.level, options, base);
    VertexAttribute attribute{"volume_ratio", 1, {}};
    for (Index vertex = 0; vertex < refined.complex.count(0); ++vertex) {
        double smallest = std::numeric_limits<double>::infinity();
        for (const Index cell : refined.complex.relation(0, 3)[vertex])
            if (!std::isnan(checked.ratio(cell)))
                smallest = std::min(smallest, checked.ratio(cell));
        attribute.values.push_back(std::isinf(smallest) ? 0 : smallest);
    }
    refined.attributes.push_back(std::move(attribute));
    return refined;
}

Checked check(const Options& options, const far::TopologyRefiner& refiner, const Lattice& rest,
              const std::vector<Point3>& pose, Stages& stages) {
    const auto refined = [&](const std::vector<Point3>& positions) {
        return stages.run("placing", [&] {
            return stencils::refinePositions(refiner, options.level, options.common.rules,
                                             positions);
        });
    };
    Checked checked{refiner, options.level,  refined(rest.positions), refined(pose), {}, {},
                    {},      options.maxStep};
    stages.run("checking", [&] {
        const solve::ValidityCheck validity(checked.complex(), checked.rest);
        checked.badAtRest = validity.badAtRest();
        checked.validity = validity.check(checked.pose);
        checked.step = validity.largestStep(checked.pose, options.maxStep);
    });
    if (!checked.validity.smallest)
        throw io::FileError(options.rest,
                            "all cells are flat or folded at rest: nothing is there to compare a "
                            "pose with");
    return checked;
}

void run(const Options& options) {
    const far::ThreadLimit limit(options.common.threads);
    if (!options.output.empty()) {
        checkOutput(options.output, {options.pose, options.rest});
        io::checkLatticeTarget(options.output);
    }
    Stages stages(options.common.quiet);
    Lattice lattice = readLattice(options.rest, stages);
    auto pose =
        stages.run("reading", [&] { return readPose(options.pose, lattice, options.rest); });
    const far::TopologyRefiner refiner = stages.run("refining", [&] {
        return refineLattice(options.rest, lattice, options.common, options.level);
    });
    const Checked checked = check(options, refiner, lattice, pose, stages);
    if (!options.output.empty()) {
        lattice.positions = std::move(pose);
        stages.run("writing", [&] {
            io::writeLattice(options.output, withRatios(checked, options.common, lattice));
        });
    }
    if (!options.common.quiet) {
        if (options.report == ReportFormat::Json)
            fmt::print("{}\n", toJson(checked).dump(2));
        else
            printText(checked);
    }
    const auto& inverted = checked.validity.inverted;
    if (!inverted.empty())
        throw io::FileError(options.pose,
                            fmt::format("{} of {} cells of level {} are inverted, first {}",
                                        inverted.size(), checked.complex().count(3), options.level,
                                        name(checked, inverted.front())));
}

}  // namespace

void addCheckCommand(CLI::App& program) {
    auto options = std::make_shared<Options>();
    CLI::App& command = *program.add_subcommand(
        "check",
        "Find the cells that a pose of a lattice turns inside out, and the largest step towards "
        "the pose that turns none; exit code 1 if there are such cells");
    command.add_option("LATTICE", options->pose, "The pose: .ovm, .vtu or .vtk")->required();
    command.add_option("--rest", options->rest, "The lattice at rest: same topology")->required();
    addLevelOption(command, options->level, 1);
    command
        .add_option("--max-step", options->maxStep,
                    "How far to look for the largest step: 1 is the way from rest to pose")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command.add_option("-o,--output", options->output,
                       "Write the pose at level N with a vertex attribute volume_ratio, the "
                       "smallest of the cells around: .ovm, .vtu or .vtk");
    addRefinementOptions(command, options->common);
    addRunOptions(command, options->common);
    addReportOption(command, options->report);
    command.callback([options] { run(*options); });
}

}  // namespace espalier::cli
