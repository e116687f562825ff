// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/embedding.h>
#include <espalier/far/strata.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/masks.h>

#include <CLI/CLI.hpp>
#include <string>

namespace espalier::cli {

/// What every command takes.
struct CommonOptions {
    RefinementTags refinement;  ///< set where an option was given; it wins over the file's tags
    far::SharpEdges sharpEdges = far::SharpEdges::SingleCell;
    stencils::Rules rules = stencils::Rules::Siggraph96;
    embed::EmbeddingOptions embedding;
    bool quiet = false;
    int threads = 0;
};

/// What the commands take that look at one lattice or, some of them, mesh or curve.
struct LatticeOptions {
    CommonOptions common;
    std::string lattice;
    int level = 2;
};

/// Which files a command takes.
enum class FileKind {
    Lattice,
    Refinable  ///< a lattice, a mesh or a curve
};

/// Adds a command with LATTICE, -n, and the options of refinement and of the run.
CLI::App& addLatticeCommand(CLI::App& program, const std::string& name, const std::string& help,
                            FileKind kind, LatticeOptions& options);

/// The rules that a command offers.
enum class RulesFor {
    OpenSubdiv,  ///< Catmull-Clark's alone
    Lattices,    ///< `mlca` too
    Anything     ///< and `rats`, which are none for lattices
};

/// Adds --boundary, --creasing, --triangles, --sharp-edges and --rules to a command.
void addRefinementOptions(CLI::App& command, CommonOptions& options,
                          RulesFor rulesFor = RulesFor::Lattices);

/// Adds --outside and --tolerance to a command.
void addEmbeddingOptions(CLI::App& command, CommonOptions& options);

/// Adds --quiet and --threads to a command.
void addRunOptions(CLI::App& command, CommonOptions& options);

/// Adds -n to a command.
void addLevelOption(CLI::App& command, int& level, int least);

}  // namespace espalier::cli
