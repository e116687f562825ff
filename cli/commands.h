// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

namespace espalier::cli {

// Each function adds one command, or a family of them, to the program. A command runs when the
// arguments have been parsed. An exception ends the program with exit code 1; 2 for an
// exception of the parser, or an ArgumentError about an option; 3 for FailedCheck (see main.cpp).

/// The input is good, but the check of a command failed: cells are inverted, or shapes differ.
class FailedCheck : public Error {
public:
    using Error::Error;
};

/// A command, and the options that CLI11 parses its arguments into.
template <class Options>
struct Command {
    CLI::App& app;
    Options& options;
};

/// Adds a command that calls `run` with its options when they have been parsed. The caller adds the
/// arguments.
template <class Options>
Command<Options> addCommand(CLI::App& program, const std::string& name, const std::string& help,
                            void (*run)(const Options&)) {
    const auto options = std::make_shared<Options>();
    CLI::App& app = *program.add_subcommand(name, help);
    app.callback([options, run] { run(*options); });
    return {app, *options};
}

void addInfoCommand(CLI::App& program);
void addShapeCommand(CLI::App& program);
void addAroundCommand(CLI::App& shape);  ///< a subcommand of shape
void addCageCommand(CLI::App& shape);    ///< a subcommand of shape
void addCollarCommand(CLI::App& shape);  ///< a subcommand of shape
void addPoseCommand(CLI::App& program);
void addRefineCommand(CLI::App& program);
void addStencilsCommand(CLI::App& program);
void addCompareCommand(CLI::App& program);
void addDeformCommands(CLI::App& program);  ///< deform, bind and apply
void addBenchCommand(CLI::App& program);
void addFitCommand(CLI::App& program);
void addCheckCommand(CLI::App& program);
void addPageCommand(CLI::App& program);

}  // namespace espalier::cli
