// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>

namespace espalier::limit {

/// A place in the limit of a hexahedron of a level: (u, v, w) in [0, 1]³, along the axes that
/// far::hexahedronVertices() gives: u from vertex 0 to 1, v to 3, w to 4.
struct LimitLocation {
    Index cell = 0;
    std::array<double, 3> uvw = {};
};

struct LimitStencilOptions {
    /// As LimitOptions::tolerance; the size is that of what surrounds the cell on its level.
    double tolerance = kLimitTolerance;

    int derivatives = 0;  ///< 0, 1 or 2: up to which order
};

/// Rows for places in the limit, over the base vertices: of the position, which sum to 1, and of
/// its derivatives by u, v and w, which sum to 0. Tables that were not asked for are 0 × 0. All are
/// for the same evaluators as any other.
///
/// In regular cells they are exact, those of a tricubic B-spline. Around irregular features so are
/// they in the regular cells of further levels. What is left there is blended from the exact limits
/// of its vertices: position and first derivatives are those of the blend, which at the feature
/// itself need not tend to anything; second ones by the same coordinate twice are 0.
struct LimitStencils {
    stencils::StencilTable<double> position;
    std::array<stencils::StencilTable<double>, 3> first = {};   ///< by u, v, w
    std::array<stencils::StencilTable<double>, 6> second = {};  ///< by uu, uv, uw, vv, vw, ww
};

/// \param refiner with level `level`, whole
/// \param locations in that level
/// \throws Error for a level that is not there, a cell that is not there or no hexahedron, a place
///         outside of [0, 1]³, on what shrinks away under Boundary::Open, options that are out of
///         range
/// \cost O(entries); near irregular features also some 0.2 ms for each level of refinement there.
///       In parallel
/// \cite MacCracken & Joy 1996, section 2.2; CSE-96-1, section 5; Joy, bicubic refinement
ESPALIER_API LimitStencils buildLimitStencils(const far::TopologyRefiner& refiner, int level,
                                              std::span<const LimitLocation> locations,
                                              const LimitStencilOptions& options = {});

/// The same for all vertices of a level: row i is that of vertex i. Positions are exact everywhere:
/// those of buildVertexLimits(). Derivatives are along the axes of the hexahedron of the lowest
/// number that the vertex is a corner of; rows of a vertex in none are empty, and so are all of an
/// open vertex.
ESPALIER_API LimitStencils buildLimitStencils(const far::TopologyRefiner& refiner, int level,
                                              const LimitStencilOptions& options = {});

}  // namespace espalier::limit
