// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace espalier::cli {

/// Returns the manual page of the program, for `man`: every command with its options, as the help
/// of the command states them. Options that many commands share are described once, in a section of
/// their own.
std::string manPage(const CLI::App& program, const std::string& version);

}  // namespace espalier::cli
