// SPDX-License-Identifier: Apache-2.0
#include "memory_option.h"

#include <espalier/base/memory.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>

namespace espalier::cli {
namespace {

/// Bytes of memory that there are for this process: the machine's, or its container's.
std::uint64_t machineMemory() {
    auto bytes = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                 static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    std::uint64_t ofContainer = 0;
    if (std::ifstream("/sys/fs/cgroup/memory.max") >> ofContainer)  // "max" is no number
        bytes = std::min(bytes, ofContainer);
    return bytes;
}

/// What the option is set to, and what comes of it.
struct Setting {
    std::uint64_t bytes = machineMemory() / 2;
    std::optional<MemoryLimit> limit;

    void apply() {
        limit.emplace(bytes);
        // The system counts what is promised, not what is used, and the stacks of threads.
        constexpr std::uint64_t kPerThread = 16 << 20;
        const std::uint64_t slack = kPerThread * (2 + std::thread::hardware_concurrency());
        const std::uint64_t most = std::max(bytes, bytes + slack);  // It may be the largest number.
        ::rlimit data{};
        if (::getrlimit(RLIMIT_DATA, &data) != 0) return;
        data.rlim_cur = std::min<std::uint64_t>(data.rlim_max, most);
        ::setrlimit(RLIMIT_DATA, &data);  // Where it fails, the limit of the library remains.
    }
};

void addTo(CLI::App& command, Setting& setting) {
    const CLI::Validator asSize(
        [](std::string& text) {
            // Not for CLI::AsSizeValue, to which -1 is the largest number.
            const std::string error =
                text.starts_with('-') ? "expected more than 0" : CLI::AsSizeValue(true)(text);
            return error.empty() && text == "0" ? "expected more than 0" : error;
        },
        "");
    command
        .add_option("--max-memory", setting.bytes,
                    "Memory at most: work that would take more is an error. 500MB, 4GB ...")
        ->transform(asSize)
        ->option_text("SIZE [half of the machine's]");
    for (CLI::App* inner : command.get_subcommands({})) addTo(*inner, setting);
}

}  // namespace

void addMemoryOption(CLI::App& program) {
    const auto setting = std::make_shared<Setting>();
    for (CLI::App* command : program.get_subcommands({})) addTo(*command, *setting);
    program.parse_complete_callback([setting] { setting->apply(); });
}

}  // namespace espalier::cli
