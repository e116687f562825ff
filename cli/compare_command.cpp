// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/comparison.h>
#include <espalier/compare/html_report.h>
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/io/file.h>
#include <espalier/io/lattice_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <ostream>

#include "commands.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

struct Options {
    CommonOptions common;
    std::vector<std::string> files;
    std::string html;
    int level = 3;
};

/// Compares one file. What it throws is the reason why it could not.
compare::ReportedShape compareFile(const Options& options, const std::string& file,
                                   Stages& stages) {
    compare::ReportedShape shape;
    shape.name = file;
    try {
        const Lattice lattice = stages.run("reading", [&] { return io::readRefinable(file); });
        const auto refiner = stages.run("refining", [&] {
            return refineLattice(file, lattice, options.common, options.level);
        });
        shape.agreement = stages.run("comparing", [&] {
            return compare::Comparison(refiner).compareAll(options.common.rules, lattice.positions);
        });
    } catch (const Error& error) {
        shape.failure = error.what();
    }
    return shape;
}

/// "1602", or "1602 (theirs 1600)".
std::string countText(far::Index ours, far::Index theirs) {
    return ours == theirs ? fmt::format("{}", ours) : fmt::format("{} (theirs {})", ours, theirs);
}

void print(const compare::ReportedShape& shape, std::size_t nameWidth,
           const compare::Bounds& bounds) {
    for (const compare::LevelAgreement& level : shape.agreement.levels) {
        fmt::print(
            "{:<{}}  level {}  {:>8} vertices {:>8} faces  position {:<7.1e}  "
            "weight {:<7.1e}  evaluators {:<7.1e}  {}\n",
            shape.name, nameWidth, level.level,
            countText(level.counts[0], level.openSubdivCounts[0]),
            countText(level.counts[2], level.openSubdivCounts[2]), level.positionDifference,
            level.weightDifference, level.evaluatorDifference,
            level.isWithin(bounds) ? "agrees" : "DIFFERS");
        if (!level.topologyDifference.empty())
            fmt::print("{:<{}}    {}\n", "", nameWidth, level.topologyDifference);
    }
    if (!shape.agreement.note.empty())
        fmt::print("{:<{}}  note: {}\n", "", nameWidth, shape.agreement.note);
    if (!shape.failure.empty())
        fmt::print("{:<{}}  could not be compared: {}\n", shape.name, nameWidth, shape.failure);
}

/// Why the comparison fails, in one line.
std::string describe(const compare::Report& report, std::size_t differing, std::size_t failed) {
    std::string text;
    if (differing > 0)
        text = fmt::format(
            "{} of {} files {} from OpenSubdiv {} (bounds: positions {:g}, weights {:g}, "
            "evaluators {:g})",
            differing, report.shapes.size(), differing == 1 ? "differs" : "differ",
            report.openSubdivVersion, report.bounds.position, report.bounds.weight,
            report.bounds.evaluator);
    if (failed > 0)
        text += fmt::format("{}{} of {} files could not be compared", text.empty() ? "" : "; ",
                            failed, report.shapes.size());
    return text;
}

void run(const Options& options) {
    const far::ThreadLimit limit(options.common.threads);
    if (!options.html.empty()) checkOutput(options.html, options.files);
    Stages stages(options.common.quiet);
    compare::Report report{.title = "Espalier against OpenSubdiv",
                           .command = fmt::format("espalier compare -n {} FILE...", options.level),
                           .bounds = {},
                           .openSubdivVersion = compare::openSubdivVersion(),
                           .shapes = {}};
    std::size_t nameWidth = 0;
    for (const std::string& file : options.files) nameWidth = std::max(nameWidth, file.size());
    std::size_t differing = 0, failed = 0;
    for (const std::string& file : options.files) {
        report.shapes.push_back(compareFile(options, file, stages));
        const compare::ReportedShape& shape = report.shapes.back();
        if (!shape.failure.empty())
            ++failed;
        else if (!shape.agreement.isWithin(report.bounds))
            ++differing;
        if (!options.common.quiet) print(shape, nameWidth, report.bounds);
    }
    if (!options.html.empty())
        stages.run("writing", [&] {
            io::writeFile(options.html,
                          [&](std::ostream& out) { out << compare::htmlReport(report); });
        });
    if (differing + failed > 0) throw Error(describe(report, differing, failed));
    if (!options.common.quiet)
        fmt::print("{} of {} files agree with OpenSubdiv {} at levels 1 to {}\n",
                   options.files.size(), options.files.size(), report.openSubdivVersion,
                   options.level);
}

}  // namespace

void addCompareCommand(CLI::App& program) {
    auto options = std::make_shared<Options>();
    CLI::App& command = *program.add_subcommand(
        "compare",
        "Compare meshes, and the boundaries of lattices, with OpenSubdiv's refinement of them, "
        "level by level");
    command.add_option("FILE", options->files, "Meshes: .obj; lattices: .ovm, .vtu or .vtk")
        ->required();
    addLevelOption(command, options->level, 1);
    command.add_option("--html", options->html,
                       "Write a report: all shapes and levels, and pictures of the error");
    addRefinementOptions(command, options->common);
    addRunOptions(command, options->common);
    command.callback([options] { run(*options); });
}

}  // namespace espalier::cli
