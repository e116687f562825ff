// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

namespace espalier::io {

/// A type of elements of Abaqus or CalculiX. The nodes of solids and of faces are in VTK's order.
struct AbaqusElement {
    int dimension = -1;     ///< 0 to 3; -1 for a type that is not known here
    std::size_t nodes = 0;  ///< the number of nodes of a solid or of a face; 0 for all others
    bool isCurved = false;  ///< of second order
    bool isShell = false;   ///< a face in space, and not in the plane of the mesh
};

/// Returns the type of elements that a name means, in any case: "C3D20R" is a hexahedron of 20
/// nodes. Letters after the number of nodes tell how an element is computed, and do not matter.
/// Cohesive elements and gaskets are not known, since their cells may be flat.
AbaqusElement abaqusElement(std::string_view name);

}  // namespace espalier::io
