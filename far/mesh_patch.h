// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/incidence.h>

#include <string>
#include <vector>

namespace espalier::far {

/// A named part of a mesh: a patch of its boundary, such as a wall, or a group of its cells.
struct MeshPatch {
    std::string name;

    /// The type that the file gives: "symmetryPlane" of OpenFOAM, "BCSymmetryPlane" of CGNS. Empty
    /// if the format has none.
    std::string type = {};

    /// The corners of the faces, in the order of the file; none for a group of cells.
    Rows<Index> faces = {};

    /// The points of the faces or cells, ascending.
    std::vector<Index> points = {};

    /// The patch of the same faces on the other side of a periodic mesh; empty if there is none.
    std::string partner = {};
};

}  // namespace espalier::far
