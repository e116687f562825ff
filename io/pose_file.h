// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file
/// Poses of a lattice as files: other positions of the same vertices. A pose is a lattice file
/// (lattice_file.h) or an editor mesh: an .obj or .ply with the vertices and faces of the lattice,
/// which mesh editors can change.

namespace espalier::io {

/// Reads the positions of a pose: one point per vertex of `rest`.
///
/// A lattice file must have the same cells on the same vertex numbers; see
/// far::topologyDifference(). An editor mesh must have one point per vertex, in the order of the
/// vertices, and each of its faces must be a face of the lattice: the same loop of vertices, from
/// any of them and in either direction. Faces may be missing.
///
/// \param restName name of the lattice in messages
/// \param notes receives the notes of the reader; may be null
/// \throws FileError if the file cannot be read, or is not a pose of this lattice, with the first
///         difference; the errors of readLattice() and readModel()
/// \cost that of readLattice() or readModel(), and O(faces · log faces)
ESPALIER_API std::vector<Point3> readPose(const std::filesystem::path& path, const Lattice& rest,
                                          const std::string& restName = "the lattice",
                                          ReadNotes* notes = nullptr);

/// Reads a pose of the lattice to which the points of a bound model were bound.
///
/// \param bindingName name of the bound model in messages
ESPALIER_API std::vector<Point3> readPose(const std::filesystem::path& path,
                                          const BoundModel& bound, const std::string& bindingName,
                                          ReadNotes* notes = nullptr);

/// Returns the faces of a lattice or a mesh as loops of its vertices, for BoundModel::faces.
ESPALIER_API ModelFaces facesOf(const far::CellComplex& complex);

/// Writes a lattice as an editor mesh: its vertices in their order, and all its faces, interior
/// ones too. readPose() reads the positions back, bit for bit. Cells, attributes and marks are not
/// written.
///
/// \throws FileError unless isFileOf(FileContent::EditorMesh, path), if the lattice is not of
/// dimension 3 or a
///         position is not finite, or if the file cannot be written
ESPALIER_API void writeEditorMesh(const std::filesystem::path& path, const Lattice& lattice);

}  // namespace espalier::io
