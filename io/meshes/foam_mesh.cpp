// SPDX-License-Identifier: Apache-2.0
#include "foam_mesh.h"

#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "../files/bytes.h"
#include "../files/gzip.h"
#include "../lattices/lattice_parts.h"
#include "foam_case.h"

namespace espalier::io {
namespace {

using Path = std::filesystem::path;

constexpr const char* kProcessor = "processor";
constexpr const char* kProcessorCyclic = "processorCyclic";

std::string readFoamText(const Path& path) {
    const Path file = findFoamFile(path).value_or(path);
    return inflatedFoam(file, readFile(file));
}

/// Reads one of the files of a mesh: for each part `read(file, part)`.
template <class Read>
void readFoamFile(const Path& path, Read read) {
    const std::string text = readFoamText(path);
    std::size_t part = 0;
    forEachFoamPart(path, text, [&](FoamFile& file) { read(file, part++); });
}

/// Throws unless a file has as many parts as the faces.
void checkPartCount(const Path& path, std::size_t count, std::size_t expected) {
    if (count != expected)
        throw FileError(
            path, concat("has the lists of ", count, " processes, but the faces have ", expected));
}

constexpr const char* kCellFiles[] = {"faces", "owner", "neighbour"};

void checkFoamCells(const Path& folder, FoamCells& cells) {
    const std::size_t faceCount = cells.faces.count();
    // Old versions write a neighbour for each face: −1 on the boundary, which comes last.
    while (!cells.neighbours.empty() && cells.neighbours.back() == -1) cells.neighbours.pop_back();
    if (const auto none = std::ranges::find(cells.neighbours, -1); none != cells.neighbours.end())
        throw FileError(folder / "neighbour",
                        concat("face ", none - cells.neighbours.begin(),
                               " has no neighbour (-1), but a face after it has one"));
    if (cells.owners.size() != faceCount)
        throw FileError(folder / "owner", concat("has ", cells.owners.size(),
                                                 " labels, but there "
                                                 "are ",
                                                 faceCount, " faces"));
    for (std::size_t face = 0; face < cells.neighbours.size(); ++face)
        if (cells.neighbours[face] == cells.owners[face])
            throw FileError(folder / "neighbour",
                            concat("face ", face, " has cell ", cells.owners[face],
                                   " as its owner and as its neighbour"));
    for (const auto* list : {&cells.owners, &cells.neighbours})
        for (const Index cell : *list) cells.cellCount = std::max(cells.cellCount, cell);
    if (faceCount > 0) cells.cellCount += cells.cellCount < kMaxIndex ? 1 : 0;
    // Each cell has a face.
    if (std::cmp_greater(cells.cellCount, 2 * faceCount))
        throw FileError(folder / "owner", concat("names cell ", cells.cellCount - 1,
                                                 ", but there are ", faceCount, " faces"));
}

bool haveSameBytes(const Path& a, const Path& b) {
    std::error_code ignored;
    if (std::filesystem::equivalent(a, b, ignored)) return true;
    return std::filesystem::file_size(a, ignored) == std::filesystem::file_size(b, ignored) &&
           readFile(a) == readFile(b);
}

/// Reads the patches of each part in a folder.
/// \param cells of the same parts
std::vector<std::vector<FoamPatch>> readPatches(const Path& folder,
                                                std::span<const FoamCells> cells) {
    const Path path = folder / "boundary";
    std::vector<std::vector<FoamPatch>> all;
    readFoamFile(path, [&](FoamFile& file, std::size_t) { all.push_back(file.patches()); });
    checkPartCount(path, all.size(), cells.size());
    for (std::size_t part = 0; part < all.size(); ++part) {
        const auto faceCount = static_cast<Index>(cells[part].faces.count());
        auto end = static_cast<Index>(cells[part].neighbours.size());
        for (const FoamPatch& patch : all[part]) {
            // As in OpenFOAM, patches follow the internal faces and each other.
            if (patch.faceCount > 0 && (patch.startFace < end || patch.startFace > faceCount ||
                                        patch.faceCount > faceCount - patch.startFace))
                throw FileError(
                    path, concat("the patch ", inQuotes(patch.name), " has ", patch.faceCount,
                                 " faces from face ", patch.startFace, " on; expected faces of ",
                                 end, " to ", faceCount - 1));
            if (patch.faceCount > 0) end = patch.startFace + patch.faceCount;
        }
    }
    return all;
}

/// One part of a decomposed mesh.
struct PartOfMesh {
    Path folder;
    std::string name;
    std::span<const Index> pointNumbers;
    FoamCells cells;
    std::vector<FoamPatch> patches;
    Index firstCell = 0;

