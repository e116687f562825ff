// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>
#include <espalier/io/matrix_market.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>

#include <memory>

#include "commands.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

struct Options : LatticeOptions {
    std::string output;
};

void run(const Options& options) {
    const far::ThreadLimit limit(options.common.threads);
    checkOutput(options.output, {options.lattice}, ".mtx");
    Stages stages(options.common.quiet);
    const RefinedFile file = readAndRefine(options, FileKind::Refinable, stages);
    const auto table = stages.run("building", [&] {
        return stencils::buildStencils(file.refiner, options.level, options.common.rules);
    });
    const std::vector<std::string> comments = {
        fmt::format("S_{} of {}: rows are the vertices of level {}, in the order of espalier "
                    "refine; columns are the vertices of the file",
                    options.level, options.lattice, options.level)};
    stages.run("writing", [&] { io::writeMatrixMarket(options.output, table, comments); });
    if (!options.common.quiet)
        fmt::print("{}: {} × {}, {} entries\n", options.output, table.rowCount(),
                   table.columnCount(), table.entryCount());
}

}  // namespace

void addStencilsCommand(CLI::App& program) {
    auto options = std::make_shared<Options>();
    CLI::App& command = addLatticeCommand(
        program, "stencils",
        "Write S_N, the weights of the level-N vertices over those of the lattice, mesh or curve",
        FileKind::Refinable, *options);
    command.add_option("-o,--output", options->output, "The matrix: Matrix Market, .mtx")
        ->required();
    command.callback([options] { run(*options); });
}

}  // namespace espalier::cli
