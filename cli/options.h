// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/argument_error.h>
#include <espalier/base/memory.h>
#include <espalier/base/word.h>
#include <espalier/embed/embedding.h>
#include <espalier/far/strata.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/formats.h>
#include <espalier/shapes/lattice.h>

#include <CLI/CLI.hpp>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

namespace espalier::cli {

/// Returns the formats of files with this content, for help texts.
std::string filesToRead(io::FileContent content);
std::string filesToWrite(io::FileContent content);

/// Returns a word as messages show it: "nothing" for an empty word.
std::string shown(const std::string& word);

/// Adds an option that takes one of a few words. The help shows the words and the default.
///
/// \param value a Choice, or a std::optional of one, with the default
/// \param fallback the default that the help shows if `value` is an empty optional
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
            return choices.contains(text) ? std::string()
                                          : "expected " + names + ", got " + shown(text);
        },
        "");
    return command
        .add_option_function<std::string>(
            name, [&value, choices](const std::string& text) { value = choices.at(text); }, help)
        ->check(isWord)
        ->type_name(names)
        ->default_str(fallback);
}

/// The options that most commands have.
struct CommonOptions {
    RefinementTags refinement;  ///< set by options, which win over the tags of the file
    far::SharpEdges sharpEdges = far::SharpEdges::SingleCell;
    far::Rules rules = far::Rules::Siggraph96;
    embed::EmbeddingOptions embedding;
    double falloff = 0;                    ///< see bind::BindOptions::falloff
    const CLI::Option* outside = nullptr;  ///< --outside, if the command has it
    bool quiet = false;
    bool strict = false;  ///< notes on models are errors
    int threads = 0;
};

/// The options of commands that read one lattice, mesh or curve.
struct LatticeOptions {
    CommonOptions common;
    std::string lattice;
    int level = 2;
};

/// The kinds of files that a command reads.
enum class FileKind {
    Lattice,
    Refinable  ///< a lattice, a mesh or a curve
};

/// Adds LATTICE, -n, and the options of refinement and of the run.
void addLatticeOptions(CLI::App& command, FileKind kind, LatticeOptions& options);

/// The sets of rules that --rules offers.
enum class RulesFor {
    OpenSubdiv,  ///< the rules of Catmull-Clark only
    Lattices,    ///< also `mlca`
    Anything     ///< also `rats`, which are for curves and meshes only
};

/// Adds --boundary, --creasing, --triangles, --sharp-edges and --rules to a command.
void addRefinementOptions(CLI::App& command, CommonOptions& options,
                          RulesFor rulesFor = RulesFor::Lattices);

/// Adds --outside and --tolerance to a command.
void addEmbeddingOptions(CLI::App& command, CommonOptions& options);

/// Adds --quiet and --threads to a command.
void addRunOptions(CLI::App& command, CommonOptions& options);

/// Adds --strict to a command that reads models.
void addStrictOption(CLI::App& command, CommonOptions& options);

/// Adds an option that names a file to write, and refuses "-" for it. Returns it, to be required.
CLI::Option* addOutputOption(CLI::App& command, std::string& path, const std::string& help,
                             const std::string& name = "-o,--output");

/// Adds --move-held, for commands that move a lattice.
void addMoveHeldOption(CLI::App& command, bool& movesHeld);

/// Returns the value of a word that is a finite number; nothing for any other word.
std::optional<double> numberOf(const std::string& word);

/// Returns a check that a word is a finite number.
/// \param words all words of the option, for the message: "the numbers X Y Z", "AXIS DEGREES"
CLI::Validator isNumberOf(const std::string& words);

/// Accepts whole numbers from `least` to `most`; by default, those that fit into an int.
CLI::Validator isWholeNumber(double least = std::numeric_limits<int>::min(),
                             double most = std::numeric_limits<int>::max());

/// Lets an option take several numbers, with spaces or commas between them.
/// \param names the numbers in the help: "X Y Z"
CLI::Option* takeNumbers(CLI::Option* option, const std::string& names);

/// Adds an option that takes several numbers, with spaces or commas between them.
///
/// \param value an array or a vector of numbers, or a std::optional of one
/// \param names the numbers in the help: "X Y Z"
template <class Value>
CLI::Option* addNumbers(CLI::App& command, const std::string& name, Value& value,
                        const std::string& names, const std::string& help) {
    CLI::Option* const option = takeNumbers(command.add_option(name, value, help), names);
    if constexpr (requires { requires std::is_same_v<typename Value::value_type, int>; })
        option->check(isWholeNumber());
    return option;
}

/// Returns the message of an error with the names of the options of a command, "--minor-radius:
/// expected a number below --major-radius (1), got 3"; nothing if no option sets the field.
std::optional<std::string> messageOnOption(const CLI::App& command, const ArgumentError& error);

/// Accepts finite numbers above 0, up to `most`. (CLI::PositiveNumber accepts infinity, and its
/// message has a number of 309 digits.)
CLI::Validator aboveZero(double most = std::numeric_limits<double>::max());

/// Accepts numbers from `least` to `most`. (CLI::Range accepts NaN.)
/// \param whole only whole numbers
CLI::Validator inRange(double least, double most, bool whole = false);

/// Lets all options of a command and its subcommands refuse words that are no finite number where
/// they take a number, that are no whole number where they take one, and that are empty where they
/// take the name of a file. Call this when all options are there.
void checkValues(CLI::App& command);

/// Adds -n to a command.
void addLevelOption(CLI::App& command, int& level, int least);

}  // namespace espalier::cli
