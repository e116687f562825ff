// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>

// Builds rows for places in the limit volume: positions and derivatives.
namespace espalier::limit {

/// A place in the limit of a hexahedron of a level: (u, v, w) in [0, 1]³, along the axes that
/// far::hexahedronVertices() gives: u from vertex 0 to vertex 1, v from 0 to 3, w from 0 to 4.
struct LimitLocation {
    Index cell = 0;
    std::array<double, 3> uvw = {};
};

struct LimitStencilOptions {
    /// As LimitOptions::tolerance, but relative to the size of the neighbourhood of the cell on its
    /// level.
    double tolerance = kLimitTolerance;

    int derivatives = 0;  ///< highest order of the derivatives: 0, 1 or 2
};

/// Rows for places in the limit, over the base vertices. Rows of the position sum to 1, rows of the
/// derivatives by u, v and w to 0. Tables that were not requested are 0 × 0. Every evaluator
/// accepts these tables.
///
/// In regular cells the rows are the exact rows of a tricubic B-spline. Around irregular features
/// they are exact in the regular cells of further levels. In the cells that stay irregular, the
/// exact limits of their vertices are blended. There, the rows give the position and the first
/// derivatives of the blend, and second derivatives by the same coordinate twice are 0. At the
/// feature itself the derivatives of the blend need not converge.
struct LimitStencils {
    stencils::StencilTable<double> position;
    /// Derivatives by u, v and w.
    std::array<stencils::StencilTable<double>, 3> first = {};
    /// Derivatives by uu, uv, uw, vv, vw and ww.
    std::array<stencils::StencilTable<double>, 6> second = {};
};

/// Builds the rows of places in the limit.
/// \param refiner with the whole of level `level`
/// \param locations places in this level
/// \throws ArgumentError for options out of range; Error for a level or cell that does not exist, a
///         cell that is not a hexahedron, a place outside [0, 1]³ or in a region that shrinks away
///         under Boundary::Open
/// \cost O(entries); near irregular features also about 0.2 ms for each further level. In parallel
/// \cite MacCracken & Joy 1996, section 2.2; CSE-96-1, section 5; Joy, bicubic refinement
ESPALIER_API LimitStencils buildLimitStencils(const far::TopologyRefiner& refiner, int level,
                                              std::span<const LimitLocation> locations,
                                              const LimitStencilOptions& options = {});

/// Builds the rows of all vertices of a level: row i belongs to vertex i. Positions are exact
/// everywhere, as in buildVertexLimits(). Derivatives are along the axes of the lowest-numbered
/// hexahedron that has the vertex as a corner. A vertex in no hexahedron has empty rows of
/// derivatives; all rows of an open vertex are empty.
ESPALIER_API LimitStencils buildLimitStencils(const far::TopologyRefiner& refiner, int level,
                                              const LimitStencilOptions& options = {});

}  // namespace espalier::limit
