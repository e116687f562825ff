// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

// The commands and options of the program, for texts that are made of them: the manual page, the
// completion of shells, suggestions for misspelt words.
namespace espalier::cli {

/// Calls `visit` for each command, and each command in it after it, in the order of the help.
/// \param visit is called with a command and its whole name: "espalier shape box"
void forEachCommand(const CLI::App& program,
                    const std::function<void(const CLI::App&, const std::string&)>& visit);

/// Returns the options and arguments of a command, without --help, which every command has.
std::vector<const CLI::Option*> optionsOf(const CLI::App& command);

/// Returns the names of an option, {"-n", "--level"}; empty for an argument.
std::vector<std::string> namesOf(const CLI::Option& option);

}  // namespace espalier::cli
