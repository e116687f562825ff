// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/model.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

// The cells of an unstructured grid, which VTK's XML and legacy formats write alike.

namespace espalier::io {

inline constexpr std::int64_t kVtkPolyhedron = 42;

/// Returns the dimension, 0, 1 or 2, of a VTK type of vertices, lines or surface cells; nothing for
/// all other types.
std::optional<int> lowDimensionOf(std::int64_t type);

inline constexpr std::int64_t kVtkVertices = 2;
inline constexpr std::int64_t kVtkLine = 4;
inline constexpr std::int64_t kVtkStrip = 6;
inline constexpr std::int64_t kVtkPolygon = 7;

/// Collects the faces of a model from cells of the types 5 (triangle), 6 (strip of triangles), 7
/// (polygon), 8 (pixel) and 9 (quadrilateral). Counts the cells of each other type.
class VtkFaceReader {
public:
    explicit VtkFaceReader(std::filesystem::path path) : path_(std::move(path)) {}

    /// Begins a piece. Cells added from now on number its points from 0.
    void beginPiece(std::size_t firstPoint, std::size_t pointCount);

    /// \throws FileError if the cell is a face and names a point that the piece does not have
    void add(std::int64_t type, std::span<const std::int64_t> points);

    /// Moves the faces to a surface, and names the other cells there.
    void giveTo(ModelSurface& surface);

private:
    std::filesystem::path path_;
    std::size_t firstPoint_ = 0;
    std::size_t pointCount_ = 0;
    ModelFaces faces_;
    std::map<std::int64_t, std::size_t> otherCells_;  ///< number of other cells of each type
};

/// Builds a complex from the cells of a VTK file: types 10 (tetrahedron), 11 (voxel), 12
/// (hexahedron), 13 (wedge), 14 (pyramid) and 42 (polyhedron).
///
/// All functions throw FileError, or TopologyError with the path in its message.
class VtkCellReader {
public:
    /// \param vertexCount number of vertices of the whole lattice
    VtkCellReader(std::filesystem::path path, Index vertexCount)
        : path_(std::move(path)), builder_(3, vertexCount), pieceVertexCount_(vertexCount) {}

    /// Begins a piece of the lattice. Cells added from now on number its vertices from 0.
    void beginPiece(Index firstVertex, Index vertexCount);

    /// Adds a cell of any type but 42. Skips and counts vertices, lines and surface cells.
    void add(std::int64_t type, std::span<const std::int64_t> vertices);

    /// Adds a polyhedron by its loops.
    void addPolyhedron(const std::vector<std::span<const std::int64_t>>& loops);

    /// Adds a polyhedron by its face stream: the number of faces, then for each face the number of
    /// its vertices and the vertices.
    void addPolyhedron(std::span<const std::int64_t> faceStream);

    /// Returns the numbers of skipped cells, by dimension.
    const std::array<Index, 3>& skippedCells() const { return skippedCells_; }

    /// Returns an upper bound of the number of edges of the cells so far.
    std::size_t maxEdges() const { return maxEdges_; }

    /// Returns the builder with the cells. The reader must not be used afterwards.
    /// \throws TopologyError (EmptyComplex) if all cells were skipped
    far::ComplexBuilder takeBuilder();

private:
    Index checkedVertex(std::int64_t vertex) const;
    [[noreturn]] void fail(const std::string& cause) const;

    /// Returns the number of the next cell in the file, which counts skipped cells.
    Index cellInFile() const;

    std::filesystem::path path_;
    far::ComplexBuilder builder_;
    Index firstVertex_ = 0;
    Index pieceVertexCount_ = 0;
    Index cellCount_ = 0;  ///< without skipped cells
    std::size_t maxEdges_ = 0;
    std::array<Index, 3> skippedCells_ = {};
};

/// The cells of a lattice as arrays of a VTK file. Standard cells have their own types; all other
/// cells are polyhedra.
struct VtkCells {
    std::vector<std::int64_t> types;         ///< one per cell
    std::vector<std::int64_t> connectivity;  ///< the vertices of each cell
    std::vector<std::int64_t> offsets;       ///< one per cell: end of its vertices
    std::vector<std::int64_t> faces;         ///< the face stream of each polyhedron
    std::vector<std::int64_t> faceOffsets;   ///< one per cell: end of its face stream; −1 for
                                             ///< standard cells, as VTK's formats require

    bool havePolyhedra() const { return !faces.empty(); }
};

/// Returns the cells of a lattice as arrays of a VTK file.
/// \param complex complex of dimension 3
VtkCells vtkCells(const far::CellComplex& complex);

}  // namespace espalier::io
