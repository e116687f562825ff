// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>

namespace espalier::cli {

/// Returns the command that the words of a command line name: `espalier shape box` for "shape",
/// "box", "--cells" ..., and the program for none. To be called before the words are parsed, since
/// the parser reports a missing option before an unknown one.
/// \throws CLI::ValidationError naming the first word that should be a command or an option and is
/// none,
///         and the nearest name
const CLI::App& findCommand(const CLI::App& program, std::span<const std::string> words);

}  // namespace espalier::cli
