// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace espalier::cli {

// Each adds one command, or a family of them, to the program. A command runs when the arguments
// have been parsed; what it throws ends the program with exit code 1 (see main.cpp).

void addInfoCommand(CLI::App& program);
void addShapeCommand(CLI::App& program);
void addRefineCommand(CLI::App& program);
void addStencilsCommand(CLI::App& program);
void addCompareCommand(CLI::App& program);
void addDeformCommands(CLI::App& program);  ///< deform, bind and apply
void addBenchCommand(CLI::App& program);
void addFitCommand(CLI::App& program);
void addCheckCommand(CLI::App& program);

}  // namespace espalier::cli
