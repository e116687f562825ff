// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>
#include <espalier/io/lattice_file.h>
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
    io::checkLatticeTarget(options.output);
    checkOutput(options.output, {options.lattice});
    Stages stages(options.common.quiet);
    const RefinedFile file = readAndRefine(options, stages);
    const Lattice refined = stages.run("placing", [&] {
        return refinedLattice(file.refiner, options.level, options.common, file.lattice);
    });
    stages.run("writing", [&] { io::writeLattice(options.output, refined); });
    if (!options.common.quiet)
        fmt::print("{}: level {}, {} vertices, {} cells\n", options.output, options.level,
                   refined.complex.count(0), refined.complex.count(3));
}

}  // namespace

void addRefineCommand(CLI::App& program) {
    auto options = std::make_shared<Options>();
    CLI::App& command = addLatticeCommand(
        program, "refine", "Write level N of a lattice: positions, cells, attributes and marks",
        *options);
    command.add_option("-o,--output", options->output, "The refined lattice: .ovm, .vtu or .vtk")
        ->required();
    command.callback([options] { run(*options); });
}

}  // namespace espalier::cli