    /// Returns the loop of a face, by the points of the mesh.
    std::vector<Index> loop(Index face) const {
        std::vector<Index> result;
        for (const Index point : cells.faces[face]) result.push_back(pointNumbers[point]);
        return result;
    }

    Index owner(Index face) const { return firstCell + cells.owners[face]; }
};

/// Reads all parts, and checks that their faces name points that exist.
std::vector<PartOfMesh> readParts(std::span<const FoamParts> folders) {
    std::vector<PartOfMesh> parts;
    for (const FoamParts& each : folders) {
        auto cells = readFoamCells(each.folder);
        if (cells.size() != each.names.size())
            throw FileError(each.folder / "faces",
                            concat("has the faces of ", cells.size(), " processes, and ",
                                   kFoamPoints, " the points of ", each.names.size()));
        auto patches = readPatches(each.folder, cells);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const auto pointCount = static_cast<Index>(each.pointNumbers[i].size());
            for (std::size_t face = 0; face < cells[i].faces.count(); ++face) {
                const auto corners = cells[i].faces[face];
                if (corners.size() < 3)
                    throw FileError(
                        each.folder / "faces",
                        concat("face ", face, " of ", each.names[i], " has fewer than 3 points"));
                for (const Index point : corners)
                    if (point >= pointCount)
                        throw FileError(each.folder / "faces",
                                        concat("face ", face, " of ", each.names[i],
                                               " names point ", point, "; there are ", pointCount));
            }
            Index inPatches = 0;
            for (const FoamPatch& patch : patches[i]) inPatches += patch.faceCount;
            const auto onBoundary =
                static_cast<Index>(cells[i].owners.size() - cells[i].neighbours.size());
            if (inPatches != onBoundary)
                throw FileError(
                    each.folder / "boundary",
                    concat("has ", inPatches, " faces of ", each.names[i], " in its patches, but ",
                           onBoundary, " faces have no neighbour"));
            parts.push_back({each.folder, each.names[i], each.pointNumbers[i], std::move(cells[i]),
                             std::move(patches[i])});
        }
    }
    return parts;
}

/// Returns true if two faces are the two sides of one: the same points, in opposite directions.
bool areOpposite(std::span<const Index> a, std::span<const Index> b) {
    if (a.size() != b.size()) return false;
    const auto begin = std::ranges::find(b, a.front());
    if (begin == b.end()) return false;
    const auto shift = static_cast<std::size_t>(begin - b.begin());
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i] != b[(shift + b.size() - i) % b.size()]) return false;
    return true;
}

/// Puts the faces and cells of parts together.
class Joiner {
public:
    Joiner(std::vector<PartOfMesh> parts, Index pointCount)
        : parts_(std::move(parts)), pointCount_(pointCount) {}

