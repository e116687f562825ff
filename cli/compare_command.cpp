// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include "commands.h"
#include "job.h"

#ifdef ESPALIER_WITH_COMPARE

#include <espalier/base/printable.h>
#include <espalier/compare/comparison.h>
#include <espalier/compare/html_report.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "files.h"

namespace espalier::cli {
namespace {

struct CompareOptions {
    CommonOptions common;
    std::vector<std::string> files;
    std::string html;
    int level = 3;
};

/// Compares one file. The text of an Error becomes the reason why the file could not be compared.
compare::ReportedShape compareFile(const CompareOptions& options, const std::string& file,
                                   Stages& stages) {
    compare::ReportedShape shape;
    shape.name = printable(file);
    try {
        const auto [lattice, refiner] =
            readAndRefine({options.common, file, options.level}, FileKind::Refinable, stages);
        shape.agreement = stages.run("comparing", [&, &lattice = lattice, &refiner = refiner] {
            return compare::Comparison(refiner).compareAll(lattice.positions);
        });
    } catch (const Error& error) {
        shape.failure = error.what();
        if (!shape.failure.starts_with(shape.name))
            shape.failure = shape.name + ": " + shape.failure;
    }
    return shape;
}

/// Returns "1602", or "1602 (OpenSubdiv 1600)" if the counts differ.
std::string countText(Index ours, Index theirs) {
    return ours == theirs ? fmt::format("{}", ours)
                          : fmt::format("{} (OpenSubdiv {})", ours, theirs);
}

void print(const compare::ReportedShape& shape, std::size_t nameWidth,
           const compare::Bounds& bounds) {
    for (const compare::LevelAgreement& level : shape.agreement.levels) {
        fmt::print(
            "{:<{}}  level {}  {:>8} vertices {:>8} faces  differences: positions {:<7.1e}  "
            "weights {:<7.1e}  evaluators {:<7.1e}  {}\n",
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
        fmt::print("{:<{}}  could not be compared\n", shape.name, nameWidth);
}

/// Returns why a shape could not be compared, or where it first differs; empty if it agrees.
std::string offence(const compare::ReportedShape& shape, const compare::Report& report) {
    if (!shape.failure.empty()) return shape.failure;
    for (const compare::LevelAgreement& level : shape.agreement.levels)
        if (!level.isWithin(report.bounds))
            return fmt::format(
                "{}: differs from OpenSubdiv {} at level {}{}", shape.name,
                report.openSubdivVersion, level.level,
                level.topologyDifference.empty() ? "" : ": " + level.topologyDifference);
    return {};
}

/// Throws if a shape differs or could not be compared, and names the first one. Throws FailedCheck
/// if all shapes could be compared, Error otherwise.
void checkAll(const compare::Report& report) {
    std::vector<std::string> offences;
    for (const compare::ReportedShape& shape : report.shapes)
        if (const std::string text = offence(shape, report); !text.empty())
            offences.push_back(text);
    if (offences.empty()) return;
    std::string first = offences.front();
    if (offences.size() > 1)
        first +=
            fmt::format(" (and {} more of {} files)", offences.size() - 1, report.shapes.size());
    if (std::ranges::all_of(report.shapes, [](const auto& shape) { return shape.failure.empty(); }))
        throw FailedCheck(first);
    throw Error(first);
}

void runCompare(const CompareOptions& options) {
    Job job(options.common, {{"FILE", options.files}});
    if (!options.html.empty()) job.writes(options.html);
    Stages& stages = job.stages();
    compare::Report report{
        .title = "Espalier against OpenSubdiv",
        .command = fmt::format("espalier compare [options] -n {} FILE...", options.level),
        .bounds = {},
        .openSubdivVersion = compare::openSubdivVersion(),
        .shapes = {}};
    std::size_t nameWidth = 0;
    for (const std::string& file : options.files)
        nameWidth = std::max(nameWidth, printable(file).size());
    for (const std::string& file : options.files) {
        report.shapes.push_back(compareFile(options, file, stages));
        if (!options.common.quiet) print(report.shapes.back(), nameWidth, report.bounds);
    }
    if (!options.html.empty())
        stages.run("writing", [&] {
            io::writeFile(options.html,
                          [&](std::ostream& out) { out << compare::htmlReport(report); });
        });
    checkAll(report);
    if (!options.common.quiet)
        fmt::print("{} of {} files agree with OpenSubdiv {} at levels 1 to {}\n",
                   options.files.size(), options.files.size(), report.openSubdivVersion,
                   options.level);
}

}  // namespace

void addCompareCommand(CLI::App& program) {
    const auto [command, options] = addCommand(
        program, "compare",
        "Refine meshes, and boundary surfaces of lattices, with Espalier and with OpenSubdiv, and "
        "compare the levels; exit code 3 if they differ",
        runCompare);
    command
        .add_option("FILE", options.files,
                    "Meshes: " + filesToRead(io::FileContent::Mesh) +
                        "; lattices: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    addLevelOption(command, options.level, 1);
    addOutputOption(command, options.html,
                    "Write a report in HTML with all files, levels and pictures of the differences",
                    "--html");
    addRefinementOptions(command, options.common, RulesFor::OpenSubdiv);
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli

#else

namespace espalier::cli {

/// In a build without OpenSubdiv the command only reports that.
void addCompareCommand(CLI::App& program) {
    CLI::App& command = *program.add_subcommand(
        "compare", "Not available: this program was built without OpenSubdiv");
    command.allow_extras();
    command.callback([] {
        throw Error(
            "compare: this program was built without OpenSubdiv; install libosd-dev, and build it "
            "again");
    });
}

}  // namespace espalier::cli

#endif
