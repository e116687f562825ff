// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/printable.h>
#include <espalier/io/lattice_file.h>
#include <fmt/format.h>

#include <memory>

#include "commands.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

struct RefineOptions : LatticeOptions {
    std::string output;
};

void runRefine(const RefineOptions& options) {
    const ThreadLimit limit(options.common.threads);
    checkOutput(options.output, {{"LATTICE|MESH|CURVE", options.lattice}});
    Stages stages(options.common.quiet);
    const Lattice base = readLattice(options.lattice, stages, FileKind::Refinable);
    warnOfNonFinite(options.lattice, base);
    const int dimension = base.complex.dimension();
    io::checkRefinableTarget(options.output, dimension);
    const far::TopologyRefiner refiner = stages.run("refining", [&] {
        return refineLattice(options.lattice, base, options.common, options.level);
    });
    const Lattice refined = stages.run(
        "placing", [&] { return refinedLattice(refiner, options.level, options.common, base); });
    stages.run("writing", [&] { io::writeRefinable(options.output, refined); });
    if (!options.common.quiet)
        fmt::print("{}: level {}, {} vertices, {} {}\n", printable(options.output), options.level,
                   refined.complex.count(0), refined.complex.count(dimension),
                   kNamesOfParts[dimension]);
}

}  // namespace

void addRefineCommand(CLI::App& program) {
    auto options = std::make_shared<RefineOptions>();
    CLI::App& command = addLatticeCommand(
        program, "refine",
        "Write level N of a lattice, a mesh or a curve: positions, topology, attributes and marks",
        FileKind::Refinable, *options);
    command
        .add_option("-o,--output", options->output,
                    "The refined lattice: .ovm, .vtu or .vtk; or mesh or curve: .obj")
        ->required();
    command.callback([options] { runRefine(*options); });
}

}  // namespace espalier::cli
