// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>

#include <CLI/CLI.hpp>

namespace espalier::cli {

// Each adds one command, or a family of them, to the program. A command runs when the arguments
// have been parsed; what it throws ends the program with exit code 1, or 3 for Finding (see
// main.cpp).

/// The input is good, and the answer to the question that a command asks of it is no: cells are
/// inverted, or shapes differ.
class Finding : public Error {
public:
    using Error::Error;
};

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
