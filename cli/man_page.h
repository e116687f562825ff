// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace espalier::cli {

/// Explains the exit codes, in the help and in the manual page.
inline constexpr const char* kExitCodes =
    "0 success; 1 bad input; 2 wrong usage; 3 check found inverted cells, or compare found "
    "differences.";

/// Returns the manual page of the program, for `man`: every command with its options, as the help
/// of the command states them. Options that many commands share are described once, in a section of
/// their own.
std::string manPage(const CLI::App& program, const std::string& version);

}  // namespace espalier::cli
