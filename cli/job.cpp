// SPDX-License-Identifier: Apache-2.0
#include "job.h"

#include <espalier/base/parallel.h>
#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <optional>
#include <span>
#include <system_error>

namespace espalier::cli {
namespace {

/// Limits the number of threads that work until the process ends; 0 or less: no limit.
void limitThreads(int threads) {
    // Never destroyed: when a limit ends, oneTBB may start threads, and ends the program if there
    // is no memory for their stacks.
    [[maybe_unused]] static const auto* const limit = new ThreadLimit(threads);
}

/// Returns the status of the file that a path names; nothing if there is no such file.
/// (std::filesystem::equivalent() fails for two pipes.)
std::optional<struct ::stat> statusOf(const std::filesystem::path& path) {
    struct ::stat status {};
    if (::stat(path.c_str(), &status) != 0) return std::nullopt;
    return status;
}

bool isSameFile(const struct ::stat& a, const struct ::stat& b) {
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// Joins words: "--rest", "MODEL and --rest", "MODEL, --rest and --to".
std::string list(std::span<const std::string> words) {
    std::string text = words.front();
    for (std::size_t i = 1; i < words.size(); ++i)
        text += (i + 1 < words.size() ? ", " : " and ") + words[i];
    return text;
}

void refuseDash(const std::vector<Argument>& inputs) {
    std::vector<std::string> arguments;
    for (const Argument& input : inputs)
        if (std::ranges::count(input.paths, "-") > 0) arguments.push_back(input.name);
    if (arguments.empty() || statusOf("-")) return;
    throw io::FileError("-", "does not exist (given for " + list(arguments) +
                                 "). To read one argument from standard input, make a link to "
                                 "/dev/stdin with the extension of the format, and name the link");
}

/// Refuses a pipe or device that is given twice.
void refuseTwice(const std::vector<Argument>& inputs) {
    struct SpecialFile {
        const std::string &argument, &path;
        struct ::stat status;
    };
    std::vector<SpecialFile> all;
    for (const Argument& input : inputs) {
        for (const std::string& path : input.paths) {
            const auto status = statusOf(path);
            if (!status || S_ISREG(status->st_mode) || S_ISDIR(status->st_mode)) continue;
            const auto first = std::ranges::find_if(
                all, [&](const SpecialFile& other) { return isSameFile(other.status, *status); });
            if (first == all.end()) {
                all.push_back({input.name, path, *status});
                continue;
            }
            const std::string given = first->argument == input.name
                                          ? "twice for " + input.name
                                          : "for " + first->argument + " and for " + input.name;
            const std::string alias =
                first->path == path ? "" : " (also called " + io::shownPath(first->path) + ")";
            throw io::FileError(path, "is given " + given + alias +
                                          ", but can be read only once, since it is not a regular "
                                          "file; copy it to a file first");
        }
    }
}

/// Follows all links of a path, including links to files that do not exist yet.
std::filesystem::path behindLinks(std::filesystem::path path) {
    constexpr int kMaxLinks = 40;  // the limit of the system
    std::error_code error;
    for (int links = 0; links < kMaxLinks && std::filesystem::is_symlink(path, error); ++links)
        path = path.parent_path() / std::filesystem::read_symlink(path, error);
    const std::filesystem::path canonical =
        std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
    return error ? path : canonical;
}

/// Returns true for a device or a pipe.
bool isSpecial(const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored) &&
           !std::filesystem::is_regular_file(path, ignored);
}

}  // namespace

Job::Job(const CommonOptions& common, std::vector<Argument> inputs)
    : inputs_(std::move(inputs)), stages_(common.quiet) {
    limitThreads(common.threads);
    refuseDash(inputs_);
    refuseTwice(inputs_);
}

void Job::refuseInput(const std::filesystem::path& output) const {
    // A character device, such as a terminal or /dev/null, may be both input and output.
    const auto status = statusOf(output);
    if (!status || S_ISCHR(status->st_mode)) return;
    for (const Argument& input : inputs_)
        for (const std::string& path : input.paths)
            for (const auto& file : io::modelFiles(path))
                if (const auto other = statusOf(file); other && isSameFile(*status, *other))
                    throw io::FileError(output,
                                        "is also an input (" + input.name +
                                            "), and would be overwritten; choose another name");
}

void Job::refuseEarlier(const std::filesystem::path& output) {
    if (isSpecial(output)) return;
    const auto [other, isNew] = outputs_.try_emplace(behindLinks(output), output);
    if (!isNew)
        throw io::FileError(output,
                            fmt::format("is the same file as {}, through a link, and one would "
                                        "overwrite the other; remove the link",
                                        printable(other->second.string())));
}

void Job::writes(const std::filesystem::path& output, const std::vector<std::string>& extensions) {
    refuseInput(output);
    const std::filesystem::path folder = output.parent_path();
    std::error_code ignored;
    if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
        throw io::FileError(output,
                            "cannot be written: there is no folder " + io::shownPath(folder));
    io::checkWritable(output);
    if (!extensions.empty() && !isSpecial(output) &&
        std::ranges::count(extensions, io::lowerCase(output.extension().string())) == 0)
        throw io::FileError(output,
                            fmt::format("is not of a format that can be written here; expected {}",
                                        fmt::join(extensions, ", ")));
    refuseEarlier(output);
}

void Job::writesLattice(const std::filesystem::path& output) {
    writes(output);
    io::checkLatticeTarget(output);
}

}  // namespace espalier::cli
