// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>

#include <vector>

/// \file
/// RATS splines (Savva & Clapworthy): the children and strata of every refinement here, with other
/// rules. They come from splitting a Bézier spline in its middle: corners are interpolated, and the
/// surface reaches the border.
///
/// Border is what has stratum 0 or 1: the boundary of a mesh, and its creases. The average of an
/// entity of stratum s is that of the s-dimensional centroids around it, within its stratum: P of a
/// corner, M̄ of a vertex on the border, F̄ of one inside. Each new point is such an average, or the
/// mean of several:
///
///     V   the average of the vertex
///     E   inside: the mean of the averages of its two ends. With an end that is further out, a
///         corner for a border edge or a border vertex for an inner one: its own average
///     F   inside: the mean of the averages of its vertices. With a border edge: that of its inner
///         edges that meet a border edge of it. With a corner: its own average

namespace espalier::stencils {

/// The ten types of new points, by what they are the point of. All of a curve is border: it has
/// V_α, V_β, E_α and E_β.
///
/// \cite Savva & Clapworthy, section 2 (1) to (10); the equations are those of a rectangular grid
enum class RatsPoint {
    VAlpha,  ///< corner vertex                                        Eq 4
    VBeta,   ///< border vertex                                        Eq 5, 6
    VGamma,  ///< inner vertex                                         Eq 7
    EAlpha,  ///< border edge with a corner                            Eq 8, 9
    EBeta,   ///< border edge without                                  Eq 10, 11
    EGamma,  ///< inner edge with an end on the border                 Eq 12, 13
    EDelta,  ///< inner edge without                                   Eq 14, 15
    FAlpha,  ///< face with a corner                                   Eq 16
    FBeta,   ///< face with a border edge, and no corner               Eq 17, 18
    FGamma   ///< face with neither; a vertex may lie on the border    Eq 19
};

/// The type of the new point of an entity of a curve or a mesh.
ESPALIER_API RatsPoint ratsPoint(const far::Level& level, Entity entity);

/// The entities of whose averages the new point of `entity` is the mean. A vertex that the loop of
/// a face passes twice is there twice.
///
/// A border face none of whose inner edges meets its border edges has itself: all its edges are
/// border edges then, and its centroid is also the mean of its new vertex points.
///
/// \cite Savva & Clapworthy, Eq 4 to 19; section 3 (F_γ and E_δ are means of new vertex points)
ESPALIER_API std::vector<Entity> ratsSources(const far::Level& level, Entity entity);

}  // namespace espalier::stencils
