// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <optional>
#include <vector>

#include "cube_parts.h"
#include "model_voxels.h"

namespace espalier::cages {

struct GridCellOptions {
    Index voxelsPerEdge = 8;                  ///< voxels along each edge of a cell
    std::array<Index, 3> offset = {0, 0, 0};  ///< voxels of the first cell outside the grid

    /// Parts of a model in one cell that are at most this far apart are one part, in voxels.
    double joinDistance = 1;

    /// A cell is left out if the model reaches less than this into it, in voxels, and nothing else
    /// depends on the cell.
    double reach = 0;

    /// Bit i: the voxels, and so the cells, are symmetric about the middle of the grid along axis
    /// i. The middle must be between two voxels, in the middle of a cell or between two.
    unsigned mirrorAxes = 0;
};

/// The cells of a grid around a model.
///
/// Each connected part of the model in a cube of the grid gets a cell of its own. Two cells share a
/// face if the model passes through it. So parts of the model that pass close to each other, even
/// in one cube, are not joined; their cells then overlap, and fitCage() moves them apart.
///
/// A cell is left out if the model reaches little into it, provided that the topology stays the
/// same. A neighbour must then be stretched. Where two parts in one cube meet a third part through
/// one face, one of the two is left out, if the topology stays the same and the model reaches
/// little into it; else they are joined. Where cells would touch in an edge or a vertex only,
/// another cell is added. The boundary is a manifold.
class GridCells {
public:
    /// \param voxels is kept by reference
    GridCells(const ModelVoxels& voxels, const GridCellOptions& options);

    Index cellCount() const { return cellCount_; }
    Index vertexCount() const { return vertexCount_; }

    /// Returns true if the boundary is a manifold. False only if adding cells does not help.
    bool isManifold() const { return isManifold_; }

    /// A place where two parts of the model run side by side for more than one cell and are joined
    /// all the same.
    const std::optional<Point3>& joined() const { return parts_.joined(); }

    /// Returns the lattice. Cells and vertices are numbered by layers.
    Lattice build() const;

    /// Returns the mirror image of each vertex across an axis of `mirrorAxes`.
    std::vector<Index> vertexImages(int axis) const;

    /// Returns the cell for a point of the model; none for a point far from it.
    std::optional<Index> cellOf(const Point3& point) const;

private:
    void leaveOut(double reach);
    bool joinConflicts(double reach);
    void resolveConflict(Index part, Index direction, double reach);
    void numberVertices();
    bool repair();
    bool closeDoubleFaces();
    bool repairVertices();

    CubeParts parts_;
    std::vector<std::array<Index, 8>> corners_;  ///< the vertices of each part
    std::vector<Index> order_;  ///< the parts that are cells, in the order of the cells
    std::vector<std::optional<Index>> cellOfPart_;
    Index cellCount_ = 0, vertexCount_ = 0;
    bool isManifold_ = false;
};

}  // namespace espalier::cages
