// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/io/model.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "cell_visitor.h"
#include "patch_collector.h"

namespace espalier::io {

/// Collects the cells of a mesh, and turns those of a volume right-handed, as far::VolumeMesh
/// describes them. Files disagree about this: VTK and Gmsh order the points of a wedge in opposite
/// ways, VTK does not prescribe the direction of the faces of a polyhedron, and some meshes are
/// mirror images.
class ESPALIER_API MeshCells final : public CellVisitor {
public:
    bool wantsGroups() const override { return true; }
    void beginGroups(std::span<const std::string> names) override { patches_.begin(names); }
    void groupPoints(int dimension, std::span<const Index> points) override {
        patches_.add(dimension, points);
    }
    void groupSide(int dimension, std::span<const Index> corners,
                   std::span<const Index> points) override;
    void cell(far::StandardCell kind, std::span<const Index> points) override;

    /// \param loops the faces, each in any direction
    void polyhedron(std::span<const std::vector<Index>> loops) override;

    void face(std::span<const Index> points) override;
    void periodic(const std::string& group, const std::string& partner,
                  std::span<const std::array<Index, 2>> images) override {
        patches_.addImages(group, partner, images);
    }
    void smallCell(int dimension, std::span<const Index> points) override;
    void curvedCell(int dimension, std::span<const Index> points) override;

    void unknownElement(std::size_t, const std::string&) override { ++unknownElements_; }

    /// Returns the mesh. If most standard cells of a kind have a negative volume, all cells of this
    /// kind are turned; the cells of this kind that had a positive volume then are inside out. Each
    /// polyhedron gets faces that agree along their edges, and a positive volume. Without cells of
    /// a volume, the faces are the mesh.
    /// \param positions one per point
    /// \throws TopologyError if a cell names a point that does not exist
    ModelCells finish(std::span<const Point3> positions);

private:
    /// Gives the faces of a mesh without a volume, or counts the faces that are no faces of cells.
    void giveFaces(ModelCells& cells, Index pointCount) const;

    struct Cell {
        bool isStandard;
        far::StandardCell kind;
        std::size_t begin;  ///< position in points_ or in loops_
        std::size_t end;
    };

    std::vector<Cell> cells_;
    std::vector<Index> points_;  ///< the points of standard cells
    std::vector<std::vector<Index>> loops_;
    PatchCollector patches_;
    far::Rows<Index> faces_;  ///< faces of surfaces with 3, 4, 6, 8 or 9 points
    Index polygons_ = 0;
    Index curvedCells_ = 0;
    Index curvedFaces_ = 0;
    Index unknownElements_ = 0;
};

}  // namespace espalier::io
