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
    checkOutput(options.output, {options.lattice});
    Stages stages(options.common.quiet);
    const Lattice base = readInput(options, FileKind::LatticeOrMesh, stages);
    const int dimension = base.complex.dimension();
    io::checkRefinableTarget(options.output, dimension);
    const far::TopologyRefiner refiner = stages.run("refining", [&] {
        return refineLattice(options.lattice, base, options.common, options.level);
    });
    const Lattice refined = stages.run(
        "placing", [&] { return refinedLattice(refiner, options.level, options.common, base); });
    stages.run("writing", [&] { io::writeRefinable(options.output, refined); });
    if (!options.common.quiet)
        fmt::print("{}: level {}, {} vertices, {} {}\n", options.output, options.level,
                   refined.complex.count(0), refined.complex.count(dimension),
                   dimension == 3 ? "cells" : "faces");
}

}  // namespace

void addRefineCommand(CLI::App& program) {
    auto options = std::make_shared<Options>();
    CLI::App& command = addLatticeCommand(
        program, "refine",
        "Write level N of a lattice or a mesh: positions, cells or faces, attributes and marks",
        FileKind::LatticeOrMesh, *options);
    command
        .add_option("-o,--output", options->output,
                    "The refined lattice: .ovm, .vtu or .vtk; or mesh: .obj")
        ->required();
    command.callback([options] { run(*options); });
}

}  // namespace espalier::cli
