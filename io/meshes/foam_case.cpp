// SPDX-License-Identifier: Apache-2.0
#include "foam_case.h"

#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace espalier::io {
namespace {

using Path = std::filesystem::path;

const Path kPolyMesh = "polyMesh", kConstant = "constant";
constexpr const char* kCompressed = ".gz";

bool isFolder(const Path& path) {
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored);
}

/// Returns the folder of a path, which may be relative.
Path parentOf(const Path& path) {
    return path.has_parent_path() ? path.parent_path() : Path(".");
}

/// Returns a folder without a slash at its end.
Path withoutSlash(const Path& folder) {
    return folder.has_filename() ? folder : folder.parent_path();
}

/// Returns the folder polyMesh that a folder means; nothing if there is none.
std::optional<Path> polyMeshOf(const Path& folder) {
    for (const Path& inner : {kConstant / kPolyMesh, kPolyMesh})
        if (isFolder(folder / inner)) return folder / inner;
    const bool isOne =
        folder.filename() == kPolyMesh || folder.parent_path().filename() == kPolyMesh;
    return isOne ? std::optional(folder) : std::nullopt;
}

/// A folder of one process or of several, and its name.
struct ProcessorFolder : FoamProcesses {
    Path name;
};

/// Returns the folders of the processes of a case, in the order of the processes.
std::vector<ProcessorFolder> processorFolders(const Path& root) {
    std::vector<ProcessorFolder> folders;
    for (const std::string& name : namesIn(root.empty() ? Path(".") : root))
        if (const auto processes = processesOf(name); processes && isFolder(root / name))
            folders.push_back({*processes, name});
    std::ranges::sort(folders, [](const ProcessorFolder& a, const ProcessorFolder& b) {
        return std::pair(a.first, a.name) < std::pair(b.first, b.name);
    });
    return folders;
}

/// The folder of a decomposed case, and the folder of a mesh in the whole case and in each part of
/// it: "constant" or "0.5", or that of a region ("constant/fluid").
struct Decomposed {
    Path root, inner;
    std::vector<ProcessorFolder> parts;
};

/// Returns the decomposed case that a folder is, or of which it is a folder inside.
/// \param levels number of folders above `folder` that may be the case
std::optional<Decomposed> findDecomposed(const Path& folder, int levels) {
    Path root = withoutSlash(folder), inner = kConstant;
    for (int level = 0; level <= levels; ++level) {
        auto parts = processorFolders(root);
        if (std::ranges::any_of(parts, [&](const ProcessorFolder& part) {
                return isFolder(root / part.name / inner / kPolyMesh);
            }))
            return Decomposed{root, inner, std::move(parts)};
        const Path name = root.filename();
        if (name.empty() || name == "." || name == ".." || processesOf(name.string())) break;
        inner = level == 0 ? name : name / inner;
        root = parentOf(root);
    }
    return std::nullopt;
}

/// Throws unless the folders of the processes are those of one decomposition.
void checkParts(const Decomposed& found) {
    const auto refuse = [&](const std::string& cause) { throw FileError(found.root, cause); };
    std::uint64_t next = 0;
    for (const ProcessorFolder& part : found.parts) {
        if (part.isCollated != found.parts.front().isCollated)
            refuse(concat("is decomposed twice, in ", found.parts.front().name.string(), " and in ",
                          part.name.string(), "; remove one of them"));
        if (part.first < next)
            refuse(concat("is decomposed twice: the processes of ", part.name.string(),
                          " are also in another folder; remove one of them"));
        if (part.first > next)
            refuse(concat("is a decomposed case without a folder of process ", next,
                          "; decompose it again (decomposePar -force)"));
        if (!isFolder(found.root / part.name / found.inner / kPolyMesh))
            refuse(concat("is a decomposed case whose folder ", part.name.string(), " has no ",
                          (found.inner / kPolyMesh).string(),
                          "; decompose it again (decomposePar -force)"));
        next = part.first + part.count;
    }
}

/// Returns the file of points in a folder polyMesh that is to be written: the present one, or one
/// that is compressed as the faces are.
Path pointsToWrite(const Path& polyMesh) {
    const Path points = polyMesh / kFoamPoints;
    if (const auto present = findFoamFile(points)) return present->filename();
    const auto faces = findFoamFile(polyMesh / "faces");
    return faces && faces->extension() == kCompressed ? Path(kFoamPoints) += kCompressed
                                                      : Path(kFoamPoints);
}

/// Returns the files of a decomposed case.
/// \param isTarget true if they need not exist
FoamCase filesOf(const Decomposed& found, bool isTarget) {
    checkParts(found);
    FoamCase result{found.root, {}, true};
    const auto add = [&](const Path& folder) {
        const Path polyMesh = folder / found.inner / kPolyMesh;
        const auto points = findFoamFile(found.root / polyMesh / kFoamPoints);
        if (points)
            result.files.push_back(polyMesh / points->filename());
        else if (isTarget && isFolder(found.root / polyMesh))
            result.files.push_back(polyMesh / pointsToWrite(found.root / polyMesh));
        else if (!folder.empty())
            throw FileError(found.root / polyMesh, "is a folder polyMesh without a file of points");
    };
    add({});
    for (const ProcessorFolder& part : found.parts) add(part.name);
    return result;
}

bool isFoamMarker(const Path& path) {
    return lowerCase(path.extension().string()) == ".foam";
}

