// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/read_notes.h>
#include <espalier/io/vtk/vtu.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <string_view>

// io/ reads and writes files.
//
// Its files are lattices (this header), models (model.h), matrices (matrices/matrix_file.h) and
// bindings (binding_file.h).
//
// The folder files/ has the parts that all formats share: atomic writing, bytes, text. The folders
// vtk/, models/, lattices/ and matrices/ have the formats. A reader checks everything that it reads
// and names the file and the line in its errors.
//
// Read this header, formats.h, files/file.h, then lattices/ovm_reader.cpp as the simplest reader.
namespace espalier::io {

/// Options of writeLattice() and writeRefinable().
struct WriteLatticeOptions {
    VtuEncoding vtuEncoding = VtuEncoding::Compressed;
};

/// Reads a lattice in the format that the path names (formats.h), such as .ovm (ovm.h), .vtu
/// (vtu.h) or .vtk (vtk_legacy.h); or the volume mesh of a simulation. Files of these formats,
/// except .ovm, may hold a model instead.
///
/// Vertices that no cell uses are dropped, with their attributes, integers and marks; the vertices
/// after them get lower numbers. A lattice and its pose lose the same vertices and so still match.
///
/// \param notes receives facts that the user of the file should know (read_notes.h); may be null
/// \throws FileError if the extension is none of these, or the file cannot be read or is malformed;
///         TopologyError, with the path in its message, if its cells do not form a lattice
ESPALIER_API Lattice readLattice(const std::filesystem::path& path, ReadNotes* notes = nullptr);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file
ESPALIER_API Lattice readLattice(const std::filesystem::path& path, std::string_view bytes,
                                 ReadNotes* notes = nullptr);

/// Writes a lattice in the format that the extension names (FileContent::Lattice), so that
/// readLattice() returns the same lattice. Vertices and cells keep their numbers, and cells their
/// faces; positions and attributes are equal bit for bit (NaN stays NaN), integers are equal, and
/// marks come back in canonical order.
///
/// \throws FileError if the extension is none of these, the lattice is not of dimension 3 or
///         inconsistent, or the file cannot be written; TopologyError if a mark names an entity
///         that does not exist
ESPALIER_API void writeLattice(const std::filesystem::path& path, const Lattice& lattice,
                               const WriteLatticeOptions& options = {});

/// Checks a name for writeLattice() without touching the file, so that a wrong name is refused
/// before long work.
/// \throws FileError unless the extension names one of the formats above
ESPALIER_API void checkLatticeTarget(const std::filesystem::path& path);

/// Reads a curve, a mesh or a lattice, for refinement: curves and meshes (complexes of dimension 1
/// and 2) from .obj (obj_mesh.h), lattices as readLattice() does. Vertices of a curve that are on
/// no line are dropped too; a mesh keeps vertices that no face uses.
///
/// \throws FileError if the extension is none of these; the errors of readObjMesh() and
///         readLattice()
ESPALIER_API Lattice readRefinable(const std::filesystem::path& path, ReadNotes* notes = nullptr);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file
ESPALIER_API Lattice readRefinable(const std::filesystem::path& path, std::string_view bytes,
                                   ReadNotes* notes = nullptr);

/// Writes a mesh or a curve as .obj (obj_mesh.h), a lattice as writeLattice() does, so that
/// readRefinable() gives it back.
///
/// \throws FileError as checkRefinableTarget(); the errors of writeObjMesh() and writeLattice()
ESPALIER_API void writeRefinable(const std::filesystem::path& path, const Lattice& lattice,
                                 const WriteLatticeOptions& options = {});

/// Checks a name for writeRefinable() without touching the file.
///
/// \param dimension dimension of the complex that is to be written
/// \throws FileError if the dimension is not 1 (curve), 2 (mesh) or 3 (lattice), or if the
///         extension names no format for this dimension
ESPALIER_API void checkRefinableTarget(const std::filesystem::path& path, int dimension);

}  // namespace espalier::io
