// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

// What VTK's XML and legacy formats have in common: the cells of an unstructured grid.

namespace espalier::io {

inline constexpr std::int64_t kVtkPolyhedron = 42;

/// Makes the cells of a complex from those of a VTK file: types 10 (tetrahedron), 11 (voxel),
/// 12 (hexahedron), 13 (wedge), 14 (pyramid) and 42 (polyhedron).
///
/// All functions throw FileError, or TopologyError with the path in its message.
class VtkCellReader {
public:
    /// \param vertexCount of the whole lattice
    VtkCellReader(std::filesystem::path path, Index vertexCount)
        : path_(std::move(path)), builder_(3, vertexCount), pieceVertexCount_(vertexCount) {}

    /// From now on, cells name the vertices of a piece of the lattice, from 0.
    void beginPiece(Index firstVertex, Index vertexCount);

    /// Adds a cell of any type but 42.
    void add(std::int64_t type, std::span<const std::int64_t> vertices);

    /// Adds a polyhedron by its loops.
    void addPolyhedron(const std::vector<std::span<const std::int64_t>>& loops);

    /// Adds a polyhedron by its face stream: number of faces, then for each the number of its
    /// vertices and these.
    void addPolyhedron(std::span<const std::int64_t> faceStream);

    /// An upper bound of the number of edges of the cells so far.
    std::size_t mostEdges() const { return mostEdges_; }

    /// The builder with the cells; this has none from then on.
    far::ComplexBuilder takeBuilder() { return std::move(builder_); }

private:
    Index checkedVertex(std::int64_t vertex) const;
    [[noreturn]] void fail(const std::string& cause) const;

    std::filesystem::path path_;
    far::ComplexBuilder builder_;
    Index firstVertex_ = 0;
    Index pieceVertexCount_ = 0;
    Index cellCount_ = 0;
    std::size_t mostEdges_ = 0;
};

/// The cells of a lattice as VTK's files name them. Standard cells have types of their own, all
/// others are polyhedra.
struct VtkCells {
    std::vector<std::int64_t> types;         ///< one a cell
    std::vector<std::int64_t> connectivity;  ///< the vertices of each cell
    std::vector<std::int64_t> offsets;       ///< one a cell: where its vertices end
    std::vector<std::int64_t> faces;         ///< the face stream of each polyhedron
    std::vector<std::int64_t> faceOffsets;   ///< one a cell: where its faces end; −1 where VTK's
                                             ///< formats want it, for all but polyhedra

    bool havePolyhedra() const { return !faces.empty(); }
};

/// \param complex of dimension 3
VtkCells vtkCells(const far::CellComplex& complex);

}  // namespace espalier::io
