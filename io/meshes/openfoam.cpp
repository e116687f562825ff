// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <utility>

#include "../lattices/lattice_parts.h"
#include "foam_file.h"
#include "mesh_format.h"
#include "openfoam.h"

namespace espalier::io {
namespace {

using Path = std::filesystem::path;

const Path kPolyMesh = "polyMesh", kConstant = "constant";

/// Returns whether a file of a mesh exists.
/// \throws FileError if only its compressed form exists, "NAME.gz", or if it is no regular file:
///         the user has named the case and not this file, and a pipe would block for ever
bool existsUncompressed(const Path& path) {
    std::error_code ignored;
    const auto status = std::filesystem::status(path, ignored);
    if (std::filesystem::exists(status)) {
        if (std::filesystem::is_regular_file(status)) return true;
        throw FileError(path, "is not a regular file; copy it to a file first");
    }
    const Path compressed = Path(path) += ".gz";
    if (std::filesystem::exists(compressed, ignored))
        throw FileError(compressed, "is compressed; run gunzip on the files of the mesh first");
    return false;
}

/// Reads one of the files of a mesh.
template <class Read>
auto readFoamFile(const Path& path, Read read) {
    existsUncompressed(path);
    const std::string bytes = readFile(path);
    FoamFile file(path, bytes);
    auto result = read(file);
    file.expectEnd();
    return result;
}

/// Returns the folder of the faces that belong to a file of points; nothing if there is none.
std::optional<Path> facesFolder(const Path& points) {
    const Path own = points.parent_path();
    const Path ofCase = own / ".." / ".." / kConstant / kPolyMesh;
    if (existsUncompressed(own / "faces")) return own;
    if (own.filename() == kPolyMesh && existsUncompressed(ofCase / "faces")) return ofCase;
    return std::nullopt;
}

/// The faces and cells of a mesh.
struct FoamCells {
    far::Rows<Index> faces;
    std::vector<Index> owners, neighbours;
    Index cellCount = 0;
};

constexpr const char* kCellFiles[] = {"faces", "owner", "neighbour"};

/// Reads the cells; none if there is no file of faces.
/// \throws FileError if a file is malformed, or the lists do not have the same length
FoamCells readFoamCells(const Path& points) {
    const auto folder = facesFolder(points);
    FoamCells cells;
    if (!folder) return cells;
    cells.faces = readFoamFile(*folder / "faces", [](FoamFile& file) { return file.faces(); });
    const std::size_t faceCount = cells.faces.offsets.size() - 1;
    const auto read = [&](const char* name, Index least) {
        return readFoamFile(*folder / name, [&](FoamFile& file) {
            return file.labels("the number of a cell", faceCount, "faces", least);
        });
    };
    cells.owners = read("owner", 0);
    // Old versions write a neighbour for each face: −1 on the boundary, which comes last.
    cells.neighbours = read("neighbour", -1);
    while (!cells.neighbours.empty() && cells.neighbours.back() == -1) cells.neighbours.pop_back();
    if (const auto none = std::ranges::find(cells.neighbours, -1); none != cells.neighbours.end())
        throw FileError(*folder / "neighbour",
                        concat("face ", none - cells.neighbours.begin(),
                               " has no neighbour (-1), but a face after it has one"));
    if (cells.owners.size() != faceCount)
        throw FileError(*folder / "owner", concat("has ", cells.owners.size(),
                                                  " labels, but there "
                                                  "are ",
                                                  faceCount, " faces"));
    for (std::size_t face = 0; face < cells.neighbours.size(); ++face)
        if (cells.neighbours[face] == cells.owners[face])
            throw FileError(*folder / "neighbour",
                            concat("face ", face, " has cell ", cells.owners[face],
                                   " as its owner and as its neighbour"));
    for (const auto* list : {&cells.owners, &cells.neighbours})
        for (const Index cell : *list) cells.cellCount = std::max(cells.cellCount, cell);
    if (faceCount > 0) cells.cellCount += cells.cellCount < kMaxIndex ? 1 : 0;
    // Each cell has a face.
    if (std::cmp_greater(cells.cellCount, 2 * faceCount))
        throw FileError(*folder / "owner", concat("names cell ", cells.cellCount - 1,
                                                  ", but there are ", faceCount, " faces"));
    return cells;
}

bool haveSameBytes(const Path& a, const Path& b) {
    std::error_code ignored;
    if (std::filesystem::equivalent(a, b, ignored)) return true;
    return std::filesystem::file_size(a, ignored) == std::filesystem::file_size(b, ignored) &&
           readFile(a) == readFile(b);
}

/// Returns true if the faces and cells of two meshes are the same, in any form.
/// \param a, b points of the meshes, both with files of faces
bool haveSameCells(const Path& a, const Path& b) {
    const Path folderA = *facesFolder(a), folderB = *facesFolder(b);
    if (std::ranges::all_of(kCellFiles, [&](const char* name) {
            return existsUncompressed(folderA / name) && existsUncompressed(folderB / name) &&
                   haveSameBytes(folderA / name, folderB / name);
        }))
        return true;
    const FoamCells cellsA = readFoamCells(a), cellsB = readFoamCells(b);
    return std::ranges::equal(cellsA.faces.offsets, cellsB.faces.offsets) &&
           std::ranges::equal(cellsA.faces.values, cellsB.faces.values) &&
           cellsA.owners == cellsB.owners && cellsA.neighbours == cellsB.neighbours;
}

/// Makes a mesh, which checks all numbers. Errors name the file of faces.
far::VolumeMesh meshOf(const Path& points, Index pointCount, FoamCells cells) {
    return withPathInErrors(facesFolder(points).value_or(points.parent_path()) / "faces", [&] {
        return far::VolumeMesh(pointCount, cells.cellCount, std::move(cells.faces),
                               std::move(cells.owners), std::move(cells.neighbours));
    });
}

FileNumbers readPoints(const Path& path, std::string_view bytes) {
    FoamFile file(path, bytes);
    FileNumbers numbers = file.points();
    file.expectEnd();
    return numbers;
}

/// Returns the patches of the file "boundary"; none if there is no such file.
std::vector<far::MeshPatch> readPatches(const Path& points, const far::VolumeMesh& mesh) {
    const auto folder = facesFolder(points);
    if (!folder || !existsUncompressed(*folder / "boundary")) return {};
    const auto ofFile =
        readFoamFile(*folder / "boundary", [](FoamFile& file) { return file.patches(); });
    std::vector<far::MeshPatch> patches;
    Index end = mesh.internalFaceCount();
    for (const FoamPatch& patch : ofFile) {
        // As in OpenFOAM, patches follow the internal faces and each other.
        if (patch.faceCount > 0 && (patch.startFace < end || patch.startFace > mesh.faceCount() ||
                                    patch.faceCount > mesh.faceCount() - patch.startFace))
            throw FileError(*folder / "boundary",
                            concat("the patch ", inQuotes(patch.name), " has ", patch.faceCount,
                                   " faces from face ", patch.startFace, " on; expected faces of ",
                                   end, " to ", mesh.faceCount() - 1));
        if (patch.faceCount > 0) end = patch.startFace + patch.faceCount;
        far::MeshPatch& result = patches.emplace_back(far::MeshPatch{patch.name, patch.type});
        result.partner = patch.neighbourPatch;
        result.dimension = 2;
        result.firstFace = patch.startFace;
        for (Index face = patch.startFace; face < patch.startFace + patch.faceCount; ++face) {
            const auto corners = mesh.face(face);
            result.points.insert(result.points.end(), corners.begin(), corners.end());
            result.faces.push(corners);
        }
        sortUnique(result.points);
    }
    return patches;
}

ModelCells readModelCells(const FileView& file) {
    ModelCells cells;
    cells.volume = meshOf(file.path, file.pointCount(), readFoamCells(file.path));
    cells.patches = readPatches(file.path, cells.volume);
    cells.isOpenFoam = true;
    return cells;
}

void readCells(const Path& path, std::string_view, Index pointCount, CellVisitor& visitor) {
    visitVolume(meshOf(path, pointCount, readFoamCells(path)), visitor);
}

/// Throws unless the points of a mesh may be written to a path: to a device, or to a file "points"
/// that belongs to the same mesh or to none.
void checkTarget(const FileView& file, const Path& target) {
    const Path& source = file.path;
    std::error_code ignored;
    const auto status = std::filesystem::status(target, ignored);
    const bool isFile = std::filesystem::is_regular_file(status);
    if (std::filesystem::exists(status) && !isFile && !std::filesystem::is_directory(status))
        return;
    // A new name without an extension may be meant as the folder of a case.
    if (target.filename() != kFoamPoints)
        throw FileError(
            target,
            "the points of an OpenFOAM mesh are written to a file of the name 'points', "
            "or into a folder with a copy of the case (cp -r CASE COPY)");
    const auto refuse = [&](const std::string& cause) {
        throw FileError(target, "belongs to another mesh, " + cause +
                                    "; write into a copy of the case (cp -r CASE COPY)");
    };
    if (!facesFolder(target)) return;
    if (facesFolder(source)) {
        if (!haveSameCells(source, target))
            refuse("whose faces, owner and neighbour are not those of " + shownPath(source));
        return;
    }
    // The points of a binding come without their faces.
    if (!isFile) return;
    const std::size_t count =
        readFoamFile(target, [](FoamFile& other) { return other.points(); }).points.values.size();
    if (count != file.numbers.points.values.size())
        refuse(concat("which has ", count, " points, and not ", file.pointCount()));
}

constexpr MeshFormat kFoamMesh = {readPoints, readCells, readModelCells, checkTarget};

/// Returns the folder polyMesh that a folder means; nothing if there is none.
std::optional<Path> polyMeshOf(const Path& folder) {
    std::error_code ignored;
    for (const Path& inner : {kConstant / kPolyMesh, kPolyMesh})
        if (std::filesystem::is_directory(folder / inner, ignored)) return folder / inner;
    const bool isOne =
        folder.filename() == kPolyMesh || folder.parent_path().filename() == kPolyMesh;
    return isOne ? std::optional(folder) : std::nullopt;
}

bool isFoamMarker(const Path& path) {
    return lowerCase(path.extension().string()) == ".foam";
}

/// Returns the folder that a path means: the folder itself, or that of a file NAME.foam.
std::optional<Path> caseFolderOf(const Path& path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) return path;
    if (isFoamMarker(path)) return path.has_parent_path() ? path.parent_path() : Path(".");
    return std::nullopt;
}

}  // namespace

