// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>

#include <array>

namespace espalier::far {

/// How large a level of a complex is. Real numbers, since that of a level that cannot be made may
/// be beyond all integers; exact up to 2^53.
struct LevelSize {
    std::array<double, kMaxDimension + 1> counts = {};  ///< entities of each dimension

    double faceEdges = 0;     ///< pairs of a face and an edge of it
    double cellFaces = 0;     ///< pairs of a cell and a face of it
    double cellEdges = 0;     ///< pairs of a cell and an edge of it
    double cellVertices = 0;  ///< pairs of a cell and a vertex of it

    /// Bytes that its CellComplex takes at least, without what it derives.
    double bytes() const;
};

/// The size of a level, known without refining to it. (Under Boundary::Open levels are smaller.)
///
/// \param levels how many levels above `complex`, 0 or more
/// \cost O(1), and the relations of `complex` that refinement derives anyway
/// \cite Azlan & Misro, Table 2, for the counts of polyhedra; the rest follows from the intervals
///       of Refinement
ESPALIER_API LevelSize levelSize(const CellComplex& complex, int levels);

}  // namespace espalier::far