    far::SimulationMesh join() {
        std::int64_t cellCount = 0;
        for (PartOfMesh& part : parts_) {
            part.firstCell = static_cast<Index>(cellCount);
            result_.parts.push_back({part.name, part.firstCell});
            cellCount += part.cells.cellCount;
            if (cellCount > kMaxIndex)
                throw FileError(part.folder, concat("has too many cells together with the parts "
                                                    "before it; at most ",
                                                    kMaxIndex, " can be read"));
        }
        for (const PartOfMesh& part : parts_)
            for (std::size_t face = 0; face < part.cells.neighbours.size(); ++face)
                addInternal(part.loop(static_cast<Index>(face)),
                            part.owner(static_cast<Index>(face)),
                            part.firstCell + part.cells.neighbours[face]);
        for (std::size_t part = 0; part < parts_.size(); ++part)
            for (const FoamPatch& patch : parts_[part].patches)
                if (patch.type == kProcessor) joinTo(part, patch);
        for (const PartOfMesh& part : parts_)
            for (const FoamPatch& patch : part.patches)
                if (patch.type != kProcessor) addPatch(part, patch);
        for (const auto& [part, face] : apart_)
            addFace(parts_[part].loop(face), parts_[part].owner(face));
        for (far::MeshPatch& patch : result_.patches) {
            for (std::size_t face = 0; face < patch.faces.count(); ++face) {
                const auto corners = patch.faces[face];
                patch.points.insert(patch.points.end(), corners.begin(), corners.end());
                addFace(corners, owners_[&patch - result_.patches.data()][face]);
            }
            sortUnique(patch.points);
        }
        result_.volume =
            far::VolumeMesh(pointCount_, static_cast<Index>(cellCount), std::move(cells_.faces),
                            std::move(cells_.owners), std::move(cells_.neighbours));
        return std::move(result_);
    }

    Index facesApart() const { return static_cast<Index>(apart_.size() / 2); }

private:
    void addFace(std::span<const Index> loop, Index owner) {
        cells_.faces.push(loop);
        cells_.owners.push_back(owner);
    }

    void addInternal(std::span<const Index> loop, Index owner, Index neighbour) {
        addFace(loop, owner);
        cells_.neighbours.push_back(neighbour);
    }

    /// Makes the faces of a patch to another process internal ones. Each process has the patch; the
    /// first one adds the faces.
    void joinTo(std::size_t number, const FoamPatch& patch) {
        const PartOfMesh& part = parts_[number];
        const auto refuse = [&](const std::string& cause) {
            throw FileError(part.folder / "boundary",
                            concat("the patch ", inQuotes(patch.name), " of ", part.name, " ",
                                   cause, "; decompose the case again (decomposePar -force)"));
        };
        if (!patch.neighbour) refuse("does not name the other process (neighbProcNo)");
        const auto otherNumber = static_cast<std::size_t>(*patch.neighbour);
        if (otherNumber >= parts_.size() || otherNumber == number)
            refuse(concat("leads to process ", otherNumber, ", but there are ", parts_.size(),
                          " processes"));
        const PartOfMesh& other = parts_[otherNumber];
        const auto opposite = std::ranges::find_if(other.patches, [&](const FoamPatch& each) {
            return each.type == kProcessor && each.neighbour == static_cast<Index>(number);
        });
        if (opposite == other.patches.end())
            refuse(concat("leads to ", other.name, ", which has no patch back"));
        if (opposite->faceCount != patch.faceCount)
            refuse(concat("has ", patch.faceCount, " faces, but ", inQuotes(opposite->name), " of ",
                          other.name, " has ", opposite->faceCount));
        for (Index i = 0; i < patch.faceCount; ++i) {
            const Index face = patch.startFace + i, otherFace = opposite->startFace + i;
            const auto loop = part.loop(face);
            // The sides of a face are apart if the parts have its points at different places.
            if (!areOpposite(loop, other.loop(otherFace)))
                apart_.push_back({number, face});
            else if (number < otherNumber)
                addInternal(loop, part.owner(face), other.owner(otherFace));
        }
    }

    void addPatch(const PartOfMesh& part, const FoamPatch& patch) {
        const std::string& name = patch.type == kProcessorCyclic ? patch.referPatch : patch.name;
        const auto [known, isNew] = numbers_.try_emplace(name, result_.patches.size());
        if (isNew) {
            result_.patches.push_back({name, patch.type});
            result_.patches.back().dimension = 2;
            owners_.emplace_back();
        }
        far::MeshPatch& joined = result_.patches[known->second];
        if (patch.type != kProcessorCyclic) {
            joined.type = patch.type;
            joined.partner = patch.neighbourPatch;
        }
        for (Index face = patch.startFace; face < patch.startFace + patch.faceCount; ++face) {
            joined.faces.push(part.loop(face));
            owners_[known->second].push_back(part.owner(face));
        }
    }

    struct Face {
        std::size_t part;
        Index face;
    };

