// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/word.h>
#include <espalier/embed/embedding.h>
#include <espalier/far/strata.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>

#include <CLI/CLI.hpp>
#include <map>
#include <span>
#include <string>
#include <type_traits>

namespace espalier::cli {

/// An option that takes one of a few words; the help shows them and the default.
///
/// \param value a Choice, or a std::optional of one that says what is done without the option
template <class Choice, class Value>
CLI::Option* addChoice(CLI::App& command, const std::string& name, Value& value,
                       std::type_identity_t<std::span<const Word<Choice>>> words,
                       const std::string& help, std::string fallback = {}) {
    std::map<std::string, Choice> choices;
    for (const Word<Choice>& word : words) {
        choices.emplace(word.text, word.choice);
        if (value == word.choice) fallback = word.text;
    }
    std::string names;
    for (const auto& [word, choice] : choices) names += (names.empty() ? "" : "|") + word;
    const CLI::Validator isWord(
        [choices, names](std::string& text) {
            return choices.contains(text) ? std::string() : "expected " + names + ", got " + text;
        },
        "");
    return command
        .add_option_function<std::string>(
            name, [&value, choices](const std::string& text) { value = choices.at(text); }, help)
        ->check(isWord)
        ->type_name(names)
        ->default_str(fallback);
}

/// What every command takes.
struct CommonOptions {
    RefinementTags refinement;  ///< set where an option was given; it wins over the file's tags
    far::SharpEdges sharpEdges = far::SharpEdges::SingleCell;
    far::Rules rules = far::Rules::Siggraph96;
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

/// Adds LATTICE, -n, and the options of refinement and of the run.
void addLatticeOptions(CLI::App& command, FileKind kind, LatticeOptions& options);

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
