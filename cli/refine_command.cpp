// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>
#include <espalier/io/lattice_file.h>
#include <fmt/format.h>

#include <memory>

#include "commands.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

struct Options {
    CommonOptions common;
    std::string lattice;
    std::string output;
    int level = 2;
};

void run(const Options& options) {
    const far::ThreadLimit limit(options.common.threads);
    io::checkLatticeTarget(options.output);
    Stages stages(options.common.quiet);
    const Lattice lattice = stages.run("reading", [&] { return io::readLattice(options.lattice); });
    const Lattice refined = stages.run("refining", [&] {
        const auto refiner = refineLattice(options.lattice, lattice, options.common, options.level);
        return refinedLattice(refiner, options.level, options.common, lattice);
    });
    stages.run("writing", [&] { io::writeLattice(options.output, refined); });
    if (!options.common.quiet)
        fmt::print("{}: level {}, {} vertices, {} cells\n", options.output, options.level,
                   refined.complex.count(0), refined.complex.count(3));
}

}  // namespace

void addRefineCommand(CLI::App& program) {
    auto options = std::make_shared<Options>();
    CLI::App& command = *program.add_subcommand(
        "refine", "Write level N of a lattice: positions, cells, attributes and marks");
    command.add_option("LATTICE", options->lattice, "The lattice: .ovm, .vtu or .vtk")->required();
    addLevelOption(command, options->level, 0);
    command.add_option("-o,--output", options->output, "The refined lattice: .ovm, .vtu or .vtk")
        ->required();
    addRefinementOptions(command, options->common);
    addRunOptions(command, options->common);
    command.callback([options] { run(*options); });
}

}  // namespace espalier::cli
