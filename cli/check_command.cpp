// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_refiner.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/shapes/level_lattice.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.h"
#include "files.h"
#include "job.h"
#include "run_report.h"

namespace espalier::cli {
namespace {

struct CheckOptions {
    CommonOptions common;
    std::string pose;
    std::string rest;
    int level = 3;  ///< the default of `deform`
    bool limit = false;
    double maxStep = 2;
    std::size_t listed = 5;  ///< number of cells that are listed of each kind
    std::string output;
    ReportFormat report = ReportFormat::Text;
};

/// The input and the results of a check.
struct CheckedPose {
    const CheckOptions& options;
    const far::TopologyRefiner& refiner;
    int level;                       ///< the level of the cells; 0 in the limit
    std::vector<Point3> rest, pose;  ///< positions at that level
    std::vector<Index> badAtRest;
    solve::PoseValidity validity;
    solve::LargestStep step;

    const far::CellComplex& complex() const { return refiner.level(level).complex; }
    Index baseCell(Index cell) const { return solve::baseCellOf(refiner, level, cell); }

    Point3 centre(Index cell, const std::vector<Point3>& positions) const {
        const auto vertices = complex().relation(3, 0)[cell];
        Point3 sum{};
        for (const Index vertex : vertices)
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += positions[vertex][c] / static_cast<double>(vertices.size());
        return sum;
    }
    bool isBadAtRest(Index cell) const {
        return std::binary_search(badAtRest.begin(), badAtRest.end(), cell);
    }
    /// The number of cells that have a volume: in the limit, cells may vanish.
    std::ptrdiff_t count() const {
        return std::count_if(validity.ratios.begin(), validity.ratios.end(),
                             [](const auto& ratio) { return ratio.has_value(); }) +
               std::ssize(badAtRest);
    }
    const std::optional<double>& ratio(Index cell) const { return validity.ratios[cell]; }
};

/// \param positions of the vertices, for the centre of the cell
OrderedJson toJson(const CheckedPose& checked, Index cell, const std::vector<Point3>& positions) {
    OrderedJson json = {{"cell", cell},
                        {"base_cell", checked.baseCell(cell)},
                        {"centre", checked.centre(cell, positions)}};
    if (checked.ratio(cell)) json["volume_ratio"] = *checked.ratio(cell);
    return json;
}

OrderedJson toJson(const CheckedPose& checked, const std::vector<Index>& cells,
                   const std::vector<Point3>& positions) {
    OrderedJson first = OrderedJson::array();
    for (std::size_t i = 0; i < std::min(cells.size(), checked.options.listed); ++i)
        first.push_back(toJson(checked, cells[i], positions));
    return {{"count", cells.size()}, {"first", first}};
}

/// Returns an object with these keys:
///
///     level, cells           the level, and its number of cells; for the limit, the cells of the
///                            lattice that do not vanish
///     limit_level            the level that irregular places were refined to; null unless --limit
///     bad_at_rest            {count, first: [{cell, base_cell, centre}]}: cells that are flat or
///                            folded at rest; at most --list of them, ascending
///     inverted               {count, first: [{cell, base_cell, centre, volume_ratio}]}: cells that
///                            the pose inverts
///     smallest_volume_ratio  {cell, base_cell, centre, volume_ratio}
///     largest_step           {length, max, limiting_cell, is_tight}: length and max as fractions
///                            of the way from rest to pose; the cell that limits the length, or
///                            null if the length is max; whether that cell certainly folds just
///                            beyond it (solve/validity.h)
OrderedJson toJson(const CheckedPose& checked) {
    const auto& limiting = checked.step.limitingCell;
    return {
        {"level", checked.level},
        {"limit_level", checked.options.limit ? OrderedJson(checked.options.level) : OrderedJson()},
        {"cells", checked.count()},
        {"bad_at_rest", toJson(checked, checked.badAtRest, checked.rest)},
        {"inverted", toJson(checked, checked.validity.inverted, checked.pose)},
        {"smallest_volume_ratio", toJson(checked, checked.validity.smallest->cell, checked.pose)},
        {"largest_step",
         {{"length", checked.step.length},
          {"max", checked.options.maxStep},
          {"limiting_cell", limiting ? toJson(checked, *limiting, checked.pose) : OrderedJson()},
          {"is_tight", checked.step.isTight}}}};
}

/// Returns "cell 12 (in cell 0 of the lattice)"; in the limit "cell 0 of the lattice".
std::string name(const CheckedPose& checked, Index cell) {
    if (checked.options.limit) return fmt::format("cell {} of the lattice", cell);
    return fmt::format("cell {} (in cell {} of the lattice)", cell, checked.baseCell(cell));
}

/// Prints the number of cells of a kind, and the first few of them.
void printCells(const CheckedPose& checked, const char* title, const std::vector<Index>& cells,
                const std::vector<Point3>& positions) {
    fmt::print("{:<23} {}\n", title, cells.size());
    for (std::size_t i = 0; i < std::min(cells.size(), checked.options.listed); ++i) {
        fmt::print("  {} at ({:.4g})", name(checked, cells[i]),
                   fmt::join(checked.centre(cells[i], positions), ", "));
        if (const auto& ratio = checked.ratio(cells[i]))
            fmt::print(": volume ratio {:.3g}", *ratio);
        fmt::print("\n");
    }
    if (cells.size() > checked.options.listed)
        fmt::print("  and {} more\n", cells.size() - checked.options.listed);
}

std::string title(const CheckedPose& checked) {
    return checked.options.limit ? "cells in the limit"
                                 : fmt::format("cells of level {}", checked.level);
}

void printText(const CheckedPose& checked) {
    fmt::print("{:<23} {}\n", title(checked), checked.count());
    printCells(checked, "flat or folded at rest", checked.badAtRest, checked.rest);
    printCells(checked, "inverted by the pose", checked.validity.inverted, checked.pose);
    const auto& [cell, ratio] = *checked.validity.smallest;
    fmt::print("smallest volume ratio   {:.3g} (pose : rest), {}\n", ratio, name(checked, cell));
    if (const auto& limiting = checked.step.limitingCell)
        fmt::print("largest safe step       {}{:.6g} of the way from rest to pose; then {} {}\n",
                   checked.step.isTight ? "" : "at least ", checked.step.length,
                   name(checked, *limiting), checked.step.isTight ? "folds" : "may fold");
    else
        fmt::print("largest safe step       {:.6g} of the way from rest to pose, or more\n",
                   checked.step.length);
}

/// Returns the refined pose with two attributes at each vertex: the smallest volume ratio of the
/// cells around it, 0 if there is none, and the number of these cells that are bad at rest.
Lattice withRatios(const CheckedPose& checked) {
    Lattice refined = levelLattice(checked.refiner, checked.level, checked.pose);
    VertexAttribute ratios{"volume_ratio", 1, {}}, bad{"bad_at_rest", 1, {}};
    for (Index vertex = 0; vertex < refined.complex.count(0); ++vertex) {
        std::optional<double> smallest;
        double badCount = 0;
        for (const Index cell : refined.complex.relation(0, 3)[vertex])
            if (const auto& ratio = checked.ratio(cell))
                smallest = smallest ? std::min(*smallest, *ratio) : *ratio;
            else if (checked.isBadAtRest(cell))
                ++badCount;
        ratios.values.push_back(smallest.value_or(0));
        bad.values.push_back(badCount);
    }
    refined.attributes = {std::move(ratios), std::move(bad)};
    return refined;
}

CheckedPose check(const CheckOptions& options, const far::TopologyRefiner& refiner,
                  const Lattice& rest, const std::vector<Point3>& pose, Stages& stages) {
    const int level = refiner.maxLevel();
    const auto refined = [&](const std::vector<Point3>& positions) {
        return stages.run("computing positions",
                          [&] { return stencils::refinePositions(refiner, level, positions); });
    };
    CheckedPose checked{options,       refiner, level, refined(rest.positions),
                        refined(pose), {},      {},    {}};
    stages.run("checking", [&] {
        const auto validity = ofFile(options.rest, [&] {
            if (!options.limit) return solve::ValidityCheck(checked.complex(), checked.rest);
            return solve::ValidityCheck(limit::LimitParts(refiner, options.level), checked.rest);
        });
        checked.badAtRest = validity.badAtRest();
        checked.validity = ofFile(options.pose, [&] { return validity.check(checked.pose); });
        checked.step = validity.largestStep(checked.pose, options.maxStep);
    });
    if (!checked.validity.smallest)
        throw io::FileError(options.rest,
                            "all cells are flat or folded at rest: there is no cell to compare "
                            "with the pose");
    return checked;
}

void runCheck(const CheckOptions& options) {
    Job job(options.common, {{"LATTICE", options.pose}, {"--rest", options.rest}});
    if (!options.output.empty()) job.writesLattice(options.output);
    Stages& stages = job.stages();
    const Lattice lattice = readLattice(options.rest, stages);
    const auto pose = readPoses({options.pose}, lattice, options.rest, stages).front();
    const far::TopologyRefiner refiner = stages.run("refining", [&] {
        return refineLattice(options.rest, lattice, options.common,
                             options.limit ? 0 : options.level);
    });
    const CheckedPose checked = check(options, refiner, lattice, pose, stages);
    if (!options.output.empty()) {
        stages.run("writing", [&] { io::writeLattice(options.output, withRatios(checked)); });
    }
    if (!options.common.quiet) {
        if (options.report == ReportFormat::Json)
            fmt::print("{}\n", toJson(checked).dump(2));
        else
            printText(checked);
    }
    const auto& inverted = checked.validity.inverted;
    if (!inverted.empty())
        throw FailedCheck(fmt::format("{}: this pose turns {} of {} {} inside out, the first {}",
                                      io::shownPath(options.pose), inverted.size(), checked.count(),
                                      title(checked), name(checked, inverted.front())));
}

}  // namespace

void addCheckCommand(CLI::App& program) {
    const auto [command, options] =
        addCommand(program, "check",
                   "Find the cells that a pose of a lattice turns inside out, and how far the "
                   "lattice can move "
                   "towards the pose before one folds; exit code 3 if there are such cells",
                   runCheck);
    command
        .add_option("LATTICE", options.pose,
                    "The pose: " + filesToWrite(io::FileContent::Lattice) +
                        ", or an editor mesh (" + filesToWrite(io::FileContent::EditorMesh) + ")")
        ->required();
    command
        .add_option("--rest", options.rest, "The lattice at rest, with the topology of the pose")
        ->required();
    addLevelOption(command, options.level, 1);
    command.add_flag("--limit", options.limit,
                     "Check the limits of the cells of LATTICE instead of the cells of level N, "
                     "which is then the "
                     "level that irregular places are refined to");
    command
        .add_option(
            "--max-step", options.maxStep,
            "How far to look for the largest safe step; 1 is the whole way from rest to pose")
        ->check(aboveZero(1e6))
        ->capture_default_str();
    command
        .add_option("--list", options.listed,
                    "How many cells to name of those that are flat, folded or inverted")
        ->check(inRange(0, kMaxIndex, true))
        ->capture_default_str();
    addOutputOption(command, options.output,
                    "Write the pose at level N (level 0 with --limit) with two vertex attributes: "
                    "volume_ratio, the smallest of the cells at the vertex, and bad_at_rest, the "
                    "number of these cells that are flat or folded at rest: " +
                        filesToWrite(io::FileContent::Lattice));
    addRefinementOptions(command, options.common);
    addRunOptions(command, options.common);
    addReportOption(command, options.report);
}

}  // namespace espalier::cli
