// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

/// \file
/// Reads and writes lattices in VTK's XML files of unstructured grids (.vtu).
///
///     Points                             positions
///     Cells                              the types 10 to 16 and 42; vertices, lines and
///                                        surface cells are skipped
///     PointData                          attributes, and Lattice::integers; arrays without
///                                        numbers, and vtkGhostType, are skipped
///     PointData espalier:vertex_sharpness
///                                        marks: one sharpness per vertex, below 0 for no mark
///     FieldData espalier:edge_vertices   marks: two vertices per edge
///     FieldData espalier:edge_sharpness  marks: one sharpness per edge
///
/// A sharpness of 10 or more is infinite, and an infinite sharpness is written as 10.

namespace espalier::io {

/// How the arrays of a .vtu file are written.
enum class VtuEncoding {
    Ascii,
    Binary,     ///< base64
    Compressed  ///< zlib in base64
};

/// Reads a lattice. Arrays may be ascii, inline or appended, raw or base64, zlib or not, with any
/// header_type and byte_order; polyhedra may have the layout of VTK 9.4 or the older one.
///
/// Several pieces become one lattice: vertices are numbered piece after piece, and vertices that
/// coincide are not welded. Vertices that no cell uses are dropped, and the vertices after them get
/// lower numbers. Cells keep their order; skipped cells have no number.
///
/// Counts and arrays that are read first determine the length of each later array. An array whose
/// header claims another length is refused before it is decoded.
///
/// \param path for messages
/// \param bytes the whole file
/// \param notes receives the dropped vertices and skipped cells; may be null
/// \throws FileError with the line, if the file is malformed, holds cells of other types or
///         a sharpness that is NaN, or has anything but comments around its VTKFile element;
///         TopologyError, with the path in its message, if the cells do not form a lattice
ESPALIER_API Lattice readVtu(const std::filesystem::path& path, std::string_view bytes,
                             ReadNotes* notes = nullptr);

/// Writes a lattice so that it reads back the same: positions, attributes and integers bit for bit,
/// integers with their type, marks in canonical order. Files are little-endian, with 64-bit headers
/// and the older layout of polyhedra, which every VTK reads.
///
/// \throws FileError if the lattice is not of dimension 3, its parts do not fit together, XML
///         cannot hold the name of an attribute, or the file cannot be written; TopologyError if a
///         mark names an entity that does not exist
ESPALIER_API void writeVtu(const std::filesystem::path& path, const Lattice& lattice,
                           VtuEncoding encoding = VtuEncoding::Compressed);

/// The same for VTK's XML files of surfaces (.vtp, PolyData), which OpenFOAM writes. The faces are
/// the cells of Polys, and the triangles of Strips.
ESPALIER_API std::unique_ptr<Model> readVtpModel(const std::filesystem::path& path,
                                                 std::string bytes);

}  // namespace espalier::io
