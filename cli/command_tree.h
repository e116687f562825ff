// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <span>
#include <string>
#include <vector>

// The commands and options of the program, and the texts that follow from them: the manual page,
// the completion of shells, suggestions for misspelt words.
namespace espalier::cli {

/// Calls `visit` for each command, and each command in it after it, in the order of the help.
/// \param visit is called with a command and its whole name: "espalier shape box"
void forEachCommand(const CLI::App& program,
                    const std::function<void(const CLI::App&, const std::string&)>& visit);

/// Returns the options and arguments of a command, without --help, which every command has.
std::vector<const CLI::Option*> optionsOf(const CLI::App& command);

/// Returns the names of an option, {"-n", "--level"}; empty for an argument.
std::vector<std::string> namesOf(const CLI::Option& option);

/// Returns the command that the words of a command line name: `espalier shape box` for "shape",
/// "box", "--cells" ...; the program if they name no command. Call this before the words are
/// parsed, because the parser reports a missing option before an unknown one.
/// \throws CLI::ValidationError naming the first word that is no known command or option where one
///         is expected, and the nearest name
const CLI::App& findCommand(const CLI::App& program, std::span<const std::string> words);

/// Inserts the word -- after the numbers of each option that takes several numbers, so that the
/// parser does not take an argument after them as one more number: `--cells 4 MODEL`. The words
/// that the option requires may be of any kind, as in `--select end +z LATTICE`. \param command the
/// command that the words name, as findCommand() returns it
void endNumbers(const CLI::App& command, std::vector<std::string>& words);

/// Returns a script by which a shell completes commands, options and the words that options take,
/// and names of files everywhere else.
/// \param shell "bash", for a file that bash sources; or "zsh", for a file _espalier in its $fpath
/// \throws CLI::ValidationError for another shell
std::string completionScript(const CLI::App& program, const std::string& shell);

/// Explains the exit codes, in the help and in the manual page.
inline constexpr const char* kExitCodes =
    "0 success; 1 bad input; 2 wrong usage; 3 check found inverted cells, or compare found "
    "differences.";

/// Returns the manual page of the program, for `man`. It has the help of each command, and one
/// section with the options that many commands share.
std::string manPage(const CLI::App& program, const std::string& version);

}  // namespace espalier::cli
