// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/simulation_mesh.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "foam_file.h"

// The faces, cells and patches of meshes of OpenFOAM, which are in files beside the points.

namespace espalier::io {

/// Returns the content of a file, inflated if it is compressed.
/// \throws FileError if its compressed bytes are damaged
std::string inflatedFoam(const std::filesystem::path& path, std::string bytes);

/// The faces and cells of a mesh, or of one part of a decomposed one.
struct FoamCells {
    far::Rows<Index> faces;
    std::vector<Index> owners, neighbours;
    Index cellCount = 0;
};

/// Reads the cells of the meshes in a folder: of one, or of one for each process from collated
/// files.
/// \throws FileError if a file is malformed, or if the lists do not have the same length
std::vector<FoamCells> readFoamCells(const std::filesystem::path& folder);

/// Returns true if the faces and cells in two folders are the same, in any form of files.
bool haveSameFoamCells(const std::filesystem::path& a, const std::filesystem::path& b);

/// Makes a mesh, which checks all numbers. Errors name the file of faces.
/// \param folder of the faces
far::VolumeMesh foamVolume(const std::filesystem::path& folder, Index pointCount, FoamCells cells);

/// Reads a mesh that is in one part, with its patches. It has no cells if there is no folder.
far::SimulationMesh readFoamMesh(const std::optional<std::filesystem::path>& folder,
                                 Index pointCount);

/// The parts of a decomposed mesh in one folder.
struct FoamParts {
    std::filesystem::path folder;                      ///< of the faces
    std::vector<std::string> names;                    ///< "processor0"
    std::vector<std::span<const Index>> pointNumbers;  ///< for each part, of its points in the mesh
};

/// Reads a decomposed mesh. The cells of the first part come first. Faces between two parts are
/// internal faces of the mesh, and each patch is one, with its faces of all parts; so is a cyclic
/// patch that the decomposition has cut.
///
/// \param folders in the order of the processes
/// \param facesApart gets the number of faces between two parts whose points are at different
///        places in the files of both; in the mesh they are two faces of its boundary
/// \param pointCount number of points of the mesh
/// \throws FileError if a file is malformed, or if the parts do not fit each other
far::SimulationMesh readFoamParts(std::span<const FoamParts> folders, Index pointCount,
                                  Index& facesApart);

}  // namespace espalier::io
