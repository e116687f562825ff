// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/pose_file.h>
#include <espalier/stencils/refined_lattice.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "commands.h"
#include "files.h"
#include "job.h"
#include "standard_streams.h"

namespace espalier::cli {
namespace {

struct RefineOptions : LatticeOptions {
    std::string output;
    std::optional<far::FaceVaryingLinear> faceVarying;
};

/// Prints a line to standard error for each attribute with values that are not finite: how many
/// there are, and the first one. To be called between stages. \param path the file that the lattice
/// was read from
void warnOfNonFinite(const std::filesystem::path& path, const Lattice& lattice) {
    const auto isNotFinite = [](double value) { return !std::isfinite(value); };
    for (const auto& [name, components, values] : lattice.attributes) {
        const auto first = std::ranges::find_if(values, isNotFinite);
        if (first == values.end()) continue;
        const auto count = std::count_if(first, values.end(), isNotFinite);
        const std::string text = fmt::format(
            "{}: the attribute {} has {} {} not finite, the first at vertex {} ({}); refined "
            "values "
            "that depend on them are not finite either",
            io::shownPath(path), inQuotes(name), count,
            count == 1 ? "value that is" : "values that are", (first - values.begin()) / components,
            *first);
        printError(text.c_str());
    }
}

void runRefine(const RefineOptions& options) {
    Job job(options.common, {{"LATTICE|MESH|CURVE", options.lattice}});
    job.writes(options.output);
    Stages& stages = job.stages();
    const Lattice base = readLattice(options.lattice, stages, FileKind::Refinable);
    warnOfNonFinite(options.lattice, base);
    const int dimension = base.complex.dimension();
    const bool isEditorMesh =
        dimension == 3 && io::isFileOf(io::FileContent::EditorMesh, options.output);
    if (!isEditorMesh) io::checkRefinableTarget(options.output, dimension);
    const far::TopologyRefiner refiner = stages.run("refining", [&] {
        return refineLattice(options.lattice, base, options.common, options.level);
    });
    const Lattice refined = stages.run("computing positions", [&] {
        return stencils::refinedLattice(refiner, options.level, base, options.faceVarying);
    });
    stages.run("writing", [&] {
        if (isEditorMesh)
            io::writeEditorMesh(options.output, refined);
        else
            io::writeRefinable(options.output, refined);
    });
    if (!options.common.quiet)
        fmt::print("{}: level {}, {} vertices, {} {}\n", printable(options.output), options.level,
                   refined.complex.count(0), refined.complex.count(dimension),
                   kNamesOfParts[dimension]);
}

}  // namespace

void addRefineCommand(CLI::App& program) {
    const auto [command, options] = addCommand(
        program, "refine",
        "Refine a lattice, a mesh or a curve N times, and write it with its attributes and marks",
        runRefine);
    addLatticeOptions(command, FileKind::Refinable, options);
    addOutputOption(
        command, options.output,
        "The refined lattice (" + filesToWrite(io::FileContent::Lattice) +
            "), or its faces for mesh editors (" + filesToWrite(io::FileContent::EditorMesh) +
            "); the refined mesh or curve (" + filesToWrite(io::FileContent::Mesh) + ")")
        ->required();
    addChoice<far::FaceVaryingLinear>(
        command, "--face-varying", options.faceVarying, far::kFaceVaryingLinearWords,
        "Where texture coordinates (vt of a mesh) are linear: OpenSubdiv's face-varying modes",
        "all, unless the file says otherwise");
}

}  // namespace espalier::cli
