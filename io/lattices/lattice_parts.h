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

// What all lattice formats share: how marks travel, what is checked, and how errors are named.

namespace espalier::io {

// Names of the arrays and properties that hold marks; attributes have none that begin so.
inline constexpr std::string_view kReservedNames = "espalier:";
inline constexpr const char* kVertexSharpness = "espalier:vertex_sharpness";
inline constexpr const char* kEdgeSharpness = "espalier:edge_sharpness";
inline constexpr const char* kEdgeVertices = "espalier:edge_vertices";

/// VTK's array of bits that hide points and cells. It is skipped when read: on the vertices of a
/// refined lattice it would hide those that it has no bits for.
inline constexpr std::string_view kVtkGhosts = "vtkGhostType";

/// Stands for "no mark" where a file has a sharpness for every vertex or edge, marked or not. Not
/// NaN: VTK does not read that from text.
inline constexpr double kUnmarkedInFile = -1;

/// A sharpness as files hold it: infinity becomes 10, which already counts as infinite
/// (OpenSubdiv) and which every program can read.
double sharpnessToFile(double sharpness);

/// A sharpness from a file: 10 and more is infinite. \param value a mark
double sharpnessFromFile(double value);

/// Whether a value of an array of sharpness is a mark. Less than 0 is none.
/// \throws FileError naming the array and the place if the value is NaN
bool isMarkInFile(const std::filesystem::path& path, const char* array, std::size_t place,
                  double value);

/// Whether an edge joins two vertices of the complex.
bool isEdge(const far::CellComplex& complex, Index a, Index b);

/// The marks without those that a later one overrides, ascending, each edge with its smaller vertex
/// first, and each hole once. What the readers return is in this form, and so what comes back of
/// marks that are not.
///
/// \throws TopologyError (VertexOutOfRange, BadMark) if a mark names what the complex does not
///         have (a hole, anything but a face of a mesh), or has a sharpness that is less than 0 or
///         NaN
far::Marks canonicalMarks(const far::CellComplex& complex, const far::Marks& marks);

/// kUnmarkedInFile or a sharpness for every vertex. \param marks canonical
std::vector<double> vertexSharpnessForFile(const far::CellComplex& complex,
                                           const far::Marks& marks);

/// The marks in what vertexSharpnessForFile() gives.
/// \throws FileError as isMarkInFile()
std::vector<far::Marks::Vertex> vertexMarksFromFile(const std::filesystem::path& path,
                                                    const std::vector<double>& sharpness);

/// Calls f, and puts the path, with the line if there is one, before the message of a TopologyError
/// that it throws.
template <class F>
auto naming(const std::filesystem::path& path, F f, std::optional<std::size_t> line = {}) {
    try {
        return f();
    } catch (const far::TopologyError& error) {
        throw far::TopologyError(
            error.cause(), error.entity(),
            concat(shownPath(path), line ? concat(":", *line) : "", ": ", error.what()));
    }
}

/// A number of entities that a file claims, as an Index.
/// \throws FileError if there are too many; `what` says of what
Index checkedIndex(const std::filesystem::path& path, std::size_t count, const char* what);

/// The number that a vertex of a file has when the `dropped` ones, ascending, are left out; none if
/// it is one of them.
std::optional<Index> numberWithout(std::span<const Index> dropped, Index vertex);

/// Erases the values of the `dropped` vertices, ascending. \param values `components` a vertex
template <class Value>
void eraseVertices(std::span<const Index> dropped, int components, std::vector<Value>& values) {
    if (dropped.empty()) return;
    const std::size_t width = components;
    const std::size_t count = values.size() / width;
    std::size_t kept = 0;
    auto next = dropped.begin();
    for (std::size_t vertex = 0; vertex < count; ++vertex) {
        if (next != dropped.end() && static_cast<std::size_t>(*next) == vertex) {
            ++next;
            continue;
        }
        for (std::size_t c = 0; c < width; ++c) values[kept++] = values[vertex * width + c];
    }
    values.resize(kept);
}

/// Runs f, which makes a complex without the `dropped` vertices, as naming() does. The message of a
/// TopologyError also says that its numbers of vertices do not count them.
template <class F>
auto namingWithout(const std::filesystem::path& path, std::span<const Index> dropped, F f) {
    return naming(path, [&] {
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

/// What is done last in reading: drops the vertices that no cell uses, builds the complex, makes
/// the marks canonical and checks all.
///
/// \param parts the lattice as the file numbers its vertices, without its complex
/// \param notes gets the dropped vertices, unless it is null
/// \throws FileError naming a point that is not finite, or an attribute whose name is kept for
///         marks; TopologyError, with the path in its message
Lattice finishLattice(const std::filesystem::path& path, far::ComplexBuilder builder, Lattice parts,
                      ReadNotes* notes);

/// What is done first in writing: checks that a lattice is of this dimension, that its parts fit
/// together, and that it would be read again. Returns its marks in canonical form.
///
/// \throws FileError naming what does not fit; TopologyError as canonicalMarks()
far::Marks checkedForWriting(const std::filesystem::path& path, const Lattice& lattice,
                             int dimension = 3);

}  // namespace espalier::io
