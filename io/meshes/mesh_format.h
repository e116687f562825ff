// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "../models/file_model.h"
#include "cell_visitor.h"

// The meshes of simulations in one file: Gmsh, Medit, SU2, PLOT3D, Nastran, Abaqus, I-deas and
// Fluent. Each format has two functions: one finds the points, the other reads the cells. The rest
// of models and lattices is the same code for all formats.

namespace espalier::io {

/// The functions of a format of meshes.
struct MeshFormat {
    /// Finds the points.
    /// \return points that may be not finite
    /// \throws FileError if the file is malformed up to the end of its points
    FileNumbers (*readPoints)(const std::filesystem::path& path, std::string_view bytes);

    /// Reads the cells.
    /// \param pointCount the number of points that readPoints() found
    /// \throws FileError if the file is malformed, or a cell names a point that does not exist
    void (*readCells)(const std::filesystem::path& path, std::string_view bytes, Index pointCount,
                      CellVisitor& visitor);

    /// Reads the cells for Model::readCells(), for formats that list the faces of their cells; null
    /// if readCells() does it.
    ModelCells (*readModelCells)(const FileView& file) = nullptr;

    /// FileModelFormat::write, stored and losses.
    void (*write)(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                  std::span<const DeformationGradient> gradients) = nullptr;
    std::vector<Point3> (*stored)(const FileView& file, std::vector<Point3> points) = nullptr;
    std::string (*losses)(const FileView& file) = nullptr;
};

/// Visits the cells of a volume as polyhedra, and the faces of its boundary.
void visitVolume(const far::VolumeMesh& mesh, CellVisitor& visitor);

/// Returns the first names of files, and how many more there are: "'a', 'b', 'c' and 4 more".
std::string listedFiles(std::span<const std::string> names);

ModelSurface readMeshSurface(const MeshFormat& format, const FileView& file);
ModelCells readMeshCells(const MeshFormat& format, const FileView& file);

/// Reads the volume cells of a mesh as a lattice. Vertices, lines and faces of surfaces are
/// skipped; points that no cell uses are dropped.
///
/// \throws FileError as the functions of the format, and if a cell of a volume is curved;
///        TopologyError, with the path in its message, if the cells do not form a lattice
Lattice readLatticeOfMesh(const MeshFormat& format, const std::filesystem::path& path,
                          std::string_view bytes, ReadNotes* notes);

/// The model of a format of meshes: all that is not a coordinate is kept byte for byte.
template <const MeshFormat& format>
inline constexpr FileModelFormat kMeshModel = {
    .readNumbers = format.readPoints,
    .readSurface = [](const FileView& file) { return readMeshSurface(format, file); },
    .readCells = [](const FileView& file) { return readMeshCells(format, file); },
    .write = format.write,
    .stored = format.stored,
    .losses = format.losses};

/// Format::readModel and Format::readLattice of a format of meshes.
template <const MeshFormat& format>
constexpr auto readMeshModel = readFileModel<kMeshModel<format>>;

template <const MeshFormat& format>
Lattice readMeshLattice(const std::filesystem::path& path, std::string_view bytes,
                        ReadNotes* notes) {
    return readLatticeOfMesh(format, path, bytes, notes);
}

}  // namespace espalier::io
