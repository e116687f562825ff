// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/model.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "../meshes/cell_visitor.h"

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

/// Reads cells of the types 10 (tetrahedron), 11 (voxel), 12 (hexahedron), 13 (wedge), 14
/// (pyramid), 15 (pentagonal prism), 16 (hexagonal prism) and 42 (polyhedron).
///
/// All functions throw FileError, or TopologyError with the path in its message.
class VtkCellReader {
public:
    /// \param vertexCount number of vertices of all pieces
    /// \param visitor receives the cells
    /// \param acceptsCurved whether quadratic cells and cells of higher order are passed to the
    ///        visitor; otherwise they are errors
    VtkCellReader(std::filesystem::path path, Index vertexCount, CellVisitor& visitor,
                  bool acceptsCurved = false)
        : path_(std::move(path)),
          visitor_(visitor),
          acceptsCurved_(acceptsCurved),
          pieceVertexCount_(vertexCount) {}

    /// Begins a piece. Cells added from now on number its vertices from 0.
    void beginPiece(Index firstVertex, Index vertexCount);

    /// Adds a cell of any type but 42. Of vertices and lines, the visitor gets the dimension.
    void add(std::int64_t type, std::span<const std::int64_t> vertices);

    /// Adds a polyhedron by its loops.
    void addPolyhedron(const std::vector<std::span<const std::int64_t>>& loops);

    /// Adds a polyhedron by its face stream: the number of faces, then for each face the number of
    /// its vertices and the vertices.
    void addPolyhedron(std::span<const std::int64_t> faceStream);

    /// Returns an upper bound of the number of edges of the cells so far.
    std::size_t maxEdges() const { return maxEdges_; }

private:
    /// \param vertices the lower and the upper end, of `sides` vertices each
    void addPrism(std::size_t sides, std::span<const std::int64_t> vertices);
    void addFace(std::int64_t type, std::span<const std::int64_t> vertices);
    Index checkedVertex(std::int64_t vertex) const;
    [[noreturn]] void fail(const std::string& cause) const;

    std::filesystem::path path_;
    CellVisitor& visitor_;
    bool acceptsCurved_;
    Index firstVertex_ = 0;
    Index pieceVertexCount_ = 0;
    Index cellCount_ = 0;   ///< number of cells of a volume
    Index cellInFile_ = 0;  ///< number of the next cell in the file
    std::size_t maxEdges_ = 0;
};

/// The cells of a lattice as arrays of a VTK file. Standard cells have their own types; all other
/// cells are polyhedra.
struct VtkCells {
    std::vector<std::uint8_t> types;        ///< one per cell
    std::vector<Index> connectivity;        ///< the vertices of each cell
    std::vector<std::int64_t> offsets;      ///< one per cell: end of its vertices
    std::vector<Index> faces;               ///< the face stream of each polyhedron
    std::vector<std::int64_t> faceOffsets;  ///< one per cell: end of its face stream; −1 for
                                            ///< standard cells, as VTK's formats require;
                                            ///< empty if there are no polyhedra

    bool havePolyhedra() const { return !faces.empty(); }
};

/// Returns the cells of a lattice as arrays of a VTK file.
/// \param complex complex of dimension 3
VtkCells vtkCells(const far::CellComplex& complex);

}  // namespace espalier::io
