// SPDX-License-Identifier: Apache-2.0
#include "pipeline.h"

#include <espalier/base/error.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/shapes/level_lattice.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "standard_streams.h"

namespace espalier::cli {

far::TopologyRefiner refineLattice(const std::filesystem::path& path, const Lattice& lattice,
                                   const CommonOptions& options, int level) {
    return ofFile(path, [&] {
        far::RefinerOptions refinerOptions = espalier::refinerOptions(lattice, options.refinement);
        refinerOptions.sharpEdges = options.sharpEdges;
        far::TopologyRefiner refiner(lattice.complex, refinerOptions);
        stencils::checkRules(refiner, options.rules);
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

/// "--rest", "MODEL and --rest", "MODEL, --rest and --to".
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
    throw io::FileError("-", "is no file (given for " + list(arguments) +
                                 "); to read standard input, for one argument, name a link to "
                                 "/dev/stdin with the extension of the format");
}

}  // namespace

void checkInputs(const std::vector<Input>& inputs) {
    refuseDash(inputs);
    std::vector<std::pair<const Input*, struct ::stat>> special;
    for (const Input& input : inputs) {
        const auto status = statusOf(input.path);
        if (!status || S_ISREG(status->st_mode)) continue;
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
                                            ", but is no regular file and can be read only once; "
                                            "copy it to a file first");
    }
}

void checkOutput(const std::filesystem::path& output, const std::vector<Input>& inputs,
                 const std::vector<std::string>& extensions) {
    std::error_code ignored;
    // A terminal may be both, and so may /dev/null.
    if (const auto status = statusOf(output); status && !S_ISCHR(status->st_mode))
        for (const Input& input : inputs)
            if (const auto other = statusOf(input.path); other && isSameFile(*status, *other))
                throw io::FileError(output, "is also an input (" + input.argument +
                                                "): writing it would lose that");
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
                        fmt::format("has another extension than {}", fmt::join(extensions, ", ")));
}

std::unique_ptr<io::Model> readModel(const std::filesystem::path& path, Stages& stages) {
    return stages.run("reading", [&] {
        stages.addFile(path);
        return io::readModel(path);
    });
}

Lattice readLattice(const std::filesystem::path& path, Stages& stages, FileKind kind) {
    io::ReadNotes notes;
    Lattice lattice = stages.run("reading", [&] {
        stages.addFile(path);
        return kind == FileKind::Refinable ? io::readRefinable(path, &notes)
                                           : io::readLattice(path, &notes);
    });
    printNotes(path, notes);
    return lattice;
}

RefinedFile readAndRefine(const LatticeOptions& options, FileKind kind, Stages& stages) {
    Lattice lattice = readLattice(options.lattice, stages, kind);
    auto refiner = stages.run("refining", [&] {
        return refineLattice(options.lattice, lattice, options.common, options.level);
    });
    return {std::move(lattice), std::move(refiner)};
}

void printNotes(const std::filesystem::path& path, const io::ReadNotes& notes) {
    if (const std::string text = io::describe(path, notes); !text.empty()) printError(text.c_str());
}

void warnOfNonFinite(const std::filesystem::path& path, const Lattice& lattice) {
    const auto isNotFinite = [](double value) { return !std::isfinite(value); };
    for (const auto& [name, components, values] : lattice.attributes) {
        const auto first = std::ranges::find_if(values, isNotFinite);
        if (first == values.end()) continue;
        const auto count = std::count_if(first, values.end(), isNotFinite);
        const std::string text = fmt::format(
            "{}: the attribute {} has {} {} not finite, the first at vertex {} ({}); values that "
            "are refined from such are not finite either",
            io::shownPath(path), inQuotes(name), count,
            count == 1 ? "value that is" : "values that are", (first - values.begin()) / components,
            *first);
        printError(text.c_str());
    }
}

Lattice refinedLattice(const far::TopologyRefiner& refiner, int level, const CommonOptions& options,
                       const Lattice& base) {
    Lattice refined = levelLattice(
        refiner, level, stencils::refinePositions(refiner, level, options.rules, base.positions));
    for (const VertexAttribute& attribute : base.attributes)
        refined.attributes.push_back(
            {attribute.name, attribute.components,
             stencils::refineValues(refiner, level, options.rules, attribute.values,
                                    attribute.components)});
    refined.integers = levelIntegers(refiner, level, base.integers);
    return refined;
}

std::vector<Point3> readPose(const std::filesystem::path& path, const Lattice& rest,
                             const std::filesystem::path& restPath, io::ReadNotes& notes) {
    Lattice pose = io::readLattice(path, &notes);
    if (const auto difference = far::topologyDifference(rest.complex, pose.complex))
        throw io::FileError(path,
                            "is not a pose of " + io::shownPath(restPath) + ": " + *difference);
    return std::move(pose.positions);
}

}  // namespace espalier::cli