bool isFoamPath(const Path& path) {
    return path.filename() == kFoamPoints || caseFolderOf(path);
}

std::filesystem::path foamPointsOf(const Path& path) {
    const auto folder = caseFolderOf(path);
    if (!folder) return path;
    const auto polyMesh = polyMeshOf(*folder);
    const Path points = polyMesh.value_or(*folder) / kFoamPoints;
    if (existsUncompressed(points)) return points;
    throw FileError(path, polyMesh ? "has a folder polyMesh without a file of points"
                                   : "is a folder without a mesh of OpenFOAM (constant/polyMesh)");
}

std::filesystem::path foamTargetOf(const Path& path) {
    const auto folder = caseFolderOf(path);
    if (!folder) return path;
    if (const auto polyMesh = polyMeshOf(*folder)) {
        if (facesFolder(*polyMesh / kFoamPoints)) return *polyMesh / kFoamPoints;
        throw FileError(path,
                        "has a folder polyMesh without a file of faces; copy the whole case first");
    }
    throw FileError(path,
                    "is a folder without a mesh of OpenFOAM; copy the case first, for example: "
                    "cp -r CASE " +
                        shownPath(path));
}

namespace {

Lattice readFoam(const Path& path, std::string_view bytes, ReadNotes* notes) {
    if (!facesFolder(path))
        throw FileError(path,
                        "has no file 'faces' beside it, nor in constant/polyMesh of its case; a "
                        "lattice needs the files faces, owner and neighbour");
    return readLatticeOfMesh(kFoamMesh, path, bytes, notes);
}

}  // namespace

const Format kFoamFormat = {.extensions = {kFoamPoints},
                            .words = "an OpenFOAM case",
                            .isMesh = true,
                            .isPath = isFoamPath,
                            .readModel = readMeshModel<kFoamMesh>,
                            .readLattice = readFoam};

}  // namespace espalier::io
