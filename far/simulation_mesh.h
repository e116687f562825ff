// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/incidence.h>
#include <espalier/far/surface_mesh.h>
#include <espalier/far/volume_mesh.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace espalier::far {

/// A named part of a mesh: a patch of its boundary, such as a wall, or a group of its cells.
struct MeshPatch {
    std::string name;

    /// The type that the file gives: "symmetryPlane" of OpenFOAM. Empty if the format has none.
    std::string type = {};

    /// The corners of its faces, in the order of the file.
    Rows<Index> faces = {};

    /// 2 or 3: the largest dimension of its elements; in a mesh of two dimensions, 1 for a patch. 0
    /// for a set of points.
    int dimension = 0;

    /// The points of the elements, ascending.
    std::vector<Index> points = {};

    /// The number of its first face among the faces of the volume, where the others follow. Only of
    /// OpenFOAM.
    std::optional<Index> firstFace = {};

    /// The points of its lines, the two ends of a line first, in the order of the file.
    Rows<Index> lines = {};

    /// The patch of the same faces on the other side of a periodic mesh; empty if there is none.
    std::string partner = {};

    /// Points of the patch, each with its image in the partner. If there are none, face i of the
    /// patch is face i of the partner, which goes around in the other direction from the same first
    /// corner.
    std::vector<std::array<Index, 2>> images = {};

    Index faceCount() const { return static_cast<Index>(faces.count()); }
};

/// A part of a mesh that a program keeps in files of its own, such as the cells of one process.
struct MeshPart {
    std::string name;  ///< "processor0"
    Index firstCell = 0;
};

/// The mesh of a simulation. It has no positions.
struct SimulationMesh {
    VolumeMesh volume = {};

    /// The faces of a mesh that has no cells of a volume; then they are its cells.
    SurfaceMesh surface = {};

    std::vector<MeshPatch> patches = {};

    /// The parts from which the mesh was put together, in the order of their cells. Empty if it was
    /// in one.
    std::vector<MeshPart> parts = {};

    /// True if the cells are the faces of `surface`.
    bool isSurface() const { return volume.cellCount() == 0; }

    Index cellCount() const { return isSurface() ? surface.faceCount() : volume.cellCount(); }

    /// Returns the number of a cell as text, with its place in the files of a mesh in parts: "153",
    /// or "153 (28 of processor1)".
    std::string cellText(Index cell) const {
        const auto next = std::upper_bound(
            parts.begin(), parts.end(), cell,
            [](Index number, const MeshPart& part) { return number < part.firstCell; });
        if (next == parts.begin()) return std::to_string(cell);
        const MeshPart& part = *(next - 1);
        return std::to_string(cell) + " (" + std::to_string(cell - part.firstCell) + " of " +
               part.name + ")";
    }
};

}  // namespace espalier::far
