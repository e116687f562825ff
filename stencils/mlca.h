// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>

#include <cstddef>
#include <vector>

/// \file
/// MLCA, multilinear cell averaging (Bajaj, Schaefer, Warren & Xu): the children and strata of
/// every refinement here, and one rule for all new points: split multilinearly, then move each
/// vertex to the mean of the centroids of the sub-cells around it.
///
/// The split puts a vertex on the centroid of each entity, and cuts an entity b into one sub-cell
/// [v, b] at each corner v of it: its vertices are the centroids of the entities y between v and b.
/// A vertex of stratum s is moved by the sub-cells of dimension s in its stratum alone. So the new
/// point of an entity x on stratum s is
///
///     the mean, over the [v, b] with v in x, x in b and dim b = s in the sub-complex of s,
///     of the means, over the y with v in y and y in b, of the centroids of y
///
/// That is one rule, for any cells and for curves, meshes and lattices. It reads no more than the
/// entities that contain x, with all their parts. All weights are positive: what is refined stays
/// in the hull. What it comes to, in the letters of masks.h:
///
///     stratum 3, of hexahedra   C      (C̄ + A)/2   (C̄ + 2Ā + M)/4   (C̄ + 3Ā + 3M̄ + P)/8
///     stratum 2                        A           (Ā + M̄' + 2M)/4  (Ā + 2M̄ + P)/4
///     stratum 1                                    M                 (M̄ + P)/2
///     stratum 0                                                      P
///
/// Here M̄ counts an edge as often as it has cells around the vertex, three times where three meet
/// in it; Ā needs no such care, as every face inside has two cells. M̄' is the mean midpoint of the
/// edges before and after the edge in its faces: Ā where these are quadrilaterals, as for them and
/// for hexahedra the centroid of [v, b] is the multilinear map at a quarter of the way from v. The
/// vertex rule holds wherever three edges of each cell meet in the vertex. Other cells have other
/// rules: the point of a pyramid is nearer to its apex than C is. On grids all this is the cubic
/// B-spline, as Catmull-Clark is.
///
/// \cite Bajaj, Schaefer, Warren & Xu, A subdivision scheme for hexahedral meshes, The Visual
///       Computer 18 (2002): the rule, for hexahedra, and for boundaries and creases. Cells of any
///       other kind are ours, by the same words

namespace espalier::stencils {

/// The entities from a corner of `whole` to `whole`, whose centroids are the vertices of the
/// sub-cell there: 2 on an edge, 4 on a face, 2n + 2 where n edges of a cell meet.
///
/// \param corner of the vertices of `whole`, complex.relation(whole.dimension, 0), the position of
///        one. Where the loop of a face passes a vertex twice there are two sub-cells
/// \cost O(edges and faces at the vertex)
ESPALIER_API std::vector<Entity> mlcaSubCell(const far::CellComplex& complex, Entity whole,
                                             std::size_t corner);

}  // namespace espalier::stencils
