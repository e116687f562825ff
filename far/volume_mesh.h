// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/incidence.h>
#include <espalier/far/standard_cells.h>

#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace espalier::far {

/// The cells of a volume mesh of a simulation: points, faces, and which cells the faces bound. It
/// has no positions.
///
/// Cells may be of second order (second_order_cells.h). Their faces name the corners alone.
///
/// A VolumeMesh is lighter than a CellComplex, since it is only checked and never refined: it has
/// no edges, and its topology is not validated. A cell may be open or name a point twice, and two
/// faces may have the same points (baffles). A million hexahedra take 0.2 GB and 0.7 s.
///
/// Has value semantics: copies share the same immutable data, and any number of threads may read
/// it.
class ESPALIER_API VolumeMesh {
public:
    /// Creates a mesh without points and cells.
    VolumeMesh();

    /// Makes a mesh of faces, as OpenFOAM stores it. Cells with the faces of a tetrahedron,
    /// pyramid, wedge or hexahedron become standard cells, and all others polyhedra.
    ///
    /// \param faces loops of points, each anticlockwise seen from outside its owner; internal faces
    ///        first
    /// \param owners the cell on one side of each face
    /// \param neighbours the cell on the other side of each internal face
    /// \throws TopologyError if a face has fewer than three points or names a point or a cell that
    ///         does not exist; Error unless there is one owner per face and at most one neighbour
    VolumeMesh(Index pointCount, Index cellCount, Rows<Index> faces, std::vector<Index> owners,
               std::vector<Index> neighbours);

    Index pointCount() const;
    Index cellCount() const;
    Index faceCount() const;

    /// Number of faces between two cells. They have the lowest numbers.
    Index internalFaceCount() const;

    /// Returns the loop of a face, anticlockwise seen from outside its owner.
    std::span<const Index> face(Index face) const;

    Index owner(Index face) const;

    /// \param face an internal face
    Index neighbour(Index face) const;

    /// Returns the faces of a cell.
    std::span<const Index> faces(Index cell) const;

    /// Returns the kind of a cell; nothing for a polyhedron.
    std::optional<StandardCell> kind(Index cell) const;

    /// Returns the corners of a standard cell in VTK's order (StandardCell); empty for a
    /// polyhedron.
    std::span<const Index> corners(Index cell) const;

    /// Returns all points of a standard cell: the corners, and in a cell of second order the points
    /// between them, in the order of cellPoints(). Empty for a polyhedron.
    std::span<const Index> points(Index cell) const;

    /// Returns true if a cell has points between its corners, so that its edges may be curved.
    bool isSecondOrder(Index cell) const;

private:
    friend class VolumeMeshBuilder;
    struct Data;
    explicit VolumeMesh(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

    std::shared_ptr<const Data> data_;
};

/// Builds a VolumeMesh cell by cell. Cells that name the same points in a face, in the same cyclic
/// order or its reverse, share that face. If three cells do, the first two share it.
class ESPALIER_API VolumeMeshBuilder {
public:
    explicit VolumeMeshBuilder(Index pointCount) : pointCount_(pointCount) {}

    /// Adds a tetrahedron, pyramid, wedge or hexahedron. Returns its number.
    /// \param points in VTK's order; those of a cell of second order as in cellPoints()
    /// \throws TopologyError if the number of points is wrong, or if a point does not exist
    Index addCell(StandardCell cell, std::span<const Index> points);
    Index addCell(StandardCell cell, std::initializer_list<Index> points) {
        return addCell(cell, std::span(points.begin(), points.size()));
    }

    /// Adds a polyhedron. Returns its number.
    /// \param loops its faces, each anticlockwise seen from outside
    /// \throws TopologyError if a face has fewer than three points, or if a point does not exist
    Index addCell(std::span<const std::vector<Index>> loops);

    Index cellCount() const { return static_cast<Index>(points_.offsets.size() - 1); }

    /// Returns the mesh. The builder must not be used afterwards.
    /// \throws TopologyError if there are too many faces
    /// \cost O(n log n) in the number of entries, one thread: 0.7 µs per hexahedron
    VolumeMesh build();

private:
    void checkPoints(std::span<const Index> points, Index cell) const;

    Index pointCount_;
    Rows<Index> points_;        ///< the points of each cell; empty rows for polyhedra
    Rows<Index> loops_;         ///< the faces of polyhedra
    Rows<Index> loopsOfCells_;  ///< the rows of loops_ of each cell
};

}  // namespace espalier::far
