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

// io/: files.
//
// In and out: lattices (this header), models (model.h), matrices (matrices/matrix_file.h), bindings
// (binding_file.h).
//
// Inner folders: files/ holds what all formats need (atomic writing, bytes, text), vtk/, models/,
// lattices/ and matrices/ the formats. A reader checks everything that it reads and names the file
// and the line in its errors.
//
// Read this header, files/file.h, then lattices/ovm_reader.cpp as the simplest reader.
namespace espalier::io {

struct WriteLatticeOptions {
    VtuEncoding vtuEncoding = VtuEncoding::Compressed;
};

/// Reads a lattice in the format that the extension names, in upper or lower case: .ovm (ovm.h),
/// .vtu (vtu.h) or .vtk (vtk_legacy.h).
///
/// Vertices that no cell uses are dropped, with their attributes, integers and marks; the vertices
/// after them get lower numbers. A pose of a lattice keeps matching it, as both are read alike.
///
/// \param notes gets what the user of the file should know (read_notes.h), unless it is null
/// \throws FileError if the extension is none of these, or the file cannot be read or is malformed;
///         TopologyError, with the path in its message, if its cells do not form a lattice
ESPALIER_API Lattice readLattice(const std::filesystem::path& path, ReadNotes* notes = nullptr);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file
ESPALIER_API Lattice readLattice(const std::filesystem::path& path, std::string_view bytes,
                                 ReadNotes* notes = nullptr);

/// Writes a lattice in the format that the extension names, so that readLattice() gives it back:
/// the same vertices, cells and faces of cells, vertices and cells with their numbers, positions
/// and attributes bit for bit (what is no number, as that), integers exactly, and the marks in
/// canonical order.
///
/// \throws FileError if the extension is none of these, the lattice is not of dimension 3 or
///         inconsistent, or the file cannot be written; TopologyError if a mark names what is not
///         there
ESPALIER_API void writeLattice(const std::filesystem::path& path, const Lattice& lattice,
                               const WriteLatticeOptions& options = {});

/// Checks a name for writeLattice() without touching the file, so that it can be refused before
/// long work. \throws FileError if its extension is none of the formats'
ESPALIER_API void checkLatticeTarget(const std::filesystem::path& path);

/// Reads what can be refined: a mesh or a curve (complex of dimension 2 or 1) from .obj
/// (obj_mesh.h), a lattice as readLattice() does. Vertices of a curve that are on no line are
/// dropped too; a mesh keeps its vertices that no face uses.
///
/// \throws FileError if the extension is none of these; what readObjMesh() and readLattice() throw
ESPALIER_API Lattice readRefinable(const std::filesystem::path& path, ReadNotes* notes = nullptr);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file
ESPALIER_API Lattice readRefinable(const std::filesystem::path& path, std::string_view bytes,
                                   ReadNotes* notes = nullptr);

/// Writes a mesh or a curve as .obj (obj_mesh.h), a lattice as writeLattice() does, so that
/// readRefinable() gives it back.
///
/// \throws FileError as checkRefinableTarget(); what writeObjMesh() and writeLattice() throw
ESPALIER_API void writeRefinable(const std::filesystem::path& path, const Lattice& lattice,
                                 const WriteLatticeOptions& options = {});

/// Checks a name for writeRefinable() without touching the file.
///
/// \param dimension of the complex that is to be written
/// \throws FileError if the format that the extension names, if any, is not one for a curve (1),
///         a mesh (2) or a lattice (3), or the dimension is another
ESPALIER_API void checkRefinableTarget(const std::filesystem::path& path, int dimension);

}  // namespace espalier::io