    std::vector<PartOfMesh> parts_;
    Index pointCount_;
    far::SimulationMesh result_;
    FoamCells cells_;
    std::map<std::string, std::size_t> numbers_;  ///< of patches, by their names
    std::vector<std::vector<Index>> owners_;      ///< of the faces of each patch
    std::vector<Face> apart_;
};

}  // namespace

std::string inflatedFoam(const Path& path, std::string bytes) {
    if (!isGzip(bytes)) return bytes;
    return decodeFile(path, [&] { return gunzip(bytes); });
}

std::vector<FoamCells> readFoamCells(const Path& folder) {
    std::vector<FoamCells> parts;
    readFoamFile(folder / "faces",
                 [&](FoamFile& file, std::size_t) { parts.emplace_back().faces = file.faces(); });
    const auto read = [&](const char* name, Index least, std::vector<Index> FoamCells::*list) {
        std::size_t count = 0;
        readFoamFile(folder / name, [&](FoamFile& file, std::size_t part) {
            count = part + 1;
            if (count > parts.size()) checkPartCount(folder / name, count, parts.size());
            parts[part].*list =
                file.labels("the number of a cell", parts[part].faces.count(), "faces", least);
        });
        checkPartCount(folder / name, count, parts.size());
    };
    read("owner", 0, &FoamCells::owners);
    read("neighbour", -1, &FoamCells::neighbours);
    for (FoamCells& cells : parts) checkFoamCells(folder, cells);
    return parts;
}

bool haveSameFoamCells(const Path& a, const Path& b) {
    if (std::ranges::all_of(kCellFiles, [&](const char* name) {
            const auto fileA = findFoamFile(a / name), fileB = findFoamFile(b / name);
            return fileA && fileB && haveSameBytes(*fileA, *fileB);
        }))
        return true;
    const auto cellsA = readFoamCells(a), cellsB = readFoamCells(b);
    const auto areEqual = [](const FoamCells& one, const FoamCells& other) {
        return std::ranges::equal(one.faces.offsets, other.faces.offsets) &&
               std::ranges::equal(one.faces.values, other.faces.values) &&
               one.owners == other.owners && one.neighbours == other.neighbours;
    };
    return std::equal(cellsA.begin(), cellsA.end(), cellsB.begin(), cellsB.end(), areEqual);
}

far::VolumeMesh foamVolume(const Path& folder, Index pointCount, FoamCells cells) {
    return withPathInErrors(folder / "faces", [&] {
        return far::VolumeMesh(pointCount, cells.cellCount, std::move(cells.faces),
                               std::move(cells.owners), std::move(cells.neighbours));
    });
}

far::SimulationMesh readFoamMesh(const std::optional<Path>& folder, Index pointCount) {
    far::SimulationMesh mesh;
    if (!folder) return mesh;
    auto parts = readFoamCells(*folder);
    checkPartCount(*folder / "faces", parts.size(), 1);
    std::vector<std::vector<FoamPatch>> patches;
    if (findFoamFile(*folder / "boundary")) patches = readPatches(*folder, parts);
    mesh.volume = foamVolume(*folder, pointCount, std::move(parts.front()));
    if (patches.empty()) return mesh;
    for (const FoamPatch& patch : patches.front()) {
        far::MeshPatch& result = mesh.patches.emplace_back(far::MeshPatch{patch.name, patch.type});
        result.partner = patch.neighbourPatch;
        result.dimension = 2;
        result.firstFace = patch.startFace;
        for (Index face = patch.startFace; face < patch.startFace + patch.faceCount; ++face) {
            const auto corners = mesh.volume.face(face);
            result.points.insert(result.points.end(), corners.begin(), corners.end());
            result.faces.push(corners);
        }
        sortUnique(result.points);
    }
    return mesh;
}

far::SimulationMesh readFoamParts(std::span<const FoamParts> folders, Index pointCount,
                                  Index& facesApart) {
    Joiner joiner(readParts(folders), pointCount);
    far::SimulationMesh mesh = joiner.join();
    facesApart = joiner.facesApart();
    return mesh;
}

}  // namespace espalier::io
