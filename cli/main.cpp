// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "commands.h"
#include "memory_option.h"

namespace {

/// Exit codes of the program.
enum Exit { kSuccess = 0, kBadInput = 1, kUsage = 2 };

int run(int argumentCount, char** arguments) {
    using namespace espalier::cli;
    CLI::App program(
        "Deforms models by lattices of arbitrary topology, and gives away the matrices",
        "espalier");
    program.set_version_flag("--version", ESPALIER_VERSION);
    program.require_subcommand(1);
    program.get_formatter()->column_width(34);
    addInfoCommand(program);
    addShapeCommand(program);
    addRefineCommand(program);
    addStencilsCommand(program);
    addDeformCommands(program);
    addBenchCommand(program);
    addFitCommand(program);
    addCheckCommand(program);
    addCompareCommand(program);
    addMemoryOption(program);
    try {
        program.parse(argumentCount, arguments);
    } catch (const CLI::Success& helpOrVersion) {
        program.exit(helpOrVersion);
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "espalier: {}\n", error.what());
        return kUsage;
    }
    return kSuccess;
}

}  // namespace

int main(int argumentCount, char** arguments) {
    try {
        const int code = run(argumentCount, arguments);
        if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
        fmt::print(stderr, "espalier: cannot write to standard output\n");
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "espalier: out of memory\n");
    } catch (const std::exception& error) {
        fmt::print(stderr, "espalier: {}\n", error.what());
    }
    return kBadInput;
}
