// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <string_view>

/// \file
/// Reads and writes lattices in OpenVolumeMesh's text files (.ovm).
///
///     OVM ASCII
///     Vertices n     x y z
///     Edges n        tail head
///     Faces n        valence, half-edges: 2e runs along edge e, 2e + 1 against it
///     Polyhedra n    valence, half-faces: 2f is face f, 2f + 1 the same face reversed; seen from
///                    inside the polyhedron they run anticlockwise
///     VProp double "name"                          one line per vertex: an attribute
///     VProp double "espalier:vertex_sharpness"     marks: less than 0 for none
///     EProp double "espalier:edge_sharpness"       marks, in the order of Edges
///
/// A sharpness of 10 or more is infinite, and an infinite sharpness is written as 10.

namespace espalier::io {

/// Reads a lattice. Keywords may be in upper or lower case; "#" begins a comment.
///
/// Vertex properties of the types float, double, vec2f to vec4f and vec2d to vec4d become
/// attributes, and vector_double does if all its vectors have the same length. Vertex properties of
/// the types short, int, uint, long and ulong become Lattice::integers. All other properties are
/// skipped.
/// Vertices, edges and faces that no polyhedron uses are dropped, and the vertices after them get
/// lower numbers. Polyhedra keep their numbers. Edges and faces are numbered by their first
/// appearance in the polyhedra.
///
/// \param path for messages
/// \param bytes the whole file
/// \param notes receives what is dropped; may be null
/// \throws FileError with the line, if the file is malformed or binary; TopologyError, with the
///         path in its message, if the cells do not form a lattice
ESPALIER_API Lattice readOvm(const std::filesystem::path& path, std::string_view bytes,
                             ReadNotes* notes = nullptr);

/// Writes a lattice so that it reads back the same: positions, attributes and integers bit for bit,
/// marks in canonical order. Integers of a type that OpenVolumeMesh lacks get a wider type.
///
/// \throws FileError if the lattice is not of dimension 3, its parts do not fit together, an
///         attribute has a name of more than one line, integers have more than one component, or
///         the file cannot be written; TopologyError if a mark names an entity that does not exist
ESPALIER_API void writeOvm(const std::filesystem::path& path, const Lattice& lattice);

}  // namespace espalier::io
