// SPDX-License-Identifier: Apache-2.0
#include "files.h"

#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>
#include <espalier/shapes/refiner_options.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <span>
#include <system_error>
#include <utility>

#include "standard_streams.h"

namespace espalier::cli {

far::TopologyRefiner refineLattice(const std::filesystem::path& path, const Lattice& lattice,
                                   const CommonOptions& options, int level) {
    return ofFile(path, [&] {
        far::TopologyRefiner refiner(
            lattice.complex,
            refinerOptions(lattice, options.refinement, options.sharpEdges, options.rules));
        refiner.refineUniform(level);
        return refiner;
    });
}

std::vector<Input> inputsOf(const std::string& argument, const std::vector<std::string>& paths) {
    std::vector<Input> inputs;
    for (const std::string& path : paths) inputs.push_back({argument, path});
    return inputs;
}

namespace {

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

void refuseDash(const std::vector<Input>& inputs) {
    std::vector<std::string> arguments;
    for (const Input& input : inputs)
        if (input.path == "-" && std::ranges::count(arguments, input.argument) == 0)
            arguments.push_back(input.argument);
    if (arguments.empty() || statusOf("-")) return;
    throw io::FileError("-", "does not exist (given for " + list(arguments) +
                                 "). To read one argument from standard input, make a link to "
                                 "/dev/stdin with the extension of the format, and name the link");
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

}  // namespace

void checkInputs(const std::vector<Input>& inputs) {
    refuseDash(inputs);
    std::vector<std::pair<const Input*, struct ::stat>> special;
    for (const Input& input : inputs) {
        const auto status = statusOf(input.path);
        if (!status || S_ISREG(status->st_mode) || S_ISDIR(status->st_mode)) continue;
        const auto same = std::ranges::find_if(
            special, [&](const auto& other) { return isSameFile(other.second, *status); });
        if (same == special.end()) {
            special.emplace_back(&input, *status);
            continue;
        }
        const Input& first = *same->first;
        const std::string given = first.argument == input.argument
                                      ? "twice for " + input.argument
                                      : "for " + first.argument + " and for " + input.argument;
        const std::string alias =
            first.path == input.path ? "" : " (also called " + io::shownPath(first.path) + ")";
        throw io::FileError(input.path, "is given " + given + alias +
                                            ", but can be read only once, since it is not a "
                                            "regular file; copy it to a file first");
    }
}

void checkOutput(const std::filesystem::path& output, const std::vector<Input>& inputs,
                 const std::vector<std::string>& extensions) {
    std::error_code ignored;
    // A character device, such as a terminal or /dev/null, may be both input and output.
    if (const auto status = statusOf(output); status && !S_ISCHR(status->st_mode))
        for (const Input& input : inputs)
            if (const auto other = statusOf(io::modelFile(input.path));
                other && isSameFile(*status, *other))
                throw io::FileError(output, "is also an input (" + input.argument +
                                                "), and would be overwritten; choose another name");
    const std::filesystem::path folder = output.parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
        throw io::FileError(output,
                            "cannot be written: there is no folder " + io::shownPath(folder));
    io::checkWritable(output);
    const bool isSpecial = std::filesystem::exists(output, ignored) &&
                           !std::filesystem::is_regular_file(output, ignored);
    if (extensions.empty() || isSpecial ||
        std::ranges::count(extensions, output.extension().string()) > 0)
        return;
    throw io::FileError(output,
                        fmt::format("is not of a format that can be written here; expected {}",
                                    fmt::join(extensions, ", ")));
}

void checkDistinct(const std::vector<std::filesystem::path>& outputs) {
    std::map<std::filesystem::path, std::filesystem::path> files;
    std::error_code ignored;
    for (const std::filesystem::path& output : outputs) {
        if (std::filesystem::exists(output, ignored) &&
            !std::filesystem::is_regular_file(output, ignored))
            continue;
        const auto [other, isNew] = files.try_emplace(behindLinks(output), output);
        if (!isNew)
            throw io::FileError(output,
                                fmt::format("is the same file as {}, through a link, and one would "
                                            "overwrite the other; remove the link",
                                            printable(other->second.string())));
    }
}

Lattice readLattice(const std::filesystem::path& path, Stages& stages, FileKind kind) {
    io::ReadNotes notes;
    Lattice lattice = stages.read(path, [&] {
        return kind == FileKind::Refinable ? io::readRefinable(path, &notes)
                                           : io::readLattice(path, &notes);
    });
    printNotes(path, notes);
    return lattice;
}

std::pair<Lattice, far::TopologyRefiner> readAndRefine(const LatticeOptions& options, FileKind kind,
                                                       Stages& stages) {
    Lattice lattice = readLattice(options.lattice, stages, kind);
    auto refiner = stages.run("refining", [&] {
        return refineLattice(options.lattice, lattice, options.common, options.level);
    });
    return {std::move(lattice), std::move(refiner)};
}

void printNotes(const std::filesystem::path& path, const io::ReadNotes& notes) {
    if (const std::string text = io::describe(path, notes); !text.empty()) printError(text.c_str());
}

std::vector<std::vector<Point3>> readPoses(
    const std::vector<std::string>& paths,
    const std::function<std::vector<Point3>(const std::string& path, io::ReadNotes* notes)>& read,
    Stages& stages) {
    std::vector<std::vector<Point3>> poses;
    io::ReadNotes before;
    for (const std::string& path : paths) {
        io::ReadNotes notes;
        poses.push_back(stages.read(path, [&] { return read(path, &notes); }));
        if (notes != before) printNotes(path, notes);
        before = std::move(notes);
    }
    return poses;
}

std::vector<std::vector<Point3>> readPoses(const std::vector<std::string>& paths,
                                           const Lattice& rest, const std::string& restPath,
                                           Stages& stages) {
    const auto read = [&](const std::string& path, io::ReadNotes* notes) {
        return io::readPose(path, rest, io::shownPath(restPath), notes);
    };
    return readPoses(paths, read, stages);
}

}  // namespace espalier::cli
