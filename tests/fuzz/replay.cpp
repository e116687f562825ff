// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "entry.h"

/// Replaces libFuzzer in builds without it. Runs the target that the first argument names on every
/// file of the folders that the other arguments name.
int main(int argumentCount, char** arguments) {
    namespace fs = std::filesystem;
    LLVMFuzzerInitialize(&argumentCount, &arguments);
    std::vector<fs::path> files;
    for (int i = 2; i < argumentCount; ++i)
        for (const auto& entry : fs::recursive_directory_iterator(arguments[i]))
            if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
        std::printf("%s\n", file.c_str());
        std::fflush(stdout);  // so that the output shows at which file the target aborted
        const std::string bytes = espalier::io::readFile(file);
        LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    }
    std::printf("%zu inputs\n", files.size());
    return files.empty() ? 1 : 0;  // An empty corpus tests nothing.
}
