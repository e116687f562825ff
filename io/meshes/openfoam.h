// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <filesystem>
#include <string_view>

/// \file
/// Reads meshes of OpenFOAM (polyMesh), ASCII and binary. Labels have 32 or 64 bits; scalars have
/// single or double precision.
///
/// The points are in the file "points". The faces and cells are in the files "faces", "owner" and
/// "neighbour" beside it; or in constant/polyMesh of the case, if "points" is in TIME/polyMesh.
/// Files that the user has not named must be regular ones.
///
/// The faces of a model are the boundary faces of the mesh; it has no cells if there is no file
/// "faces". Only coordinates are replaced on writing, in a file that has the same faces, owner and
/// neighbour beside it, or none; points without such files beside them replace the points of a mesh
/// with the same number of points.
///
/// The cells of a lattice may be any polyhedra. Points that no cell uses are dropped. Two boundary
/// faces with the same points (a baffle) become one face.

namespace espalier::io {

/// The name of the file of points, by which this format is known: it has no extension.
inline constexpr std::string_view kFoamPoints = "points";

/// Returns true if a path is one of OpenFOAM: a folder, a file NAME.foam, or a file "points".
ESPALIER_API bool isFoamPath(const std::filesystem::path& path);

/// Returns the file of points that a path means: for the folder of a case constant/polyMesh/points,
/// for the folder of a time polyMesh/points, for a folder polyMesh points, for a file NAME.foam
/// (which ParaView opens) constant/polyMesh/points beside it. Any other path is returned unchanged.
///
/// \throws FileError if the folder has no file of points, or only a compressed one
ESPALIER_API std::filesystem::path foamPointsOf(const std::filesystem::path& path);

/// Returns the file of points that is to be written for a path, as foamPointsOf(); the folder
/// polyMesh must exist, the file need not.
///
/// \throws FileError if a folder has no folder polyMesh and is none, or if this folder has no faces
ESPALIER_API std::filesystem::path foamTargetOf(const std::filesystem::path& path);

}  // namespace espalier::io
