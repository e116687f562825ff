// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>

#include <vector>

/// \file
/// RATS splines (Savva & Clapworthy). Children and strata are the same as for other rules, but new
/// points are not. The rules come from splitting a Bézier spline in its middle: corners are
/// interpolated, and the surface reaches the border.
///
/// The border is all entities of stratum 0 or 1: the boundary of a mesh, and its creases. The
/// average of an entity of stratum s is the mean of the s-dimensional centroids around it, within
/// its stratum: P for a corner, M̄ for a vertex on the border, F̄ for a vertex inside. Each new
/// point is such an average, or the mean of several:
///
///     V   the average of the vertex
///     E   inside: the mean of the averages of its two ends. If an end has a lower stratum
///         (a border edge with a corner, or an inner edge with a border vertex): its own average
///     F   inside: the mean of the averages of its vertices. With a border edge: the mean of the
///         averages of its inner edges that meet a border edge of it. With a corner: its own
///         average

namespace espalier::stencils {

/// The ten types of new points, by parent entity. All of a curve is border, so it has V_α, V_β, E_α
/// and E_β only.
///
/// \cite Savva & Clapworthy, section 2 (1) to (10); the equations are for a rectangular grid
enum class RatsPoint {
    VAlpha,  ///< corner vertex                                        Eq 4
    VBeta,   ///< border vertex                                        Eq 5, 6
    VGamma,  ///< inner vertex                                         Eq 7
    EAlpha,  ///< border edge with a corner                            Eq 8, 9
    EBeta,   ///< border edge without a corner                         Eq 10, 11
    EGamma,  ///< inner edge with an end on the border                 Eq 12, 13
    EDelta,  ///< inner edge without an end on the border              Eq 14, 15
    FAlpha,  ///< face with a corner                                   Eq 16
    FBeta,   ///< face with a border edge, and no corner               Eq 17, 18
    FGamma   ///< face with neither; may have a vertex on the border   Eq 19
};

/// Returns the type of the new point of an entity of a curve or a mesh.
ESPALIER_API RatsPoint ratsPoint(const far::Level& level, Entity entity);

/// Returns the entities whose averages have the new point of `entity` as their mean. If the loop of
/// a face passes a vertex twice, the result contains the vertex twice.
///
/// A border face whose inner edges do not meet its border edges returns itself: all its edges are
/// border edges then, and its centroid is also the mean of its new vertex points.
///
/// \cite Savva & Clapworthy, Eq 4 to 19; section 3 (F_γ and E_δ are means of new vertex points)
ESPALIER_API std::vector<Entity> ratsSources(const far::Level& level, Entity entity);

}  // namespace espalier::stencils
