// SPDX-License-Identifier: Apache-2.0
#include "options.h"

#include <vector>

namespace espalier::cli {

void addLatticeOptions(CLI::App& command, FileKind kind, LatticeOptions& options) {
    const bool isAny = kind == FileKind::Refinable;
    command
        .add_option(isAny ? "LATTICE|MESH|CURVE" : "LATTICE", options.lattice,
                    isAny ? "The lattice: .ovm, .vtu or .vtk; or the mesh or curve: .obj"
                          : "The lattice: .ovm, .vtu or .vtk")
        ->required();
    addLevelOption(command, options.level, 0);
    addRefinementOptions(command, options.common, isAny ? RulesFor::Anything : RulesFor::Lattices);
    addRunOptions(command, options.common);
}

void addRefinementOptions(CLI::App& command, CommonOptions& options, RulesFor rulesFor) {
    const std::string unlessTagged = ", unless the file says otherwise";
    addChoice<far::Boundary>(
        command, "--boundary", options.refinement.boundary, far::kBoundaryWords,
        "Corners, sharp edges and boundary surfaces by their own rules; the same without the "
        "corners of single cells or faces; or a region that shrinks",
        "sharp" + unlessTagged);
    addChoice<far::Creasing>(command, "--creasing", options.refinement.creasing,
                             far::kCreasingWords, "How semi-sharp edges lose sharpness",
                             "uniform" + unlessTagged);
    addChoice<far::TriangleSubdivision>(
        command, "--triangles", options.refinement.triangles, far::kTriangleSubdivisionWords,
        "Weights of triangles on a surface", "catmark" + unlessTagged);
    addChoice<far::SharpEdges>(
        command, "--sharp-edges", options.sharpEdges, far::kSharpEdgesWords,
        "Sharp are boundary edges in one cell, or those between vertices of at most two cells");
    std::vector<Word<far::Rules>> rules;
    for (const auto& word : far::kRulesWords)
        if ((word.choice != far::Rules::Mlca || rulesFor != RulesFor::OpenSubdiv) &&
            (word.choice != far::Rules::Rats || rulesFor == RulesFor::Anything))
            rules.push_back(word);
    std::string help = "Catmull-Clark, in two editions for the edges inside a lattice";
    if (rulesFor != RulesFor::OpenSubdiv) help += "; multilinear cell averaging";
    if (rulesFor == RulesFor::Anything) help += "; or RATS splines, for curves and meshes";
    addChoice<far::Rules>(command, "--rules", options.rules, rules, help);
}

void addEmbeddingOptions(CLI::App& command, CommonOptions& options) {
    // Not CLI::Range, which lets NaN pass.
    const CLI::Validator isFraction(
        [](std::string& text) {
            double number = 0;
            const bool isOne =
                CLI::detail::lexical_cast(text, number) && number >= 0 && number <= 1;
            return isOne ? std::string() : "expected 0 to 1, got " + text;
        },
        "");
    addChoice<embed::OutsidePolicy>(command, "--outside", options.embedding.outside,
                                    embed::kOutsidePolicyWords,
                                    "Points outside the lattice stay in place, go with the "
                                    "nearest place in it, or are an error");
    command
        .add_option("--tolerance", options.embedding.tolerance,
                    "How far outside still counts as inside, as a fraction of the lattice's size")
        ->check(isFraction)
        ->capture_default_str();
}

void addRunOptions(CLI::App& command, CommonOptions& options) {
    command.add_flag("--quiet", options.quiet, "Print nothing but errors");
    command.add_option("--threads", options.threads, "Threads at most; 0 is one a core")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
}

void addLevelOption(CLI::App& command, int& level, int least) {
    // Level 15 of a single cell would have 8¹⁵ cells, far more than an index counts.
    constexpr int kMaxLevel = 15;
    command.add_option("-n,--level", level, "Refinement level")
        ->check(CLI::Range(least, kMaxLevel))
        ->capture_default_str();
}

}  // namespace espalier::cli
