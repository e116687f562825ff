// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace espalier::cli {

/// Adds --max-memory to every command of the program, and keeps to it while a command runs: what
/// is known to take more is refused, and so is what turns out to (MemoryLimit). What takes
/// more than that sees gets none from the system.
void addMemoryOption(CLI::App& program);

}  // namespace espalier::cli