/// Returns the decomposed case of a time that only its parts have.
std::optional<Decomposed> decomposedTime(const Path& path) {
    std::error_code ignored;
    if (std::filesystem::exists(std::filesystem::symlink_status(path, ignored)))
        return std::nullopt;
    auto found = findDecomposed(path, 2);
    if (found && found->root == withoutSlash(path)) found.reset();
    return found;
}

/// Returns the folder that a path means: the folder itself, or that of a file NAME.foam.
std::optional<Path> caseFolderOf(const Path& path) {
    if (isFolder(path)) return path;
    if (isFoamMarker(path)) return parentOf(path);
    return std::nullopt;
}

/// Returns the decomposed case that a path means; nothing if the path is another one.
std::optional<Decomposed> decomposedOf(const Path& path) {
    const auto folder = caseFolderOf(path);
    if (!folder) return decomposedTime(path);
    if (withoutSlash(*folder).filename() == kPolyMesh) return std::nullopt;
    return findDecomposed(*folder, 2);
}

FoamCase single(const Path& file) {
    return {file.parent_path(), {file.filename()}, false};
}

}  // namespace

std::optional<FoamProcesses> processesOf(std::string_view name) {
    constexpr std::string_view kOne = "processor", kSeveral = "processors";
    FoamProcesses result;
    if (name.starts_with(kOne) && parseNumber(name.substr(kOne.size()), result.first))
        return result;
    if (!name.starts_with(kSeveral)) return std::nullopt;
    name.remove_prefix(kSeveral.size());
    result.isCollated = true;
    const std::size_t bar = std::min(name.find('_'), name.size());
    if (!parseNumber(name.substr(0, bar), result.count)) return std::nullopt;
    if (bar == name.size()) return result;
    name.remove_prefix(bar + 1);
    const std::size_t dash = std::min(name.find('-'), name.size());
    std::uint64_t last = 0;
    if (dash == name.size() || !parseNumber(name.substr(0, dash), result.first) ||
        !parseNumber(name.substr(dash + 1), last) || last < result.first)
        return std::nullopt;
    result.count = last - result.first + 1;
    return result;
}

std::optional<std::string> partOf(const Path& file) {
    const std::string name = file.begin()->string();
    return processesOf(name) ? std::optional(name) : std::nullopt;
}

std::optional<Path> findFoamFile(const Path& path) {
    const Path compressed = Path(path) += kCompressed;
    for (const Path& each : {path, compressed}) {
        std::error_code ignored;
        const auto status = std::filesystem::status(each, ignored);
        if (!std::filesystem::exists(status)) continue;
        if (std::filesystem::is_regular_file(status)) return each;
        throw FileError(each, "is not a regular file; copy it to a file first");
    }
    return std::nullopt;
}

std::optional<Path> facesFolder(const Path& points) {
    const Path own = points.parent_path();
    const Path ofCase = own / ".." / ".." / kConstant / kPolyMesh;
    if (findFoamFile(own / "faces")) return own;
    if (own.filename() == kPolyMesh && findFoamFile(ofCase / "faces")) return ofCase;
    return std::nullopt;
}

bool isFoamPath(const Path& path) {
    const Path name = path.filename();
    return name == kFoamPoints || name == concat(kFoamPoints, kCompressed) || caseFolderOf(path) ||
           decomposedTime(path);
}

FoamCase foamCaseOf(const Path& path) {
    if (const auto found = decomposedOf(path)) return filesOf(*found, false);
    const auto folder = caseFolderOf(path);
    if (!folder) return single(path);
    const auto polyMesh = polyMeshOf(*folder);
    if (const auto points = findFoamFile(polyMesh.value_or(*folder) / kFoamPoints))
        return single(*points);
    throw FileError(path, polyMesh ? "has a folder polyMesh without a file of points"
                                   : "is a folder without a mesh of OpenFOAM (constant/polyMesh)");
}

FoamCase foamTargetOf(const Path& path) {
    if (const auto found = decomposedOf(path)) return filesOf(*found, true);
    const auto folder = caseFolderOf(path);
    if (!folder) return single(path);
    if (const auto polyMesh = polyMeshOf(*folder)) {
        if (facesFolder(*polyMesh / kFoamPoints))
            return single(*polyMesh / pointsToWrite(*polyMesh));
        throw FileError(path,
                        "has a folder polyMesh without a file of faces; copy the whole case first");
    }
    throw FileError(path,
                    "is a folder without a mesh of OpenFOAM; copy the case first, for example: "
                    "cp -r CASE " +
                        shownPath(path));
}

std::optional<std::string> noteOnDecomposed(const Path& points) {
    std::error_code failure;
    const Path full = std::filesystem::absolute(points, failure).lexically_normal();
    if (failure) return std::nullopt;
    // CASE/constant/polyMesh/points, or with the folder of a region before polyMesh
    Path folder = full.parent_path();
    if (folder.filename() != kPolyMesh) return std::nullopt;
    folder = folder.parent_path();
    Path inner = folder.filename();
    for (int level = 0; level < 2; ++level) {
        const Path root = folder.parent_path();
        if (const auto processes = processesOf(root.filename().string())) {
            if (processes->isCollated) return std::nullopt;
            return concat("is one part of a decomposed mesh (", root.filename().string(),
                          "): points that it shares with other parts move here alone; name the "
                          "folder of the case to move all");
        }
        for (const ProcessorFolder& part : processorFolders(root))
            if (isFolder(root / part.name / inner / kPolyMesh))
                return concat("is the whole mesh of a decomposed case: its parts in ",
                              part.name.string(),
                              " … stay; name the folder of the case to move "
                              "all");
        folder = root;
        inner = folder.filename() / inner;
    }
    return std::nullopt;
}

}  // namespace espalier::io
