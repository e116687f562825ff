// SPDX-License-Identifier: Apache-2.0
#include "distinct_outputs.h"

#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>
#include <fmt/format.h>

#include <map>
#include <system_error>

namespace espalier::cli {

namespace fs = std::filesystem;

namespace {

/// The path behind all links, those to what does not exist yet too.
fs::path behindLinks(fs::path path) {
    constexpr int kMaxLinks = 40;  // as the system has it
    std::error_code error;
    for (int links = 0; links < kMaxLinks && fs::is_symlink(path, error); ++links)
        path = path.parent_path() / fs::read_symlink(path, error);
    const fs::path canonical = fs::weakly_canonical(fs::absolute(path, error), error);
    return error ? path : canonical;
}

}  // namespace

void checkDistinct(const std::vector<fs::path>& outputs) {
    std::map<fs::path, fs::path> files;
    std::error_code ignored;
    for (const fs::path& output : outputs) {
        if (fs::exists(output, ignored) && !fs::is_regular_file(output, ignored)) continue;
        const auto [other, isNew] = files.try_emplace(behindLinks(output), output);
        if (!isNew)
            throw io::FileError(
                output, fmt::format("is the same file as {}, through a link: one of the two would "
                                    "be lost. Remove the link",
                                    printable(other->second.string())));
    }
}

}  // namespace espalier::cli
