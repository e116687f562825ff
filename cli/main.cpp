// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>

#include "commands.h"
#include "memory_option.h"
#include "run.h"
#include "standard_streams.h"
#include "worker_signals.h"

namespace {

/// Exit codes of the program.
enum Exit { kSuccess = 0, kBadInput = 1, kUsage = 2, kFinding = 3 };

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
    const SignalsToMainThread signals;
    try {
        program.parse(argumentCount, arguments);
    } catch (const CLI::Success& helpOrVersion) {
        program.exit(helpOrVersion);
    } catch (const CLI::ParseError& error) {
        printError(error.what());
        return kUsage;
    }
    return kSuccess;
}

}  // namespace

int main(int argumentCount, char** arguments) {
    using namespace espalier::cli;
    holdStandardStreams();
    try {
        const int code = run(argumentCount, arguments);
        flushOutput();
        return code;
    } catch (const Finding& finding) {
        printError(finding.what());
        return kFinding;
    } catch (const OutOfMemory& error) {
        printPrintableError(error.what());
    } catch (const std::bad_alloc&) {
        printError("out of memory");
    } catch (const std::length_error&) {
        // Of a container that would hold more than memory could.
        printError("out of memory");
    } catch (const std::system_error& error) {
        printError(error);
    } catch (const std::exception& error) {
        printError(error.what());
    }
    return kBadInput;
}
