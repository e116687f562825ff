// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Finds the files of a mesh of OpenFOAM in the folders of a case.

namespace espalier::io {

/// The name of a file of points, by which this format is known: it has no extension.
inline constexpr std::string_view kFoamPoints = "points";

/// The files of points that a path means.
struct FoamCase {
    /// The folder of a decomposed case; otherwise the folder of the only file.
    std::filesystem::path root;

    /// Relative to the root. In a decomposed case: of the whole mesh, if it is there, and then of
    /// the parts by their numbers, or the collated ones.
    std::vector<std::filesystem::path> files;

    bool isDecomposed = false;
};

/// Returns true if a path is one of OpenFOAM: a folder, a file NAME.foam, a file "points" or
/// "points.gz", or the folder of a time that only the parts of a decomposed case have.
bool isFoamPath(const std::filesystem::path& path);

/// Returns the files of points that a path means. They exist.
///
/// For the folder of a case these are constant/polyMesh/points, for the folder of a time
/// polyMesh/points, for a folder polyMesh points, for a file NAME.foam (which ParaView opens)
/// constant/polyMesh/points beside it. Where there is only points.gz, it is this file. If a case
/// has folders processor0, processor1, … with meshes, or collated ones (processors4), the folders
/// of the case and of its times mean the points in all of them, and those of the whole mesh if
/// there is one. Any other path is returned unchanged.
///
/// \throws FileError if the folder has no file of points, or if some parts of a case are missing
FoamCase foamCaseOf(const std::filesystem::path& path);

/// Returns the files of points that are to be written for a path, as foamCaseOf(); the folders
/// polyMesh must exist, the files need not.
/// \throws FileError if a folder has no folder polyMesh and is none, or if this folder has no faces
FoamCase foamTargetOf(const std::filesystem::path& path);

/// Returns the file of a mesh: the path, or the path with ".gz" if only this file exists; nothing
/// if there is none. \throws FileError if it is no regular file: the user has named the case and
/// not this file, and a
///         pipe would block for ever
std::optional<std::filesystem::path> findFoamFile(const std::filesystem::path& path);

/// Returns the folder of the faces that belong to a file of points; nothing if there is none.
std::optional<std::filesystem::path> facesFolder(const std::filesystem::path& points);

/// Returns the name of the part to which a file of a decomposed case belongs: "processor0". Nothing
/// for a file of the whole mesh.
/// \param file relative to the root
std::optional<std::string> partOf(const std::filesystem::path& file);

/// The processes whose meshes are in a folder.
struct FoamProcesses {
    std::uint64_t first = 0;
    std::uint64_t count = 1;
    bool isCollated = false;
};

/// Returns the processes of a folder by its name: process 2 of "processor2", 8 from 0 on of
/// "processors8", and 4 from 4 on of "processors8_4-7". Nothing for another name.
std::optional<FoamProcesses> processesOf(std::string_view name);

/// Returns a note on a file of points that the user has named itself, though it belongs to a
/// decomposed case; nothing for any other file.
std::optional<std::string> noteOnDecomposed(const std::filesystem::path& points);

}  // namespace espalier::io
