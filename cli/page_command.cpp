// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/io/companions.h>
#include <espalier/io/files/base64.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "commands.h"
#include "files.h"
#include "job.h"
#include "options.h"
#include "standard_streams.h"

namespace espalier::cli {
namespace {

namespace fs = std::filesystem;

struct PageOptions {
    CommonOptions common;
    std::string model;
    std::string rest;
    std::vector<std::string> poses;
    int level = 3;  ///< the default of `deform`
    bool limit = false;
    std::string page;  ///< the empty page; by default it is found
    std::string output;
};

/// The element of the empty page that receives the files.
constexpr std::string_view kFilesElement =
    R"(<script type="application/json" id="espalier-files"></script>)";

/// Returns the empty page: the file that ESPALIER_PAGE names, the file that is installed with the
/// program, or the file that scripts/web has built for a program in build/PRESET/cli.
/// \throws Error if there is none
fs::path findPage() {
    if (const char* named = std::getenv("ESPALIER_PAGE"); named != nullptr && *named != '\0')
        return named;
    std::error_code unknown;
    const fs::path folder = fs::read_symlink("/proc/self/exe", unknown).parent_path();
    for (const char* place : {"../share/espalier/espalier.html", "../../../out/espalier.html"})
        if (fs::exists(folder / place, unknown)) return (folder / place).lexically_normal();
    throw Error(
        "the page is not installed with this program. Build it by scripts/web in the sources of "
        "Espalier, and name it: --page out/espalier.html, or the environment variable "
        "ESPALIER_PAGE");
}

/// Reads a file that the page will hold. It opens files of formats that Espalier also writes.
std::string readForPage(const std::string& path, std::initializer_list<io::FileContent> contents) {
    std::error_code unknown;
    if (fs::exists(path, unknown) && !fs::is_regular_file(path, unknown))
        throw io::FileError(path, "is not a file that a page can hold");
    std::string known;
    bool isKnown = false;
    for (const io::FileContent content : contents) {
        isKnown = isKnown || io::isFileOf(content, path, io::FileUse::Write);
        known += (known.empty() ? "" : ", ") + filesToWrite(content);
    }
    if (!isKnown) throw io::FileError(path, "a page opens files that end in " + known);
    return io::readFile(path);
}

nlohmann::ordered_json fileToJson(const std::string& path, const std::string& bytes) {
    return {{"name", printable(fs::path(path).filename().string())},
            {"data", io::encodeBase64(bytes)}};
}

/// Adds a model and the files that belong to it, and notes the ones that are missing.
void addModel(nlohmann::ordered_json& json, const std::string& path, const std::string& bytes) {
    auto model = fileToJson(path, bytes);
    const io::Companions companions = io::findCompanions(path, bytes);
    for (const io::Companion& each : companions.files) {
        model["companions"].push_back(json["companions"].size());
        json["companions"].push_back(
            {{"name", printable(each.name)}, {"data", io::encodeBase64(io::readFile(each.file))}});
    }
    json["models"].push_back(model);
    if (companions.missing.empty()) return;
    std::string names;
    for (const std::string& name : companions.missing)
        names += (names.empty() ? "" : ", ") + printable(name);
    printError(fmt::format("{}: {} of the files that it names {} not in the page: {}",
                           printable(path), companions.missing.size(),
                           companions.missing.size() == 1 ? "is" : "are", names)
                   .c_str());
}

/// Returns the files as JSON without the character "<", which could end the element.
std::string filesAsJson(const PageOptions& options) {
    const std::string model = readForPage(options.model, {io::FileContent::Model});
    tellNotes(options.model, *io::readModel(options.model, model), options.common);
    nlohmann::ordered_json json = {{"version", 1}};
    addModel(json, options.model, model);
    auto poses = nlohmann::ordered_json::array();
    if (!options.rest.empty()) {
        const std::string bytes = readForPage(options.rest, {io::FileContent::Lattice});
        const Lattice rest = io::readLattice(options.rest, bytes);
        json["rest"] = fileToJson(options.rest, bytes);
        for (const std::string& path : options.poses) {
            const std::string pose =
                readForPage(path, {io::FileContent::Lattice, io::FileContent::EditorMesh});
            io::readPose(path, rest, options.rest);
            poses.push_back(fileToJson(path, pose));
        }
    }
    json["poses"] = poses;
    json["options"] = {{"level", options.level}, {"limit", options.limit}};
    std::string text = json.dump();
    for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;)
        text.replace(at, 1, "\\u003c");
    return text;
}

void runPage(const PageOptions& options) {
    const fs::path empty = options.page.empty() ? findPage() : fs::path(options.page);
    Job job(options.common, {{"--to", options.poses},
                             {"MODEL", options.model},
                             {"--rest", options.rest},
                             {"--page", empty.string()}});
    job.writes(options.output, {".html"});
    const std::string page = io::readFile(empty);
    const std::size_t at = page.find(kFilesElement);
    if (at == std::string::npos || page.find(kFilesElement, at + 1) != std::string::npos)
        throw io::FileError(empty,
                            "is not the empty page of Espalier: it has no place for files. Build "
                            "the page by scripts/web");
    Stages& stages = job.stages();
    const std::string files = stages.run("reading", [&] { return filesAsJson(options); });
    const std::size_t place = at + kFilesElement.find("</script>");
    io::writeFile(options.output, [&](std::ostream& out) {
        out << std::string_view(page).substr(0, place) << files
            << std::string_view(page).substr(place);
    });
    if (!options.common.quiet)
        fmt::print("{}: {}\n", printable(options.output), formatBytes(page.size() + files.size()));
}

}  // namespace

void addPageCommand(CLI::App& program) {
    const auto [command, options] =
        addCommand(program, "page",
                   "A web page that shows a model and its poses, and poses it further, without a "
                   "server",
                   runPage);
    command
        .add_option("MODEL", options.model, "The model: " + filesToWrite(io::FileContent::Model))
        ->required();
    CLI::Option* const rest = command.add_option(
        "--rest", options.rest, "The lattice at rest: " + filesToWrite(io::FileContent::Lattice));
    command
        .add_option("--to", options.poses,
                    "Poses: the lattice with moved vertices, " +
                        filesToWrite(io::FileContent::Lattice) + ", or editor meshes of it, " +
                        filesToWrite(io::FileContent::EditorMesh))
        ->needs(rest);
    CLI::Option* const limit = command.add_flag(
        "--limit", options.limit, "Bind the model to the limit of refinement, instead of level N");
    addLevelOption(command, options.level, 1);
    command.get_option("--level")->excludes(limit);
    command.add_option("--page", options.page,
                       "The empty page, that scripts/web builds; by default ESPALIER_PAGE, or the "
                       "page that is installed with the program");
    addOutputOption(command, options.output, "The page: .html")->required();
    addStrictOption(command, options.common);
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli
