// SPDX-License-Identifier: Apache-2.0
#include "entry.h"

#include "fuzz_target.h"

namespace {

espalier::fuzz::Target::Run chosen = nullptr;

}  // namespace

int LLVMFuzzerInitialize(int* argumentCount, char*** arguments) {
    const std::string_view option = "--target=";  // libFuzzer ignores options that begin with "--"
    const std::string_view first = *argumentCount > 1 ? (*arguments)[1] : "";
    const auto& targets = espalier::fuzz::Target::all();
    const auto target = first.starts_with(option)
                            ? targets.find(std::string(first.substr(option.size())))
                            : targets.end();
    if (target == targets.end()) {
        std::fprintf(stderr, "the first argument is --target= with one of\n");
        for (const auto& [name, run] : targets) std::fprintf(stderr, "%s\n", name.c_str());
        std::exit(2);
    }
    chosen = target->second;
    return 0;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    chosen({reinterpret_cast<const char*>(data), size});
    return 0;
}
