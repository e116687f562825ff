// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#ifdef ESPALIER_WITH_CGNS
#include <espalier/io/cgns/cgns_model.h>
#endif
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <exception>
#include <fstream>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#ifdef ESPALIER_WITH_TBB
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>
#endif

#include "command_tree.h"
#include "commands.h"
#include "options.h"
#include "run.h"
#include "standard_streams.h"
#include "version.h"

namespace {

using namespace espalier;

#ifdef ESPALIER_WITH_TBB

/// While an object lives, the worker threads block all signals, so that signals that end the
/// program reach the main thread only. If the main thread blocks them too (io::SignalsBlocked), the
/// signals wait.
class SignalsToMainThread : public tbb::task_scheduler_observer {
public:
    SignalsToMainThread() {
        // This call makes the data of this thread. If observe() had to and memory ran out, the
        // destructor of oneTBB's class would read data that are not there.
        tbb::this_task_arena::isolate([] {});
        observe(true);
    }
    ~SignalsToMainThread() override { observe(false); }

    /// oneTBB calls this when a thread begins to work.
    void on_scheduler_entry(bool isWorker) override {
        if (!isWorker) return;
        ::sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
    }
};

#endif

/// Returns the bytes of memory of the machine, or of the container if that has less.
std::uint64_t machineMemory() {
    auto bytes = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                 static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    std::uint64_t ofContainer = 0;
    if (std::ifstream("/sys/fs/cgroup/memory.max") >> ofContainer)  // "max" is not a number
        bytes = std::min(bytes, ofContainer);
    return bytes;
}

/// The limit that --max-memory sets. A MemoryLimit refuses work that takes more, before or while it
/// runs; a resource limit makes the system refuse more as well.
struct MemoryOption {
    std::uint64_t bytes = machineMemory() / 2;
    std::optional<MemoryLimit> limit;

    void apply() {
        limit.emplace(bytes);
        // The system counts reserved memory, used or not, and the stacks of threads.
        constexpr std::uint64_t kPerThread = 16 << 20;
        const std::uint64_t slack = kPerThread * (2 + std::thread::hardware_concurrency());
        const std::uint64_t most = std::max(bytes, bytes + slack);  // The sum may overflow.
        ::rlimit data{};
        if (::getrlimit(RLIMIT_DATA, &data) != 0) return;
        data.rlim_cur = std::min<std::uint64_t>(data.rlim_max, most);
        ::setrlimit(RLIMIT_DATA, &data);  // Where it fails, the limit of the library remains.
    }
};

/// Returns the number of bytes that a size such as 4GB means; nothing for another text, and for 0.
std::optional<std::string> bytesOf(std::string size) {
    std::uint64_t number = 0;
    try {
        // CLI::AsSizeValue would read -1 as the largest number.
        if (!size.starts_with('-') && CLI::AsSizeValue(true)(size).empty() &&
            CLI::detail::lexical_cast(size, number) && number > 0)
            return size;
    } catch (const CLI::ValidationError&) {
        // It throws where it does not know the unit.
    }
    return std::nullopt;
}

/// Adds --max-memory to a command and its subcommands.
void addTo(CLI::App& command, MemoryOption& setting) {
    const CLI::Validator asSize(
        [](std::string& text) {
            if (const auto bytes = bytesOf(text)) {
                text = *bytes;
                return std::string();
            }
            return "expected a size above 0, such as 500MB or 4GB, got " + cli::shown(text);
        },
        "");
    command
        .add_option(
            "--max-memory", setting.bytes,
            "Limit on the memory, such as 500MB or 4GB: work that would take more is an error")
        ->transform(asSize)
        ->option_text("SIZE [half of the machine's]");
    for (CLI::App* inner : command.get_subcommands({})) addTo(*inner, setting);
}

/// Exit codes of the program.
enum Exit { kSuccess = 0, kBadInput = 1, kUsage = 2, kCheckFailed = 3 };

int run(int argumentCount, char** arguments) {
    using namespace espalier::cli;
    CLI::App program(
        "Deforms 3D models by lattices of any polyhedral topology, and writes the matrices that do "
        "it",
        "espalier");
    program.set_version_flag("--version", versionText());
    // Printed as the version is: without a subcommand, and with exit code 0.
    program.add_flag_callback(
        "--man", [&program] { throw CLI::CallForVersion(manPage(program, ESPALIER_VERSION), 0); },
        "Print the manual page; espalier --man | man -l - shows it");
    program
        .add_option_function<std::string>(
            "--completion",
            [&program](const std::string& shell) {
                throw CLI::CallForVersion(completionScript(program, shell), 0);
            },
            "Print the script by which a shell completes commands and options")
        ->type_name("bash|zsh");
    program.require_subcommand(1);
    program.get_formatter()->column_width(34);
    addInfoCommand(program);
    addShapeCommand(program);
    addPoseCommand(program);
    addRefineCommand(program);
    addStencilsCommand(program);
    addDeformCommands(program);
    addBenchCommand(program);
    addFitCommand(program);
    addCheckCommand(program);
    addPageCommand(program);
    addCompareCommand(program);
    program.footer(
        std::string("espalier help COMMAND lists the options of a command.\nExit codes: ") +
        kExitCodes);
    const auto memory = std::make_shared<MemoryOption>();
    checkValues(program);
    for (CLI::App* command : program.get_subcommands({})) addTo(*command, *memory);
    program.parse_complete_callback([memory] { memory->apply(); });
#ifdef ESPALIER_WITH_TBB
    const SignalsToMainThread signals;
#endif
    std::vector<std::string> words(arguments + std::min(argumentCount, 1),
                                   arguments + argumentCount);
    if (!words.empty() && words.front() == "help") {
        words.erase(words.begin());
        words.push_back("--help");
    }
    const CLI::App* command = &program;
    try {
        command = &findCommand(program, words);
        if (!command->get_subcommands({}).empty() &&
            (words.empty() || words.back() == command->get_name())) {
            const bool isProgram = command == &program;
            fmt::print("{}", command->help(isProgram ? "" : program.get_name()));
            printError("expected a command, as listed above");
            return kUsage;
        }
        endNumbers(*command, words);
        std::ranges::reverse(words);  // as the parser takes them
        program.parse(std::move(words));
    } catch (const CLI::Success& helpOrVersion) {
        program.exit(helpOrVersion);
    } catch (const CLI::ParseError& error) {
        printError(error.what());
        return kUsage;
    } catch (const ArgumentError& error) {
        const auto message = messageOnOption(*command, error);
        if (!message) throw;
        printError(message->c_str());
        return kUsage;
    }
    return kSuccess;
}

}  // namespace

int main(int argumentCount, char** arguments) {
    using namespace espalier::cli;
#ifdef ESPALIER_WITH_CGNS
    espalier::io::addCgnsModels();
#endif
    holdStandardStreams();
    try {
        const int code = run(argumentCount, arguments);
        flushOutput();
        return code;
    } catch (const FailedCheck& failure) {
        printError(failure.what());
        return kCheckFailed;
    } catch (const OutOfMemory& error) {
        printPrintableError(error.what());
    } catch (const std::bad_alloc&) {
        printPrintableError(OutOfMemory().what());
    } catch (const std::length_error&) {
        // A container would have become larger than memory.
        printPrintableError(OutOfMemory().what());
    } catch (const std::system_error& error) {
        printError(error);
    } catch (const std::exception& error) {
        printError(error.what());
    }
    return kBadInput;
}
