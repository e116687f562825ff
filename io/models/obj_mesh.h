// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <string_view>

/// \file
/// Reads and writes control meshes and control polygons as Wavefront OBJ, with the tags of
/// OpenSubdiv's regression shapes.
///
///     v x y z                        a vertex; w or a colour after it is not kept
///     f v v v ...                    a face: v, v/vt, v//vn or v/vt/vn, from 1; −1 is the last
///                                    vertex so far. vn is not kept. Old files have fo
///     vt u v                         texture coordinates; w is not kept. All are dropped if a
///                                    corner of a face names none
///     l v v ...                      a line of a curve, vertices as in f; a closed line ends with
///                                    its first vertex. Ignored if the file has a face
///     t crease 2/1/0 a b s           edges (a, b) of sharpness s; also 2k/1/0 with one sharpness
///                                    for k edges, and 2k/k/0 with one for each
///     t corner 1/1/0 v s             vertices; also k/1/0 and k/k/0
///     t hole 1/0/0 f                 faces that are holes; also k/0/0
///     t interpolateboundary 1/0/0 m  0 Boundary::Open, 1 Sharp, 2 EdgeOnly
///     t creasemethod 0/0/1 m         normal (Creasing::Uniform) or chaikin
///     t smoothtriangles 0/0/1 m      catmark or smooth (TriangleSubdivision)
///     t facevaryinginterpolateboundary 1/0/0 m
///                                    0 to 5, the modes of far::FaceVaryingLinear in their order
///
/// The three counts of a tag are its numbers of integers, of real numbers and of strings. Unlike f,
/// tags number vertices and faces from 0. A tag may precede the vertices or faces that it names. If
/// two tags set the same thing, the later one wins. On a curve, creases have no effect, because all
/// edges of a curve are sharp.
///
/// A sharpness is held in single precision, as in OpenSubdiv and in refinement (far/marks.h): 10
/// and more is infinite, 0 and less is no mark. Tags with other names are ignored. All other
/// statements of the format are ignored too.

namespace espalier::io {

/// Reads a mesh: a Lattice of dimension 2, with its tags and with its marks in canonical form. A
/// file with lines and without faces gives a curve, of dimension 1, with the edges in the order of
/// the lines.
///
/// Vertices and faces keep their numbers, and faces keep their first vertex and winding. Edges get
/// new numbers, and there is one edge for each pair of vertices that faces join (the children of
/// degenerate faces may have had two). Faces may meet in any way, as in far::validate(): edges may
/// have many faces, faces may lie back to back or repeat a vertex, and vertices may have no face. A
/// curve may branch and have several pieces, but may join no two vertices twice. Vertices of a
/// curve that are on no line are dropped, and the vertices after them get lower numbers. A
/// backslash at the end of a line continues the statement on the next line.
///
/// \param path for messages
/// \param bytes the whole file
/// \param notes receives the dropped vertices; may be null
/// \throws FileError with the line, if a `v`, an `f`, a known tag or (of a curve) an `l` is
///         malformed or names something that does not exist, if a statement begins with no keyword
///         of the format, or if lines join two vertices twice; TopologyError, with the path in its
///         message, if there is neither face nor line, and with path and line if a face has fewer
///         than three corners
ESPALIER_API Lattice readObjMesh(const std::filesystem::path& path, std::string_view bytes,
                                 ReadNotes* notes = nullptr);

/// Writes a mesh so that it reads back the same: vertices and faces with their numbers, positions
/// bit for bit, tags, and marks in canonical form, their sharpness rounded to a float. The edges of
/// a curve are joined to lines that are as long as possible, and so get new numbers when read.
///
/// Marks with sharpness 0 are not written, because they have no effect on a mesh. Infinity becomes
/// 10.
///
/// \throws FileError if the mesh is not of dimension 2 or 1, its parts do not fit together, it has
///         attributes, which an OBJ cannot hold, or a position or texture coordinate that is not
///         finite, or if the file cannot be written; TopologyError if a mark names an entity that
///         does not exist
ESPALIER_API void writeObjMesh(const std::filesystem::path& path, const Lattice& mesh);

}  // namespace espalier::io
