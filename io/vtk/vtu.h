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
/// Lattices in VTK's XML files of unstructured grids (.vtu).
///
///     Points                             positions
///     Cells                              the types 10, 11, 12, 13, 14 and 42
///     PointData                          attributes, and Lattice::integers; arrays that are
///                                        not of numbers, and vtkGhostType, are skipped
///     PointData espalier:vertex_sharpness
///                                        marks: a sharpness a vertex, less than 0 for no mark
///     FieldData espalier:edge_vertices   marks: two vertices an edge
///     FieldData espalier:edge_sharpness  marks: a sharpness an edge
///
/// A sharpness of 10 or more is infinite, and infinite ones are written as 10.

namespace espalier::io {

/// How the arrays of a .vtu file are written.
enum class VtuEncoding {
    Ascii,
    Binary,     ///< base64
    Compressed  ///< zlib in base64
};

/// Reads a lattice: ascii, inline or appended, raw or base64, zlib or not, any header_type and
/// byte_order, polyhedra in the layout of VTK 9.4 and in the one before.
///
/// Several pieces become one lattice; their vertices are numbered through, and those that coincide
/// are not welded. Vertices that no cell uses are dropped, and the others numbered without them;
/// else vertices and cells keep their numbers.
///
/// The number of values of each array follows from counts and arrays that are read before it. An
/// array whose header claims another number is refused before it is decoded.
///
/// \param path for messages
/// \param bytes the whole file
/// \param notes gets the dropped vertices, unless it is null
/// \throws FileError with the line, if the file is malformed, holds cells of other types or
///         a sharpness that is NaN, or has more than comments around its VTKFile element;
///         TopologyError, with the path in its message, if the cells do not form a lattice
ESPALIER_API Lattice readVtu(const std::filesystem::path& path, std::string_view bytes,
                             ReadNotes* notes = nullptr);

/// Writes a lattice so that it reads back the same: positions, attributes and integers bit for bit,
/// integers with their type, marks in canonical order. Files are little-endian, with 64-bit headers
/// and the older layout of polyhedra, which every VTK reads.
///
/// \throws FileError if the lattice is not of dimension 3, its parts do not fit together, XML
///         cannot hold the name of an attribute, or the file cannot be written; TopologyError if a
///         mark names what is not there
ESPALIER_API void writeVtu(const std::filesystem::path& path, const Lattice& lattice,
                           VtuEncoding encoding = VtuEncoding::Compressed);

/// Reads an unstructured grid as a thing that is deformed: only its points and the directions there
/// are read, and only they are replaced. All else in the file, whatever cells and arrays it has,
/// survives byte for byte, raw appended data included.
///
/// Directions are arrays of PointData of 3 components, Float32 or Float64: normals, if the array is
/// called "Normals" or the active Normals; tangents, if it is so by "Tangents". Any other is kept.
///
/// The array of Points is written as an inline one of the same number type (Float64, if that was of
/// integers): ascii if it was ascii, else base64, compressed if the file is. In a piece where no
/// point has moved it stays as it was. The same goes for arrays of directions.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError if the file is malformed, has a point that is not finite, or has an array of
///         directions that are not one a point
ESPALIER_API std::unique_ptr<Model> readVtuModel(const std::filesystem::path& path,
                                                 std::string bytes);

}  // namespace espalier::io
