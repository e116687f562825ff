// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <bit>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "../models/coordinates.h"
#include "cell_visitor.h"

// The meshes of simulations: OpenFOAM, Gmsh, Medit, SU2 and PLOT3D. Each format has two
// functions: one finds the points, the other reads the cells. The rest of models and lattices is
// the same code for all formats.

namespace espalier::io {

/// The points of a mesh file, and where the file has their coordinates.
struct PlacedPoints {
    std::vector<Point3> positions;
    std::vector<CoordinatePlaces> places;  ///< one per point; z has no place in two dimensions

    Precision precision = Precision::Double;
    std::optional<std::endian> order = {};  ///< byte order of binary coordinates; nothing for text
    std::size_t dimension = 3;              ///< 2 or 3; in two dimensions, all z are 0
};

/// A format of meshes.
struct MeshFormat {
    std::string_view extension;

    /// Finds the points.
    /// \throws FileError if the file is malformed up to the end of its points, or if a point is not
    ///         finite
    PlacedPoints (*readPoints)(const std::filesystem::path& path, std::string_view bytes);

    /// Reads the cells.
    /// \param pointCount the number of points that readPoints() found
    /// \throws FileError if the file is malformed, or a cell names a point that does not exist
    void (*readCells)(const std::filesystem::path& path, std::string_view bytes, Index pointCount,
                      CellVisitor& visitor);

    /// Reads the volume from files beside `path`; null if readCells() has the cells.
    far::VolumeMesh (*readVolume)(const std::filesystem::path& path, Index pointCount) = nullptr;

    /// Throws unless the points of `source` may be written to `target`, an existing or a new file;
    /// null if any name will do.
    void (*checkTarget)(const std::filesystem::path& source, const std::filesystem::path& target,
                        Index pointCount) = nullptr;
};

/// Reads a mesh as a model: all that is not a coordinate is kept byte for byte.
/// \param format must outlive the model
std::unique_ptr<Model> readMeshModel(const MeshFormat& format, const std::filesystem::path& path,
                                     std::string bytes);

/// Reads the volume cells of a mesh as a lattice. Vertices, lines and faces of surfaces are
/// skipped.
///
/// \throws FileError as the functions of the format, and if a cell of a volume is curved;
///        TopologyError, with the path in its message, if the cells do not form a lattice
Lattice readMeshLattice(const MeshFormat& format, const std::filesystem::path& path,
                        std::string_view bytes, ReadNotes* notes);

}  // namespace espalier::io
