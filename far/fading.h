// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/strata.h>

#include <array>
#include <optional>

/// \file
/// What becomes of semi-sharp features in the next split.
namespace espalier::far {

/// The sharpness of the child edge [vertex, edge].
/// \param edge an edge, `vertex` one of its ends
/// \cost constant under Creasing::Uniform; O(edges at the vertex) under Creasing::Chaikin
ESPALIER_API float childSharpness(const CellComplex& complex, const Strata& strata,
                                  Creasing creasing, const Entity& edge, Index vertex);

/// An edge or vertex that loses its stratum in the next split, with sharpness that runs out. Its
/// new point is `weight` of the rule of its stratum and 1 − weight of the rule of stratum `next`.
struct Fading {
    int next = 0;
    double weight = 1;
    /// The edges of the crease that a vertex is left on, if it is left on one. All of a curve has
    /// stratum 1, where there is none.
    std::optional<std::array<Index, 2>> staySharp = {};
};

/// How an entity fades in the next split, if it does.
///
/// The weight of an edge is its sharpness, that of a vertex the mean sharpness of all that fades
/// in it, at most 1. Under Creasing::Chaikin an edge that fades at one end only may have a
/// sharpness above 1; the rules are then extrapolated, as in OpenSubdiv.
///
/// \cost O(edges at the ends of the entity); constant if nothing is semi-sharp
/// \cite OpenSubdiv 3.5, Sdc::Scheme::ComputeVertexVertexMask and ComputeEdgeVertexMask
ESPALIER_API std::optional<Fading> fadingOf(const CellComplex& complex, const Strata& strata,
                                            Creasing creasing, const Entity& entity);

}  // namespace espalier::far
