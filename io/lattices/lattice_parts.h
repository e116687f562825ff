// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// Functions that all lattice formats use: marks in files, checks, and file names in errors.

namespace espalier::io {

// Names of the arrays and properties that hold marks. Names of attributes must not begin with
// kReservedNames.
inline constexpr std::string_view kReservedNames = "espalier:";
inline constexpr const char* kVertexSharpness = "espalier:vertex_sharpness";
inline constexpr const char* kEdgeSharpness = "espalier:edge_sharpness";
inline constexpr const char* kEdgeVertices = "espalier:edge_vertices";

/// VTK's array of bits that hide points and cells. Readers skip it, because the vertices that
/// refinement adds would have the value noInteger(), which hides them.
inline constexpr std::string_view kVtkGhosts = "vtkGhostType";

/// The value for "no mark" in a file that has a sharpness for every vertex or edge. It is not NaN,
/// because VTK does not read NaN from text.
inline constexpr double kUnmarkedInFile = -1;

/// Returns a sharpness as files hold it. Infinity becomes 10, which already counts as infinite
/// (OpenSubdiv) and which every program can read.
double sharpnessToFile(double sharpness);

/// Returns the sharpness of a mark in a file: 10 and more becomes infinite.
/// \param value 0 or more
double sharpnessFromFile(double value);

/// Returns true if a value in an array of sharpness is a mark, and false if it is below 0.
/// \throws FileError naming the array and the place if the value is NaN
bool isMarkInFile(const std::filesystem::path& path, const char* array, std::size_t place,
                  double value);

/// Returns true if an edge of the complex joins the two vertices.
bool isEdge(const far::CellComplex& complex, Index a, Index b);

/// Returns the marks in the canonical form of all readers: ascending, without marks that a later
/// one overrides, with the smaller vertex of each edge first, and without duplicate holes.
///
/// \throws TopologyError (VertexOutOfRange, BadMark) if a mark names an entity that the complex
///         does not have, or a hole that is not a face of a mesh, or if a sharpness is below 0 or
///         NaN
far::Marks canonicalMarks(const far::CellComplex& complex, const far::Marks& marks);

/// Returns one number per vertex: its sharpness, or kUnmarkedInFile.
/// \param marks in canonical form
std::vector<double> vertexSharpnessForFile(const far::CellComplex& complex,
                                           const far::Marks& marks);

/// Returns the marks of an array that vertexSharpnessForFile() made: its inverse.
/// \throws FileError as isMarkInFile()
std::vector<far::Marks::Vertex> vertexMarksFromFile(const std::filesystem::path& path,
                                                    const std::vector<double>& sharpness);

/// Calls f. If it throws a TopologyError, adds the path, and the line if there is one, in front of
/// the message.
template <class F>
auto withPathInErrors(const std::filesystem::path& path, F f,
                      std::optional<std::size_t> line = {}) {
    try {
        return f();
    } catch (const far::TopologyError& error) {
        throw far::TopologyError(
            error.cause(), error.entity(),
            concat(shownPath(path), line ? concat(":", *line) : "", ": ", error.what()));
    }
}

/// Converts a number of entities to Index.
/// \param what the entities in the message, such as "vertices"
/// \throws FileError if the number is too large
Index checkedIndex(const std::filesystem::path& path, std::size_t count, const char* what);

/// Returns the number of a vertex after the `dropped` vertices are removed; nothing if it is one of
/// them.
/// \param dropped ascending
std::optional<Index> numberWithout(std::span<const Index> dropped, Index vertex);

/// Erases the values of the `dropped` vertices.
/// \param dropped ascending
/// \param values `components` values per vertex
template <class Value>
void eraseVertices(std::span<const Index> dropped, int components, std::vector<Value>& values) {
    if (dropped.empty()) return;
    const std::size_t width = components;
    const std::size_t count = values.size() / width;
    std::size_t kept = 0;
    auto next = dropped.begin();
    for (std::size_t vertex = 0; vertex < count; ++vertex) {
        if (next != dropped.end() && std::cmp_equal(*next, vertex)) {
            ++next;
            continue;
        }
        for (std::size_t c = 0; c < width; ++c) values[kept++] = values[vertex * width + c];
    }
    values.resize(kept);
}

/// Calls f, which builds a complex without the `dropped` vertices, in the way of
/// withPathInErrors(). The message of a TopologyError also says that its vertex numbers do not
/// count the dropped vertices.
template <class F>
auto withPathAndDroppedInErrors(const std::filesystem::path& path, std::span<const Index> dropped,
                                F f) {
    return withPathInErrors(path, [&] {
        try {
            return f();
        } catch (const far::TopologyError& error) {
            if (dropped.empty() || error.cause() == far::TopologyCause::EmptyComplex) throw;
            throw far::TopologyError(error.cause(), error.entity(),
                                     concat(error.what(), " (unused vertices, ", dropped.size(),
                                            " in all, are not counted)"));
        }
    });
}

/// The last step of every reader: drops the vertices that no cell uses, builds the complex, makes
/// the marks canonical, and checks positions, names and marks.
///
/// \param parts the lattice without its complex, with the vertex numbers of the file
/// \param notes receives the dropped vertices; may be null
/// \throws FileError naming a point that is not finite, or an attribute whose name is reserved for
///         marks; TopologyError, with the path in its message
Lattice finishLattice(const std::filesystem::path& path, far::ComplexBuilder builder, Lattice parts,
                      ReadNotes* notes);

/// The first step of every writer: checks that a lattice has this dimension, that its parts fit
/// together, and that a reader would accept it. Returns its marks in canonical form.
///
/// \throws FileError naming the part that does not fit; TopologyError as canonicalMarks()
far::Marks checkedForWriting(const std::filesystem::path& path, const Lattice& lattice,
                             int dimension = 3);

}  // namespace espalier::io
