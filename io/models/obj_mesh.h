// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <string_view>

/// \file
/// Control meshes and control polygons as Wavefront OBJ, with the tags of OpenSubdiv's regression
/// shapes.
///
///     v x y z                        a vertex; w or a colour after it is not kept
///     f v v v ...                    a face: v, v/vt, v//vn or v/vt/vn, from 1; −1 is the last
///                                    vertex so far. vt and vn are not kept. Old files have fo
///     l v v ...                      a line of a curve, vertices as in f; a closed one ends with
///                                    its first. Passed over where there is a face
///     t crease 2/1/0 a b s           edges (a, b) of sharpness s; also 2k/1/0 with one sharpness
///                                    for k edges, and 2k/k/0 with one for each
///     t corner 1/1/0 v s             vertices; also k/1/0 and k/k/0
///     t hole 1/0/0 f                 faces that are holes; also k/0/0
///     t interpolateboundary 1/0/0 m  0 Boundary::Open, 1 Sharp, 2 EdgeOnly
///     t creasemethod 0/0/1 m         normal (Creasing::Uniform) or chaikin
///     t smoothtriangles 0/0/1 m      catmark or smooth (TriangleSubdivision)
///
/// The counts of a tag are those of its whole numbers, its numbers and its strings. Unlike f, tags
/// number vertices and faces from 0. They may come before what they name, and of two on the same
/// thing the later one counts. On a curve creases say nothing: all of its edges are.
///
/// A sharpness is held in single precision, as by OpenSubdiv and by refinement (far/marks.h): 10
/// and more is infinite, 0 and less is no mark. Tags of other names are passed over, face-varying
/// data among them, which has no effect on vertices; and so are the other statements of
/// the format.

namespace espalier::io {

/// Reads a mesh: a Lattice of dimension 2, with its marks in canonical form and its tags. A file of
/// lines and no faces gives a curve, of dimension 1, with the edges in the order of the lines.
///
/// Vertices and faces keep their numbers, and faces where they start and how they wind; edges are
/// numbered anew, and edges that join the same two vertices in several faces are one (the children
/// of degenerate faces may have had two). How faces meet does not matter, as in far::validate():
/// edges of many faces, faces back to back or with a vertex twice, and vertices of no face are
/// read. A curve may be in pieces and branch, and no two of its vertices are joined twice; vertices
/// that are on no line are dropped, and the others numbered without them. A backslash at the end of
/// a line continues the statement on the next.
///
/// \param path for messages
/// \param bytes the whole file
/// \param notes gets the dropped vertices, unless it is null
/// \throws FileError with the line, if a `v`, an `f`, an `l` that counts or a known tag is
///         malformed, or names what is not there, if a statement begins with no keyword of the
///         format, or if lines join two vertices twice; TopologyError, with the path in its
///         message, if there is neither face nor line, and with path and line if a face has fewer
///         than three corners
ESPALIER_API Lattice readObjMesh(const std::filesystem::path& path, std::string_view bytes,
                                 ReadNotes* notes = nullptr);

/// Writes a mesh so that it reads back the same: vertices and faces with their numbers, positions
/// bit for bit, tags, and marks in canonical form, their sharpness rounded to a float. The edges of
/// a curve are joined to lines as long as they can be, and so numbered anew.
///
/// A mark that says smooth is not written: on a mesh it says nothing. Infinity becomes 10.
///
/// \throws FileError if the mesh is not of dimension 2 or 1, its parts do not fit together, it has
///         attributes, for which an OBJ has no place, or a position that is not finite, or if the
///         file cannot be written; TopologyError if a mark names what is not there
ESPALIER_API void writeObjMesh(const std::filesystem::path& path, const Lattice& mesh);

}  // namespace espalier::io
