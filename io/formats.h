// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file
/// Which files there are. Each format is described once, as a Format (format.h); readers, writers,
/// messages and help take their lists of extensions from here.
///
/// Extensions count in upper and lower case.

namespace espalier::io {

/// A kind of content of files. A format may hold several kinds.
enum class FileContent {
    Lattice,
    Mesh,  ///< a curve or a mesh, which can be refined
    Model,
    EditorMesh,  ///< the vertices and faces of a lattice, which mesh editors move
    Matrix,
    Animation,     ///< all poses of a model
    BoundModel,    ///< a model with its matrix
    Targets,       ///< wanted positions of points
    Displacements  ///< how far vertices of a lattice move
};

enum class FileUse { Read, Write };

/// Returns true if a path names a format that holds this content: by its extension, or because it
/// is the folder of a case of OpenFOAM or a file of its points. Models that are read from any
/// format can be written in it again; a new model file has a format of FileUse::Write.
ESPALIER_API bool isFileOf(FileContent content, const std::filesystem::path& path,
                           FileUse use = FileUse::Read);

/// Returns true if a path names a format of the meshes of simulations.
ESPALIER_API bool isMeshFile(const std::filesystem::path& path);

/// Returns the extensions of the formats that hold this content, in lower case: ".obj". OpenFOAM
/// has none.
ESPALIER_API std::vector<std::string> extensionsOf(FileContent content, FileUse use);

/// Returns the formats as text for users: ".ovm, .vtu or .vtk, or the mesh of a simulation (...)".
ESPALIER_API std::string listOfFormats(FileContent content, FileUse use);

}  // namespace espalier::io
