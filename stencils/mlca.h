// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>

#include <cstddef>
#include <vector>

/// \file
/// MLCA, multilinear cell averaging (Bajaj, Schaefer, Warren & Xu). Children and strata are the
/// same as for other rules. One rule gives all new points: split multilinearly, then move each
/// vertex to the mean of the centroids of the sub-cells around it.
///
/// The split puts a vertex on the centroid of each entity. It cuts an entity b into one sub-cell
/// [v, b] for each corner v of b; the vertices of [v, b] are the centroids of the entities y
/// between v and b. Only sub-cells of dimension s in the vertex's stratum s move a vertex. So the
/// new point of an entity x on stratum s is
///
///     the mean, over the [v, b] with v in x, x in b and dim b = s in the sub-complex of s,
///     of the means, over the y with v in y and y in b, of the centroids of y
///
/// This rule holds for cells of any kind, and for curves, meshes and lattices. It uses only the
/// entities that contain x, with all their parts. All weights are positive, so refinement stays in
/// the convex hull. In the letters of masks.h, the rule is:
///
///     stratum 3, of hexahedra   C      (C̄ + A)/2   (C̄ + 2Ā + M)/4   (C̄ + 3Ā + 3M̄ + P)/8
///     stratum 2                        A           (Ā + M̄' + 2M)/4  (Ā + 2M̄ + P)/4
///     stratum 1                                    M                 (M̄ + P)/2
///     stratum 0                                                      P
///
/// Here M̄ counts an edge as often as it has cells around the vertex: three times if three cells
/// meet in it. Ā needs no such weights, since every interior face has two cells. M̄' is the mean
/// midpoint of the edges before and after the edge in its faces. It is equal to Ā if these faces
/// are quadrilaterals: for them and for hexahedra, the centroid of [v, b] is the multilinear map at
/// a quarter of the way from v. The vertex rule holds if three edges of each cell meet in the
/// vertex. Cells of other types give other weights; for example, the point of a pyramid is nearer
/// to its apex than C is. On grids, all this is the cubic B-spline, as for Catmull-Clark.
///
/// \cite Bajaj, Schaefer, Warren & Xu, A subdivision scheme for hexahedral meshes, The Visual
///       Computer 18 (2002): the rule for hexahedra, boundaries and creases. We apply the same rule
///       to cells of any other kind

namespace espalier::stencils {

/// Returns the entities between a corner of `whole` and `whole`, whose centroids are the vertices
/// of the sub-cell at the corner: 2 on an edge, 4 on a face, 2n + 2 if n edges of a cell meet in
/// the corner.
///
/// \param corner position of a vertex in complex.relation(whole.dimension, 0)[whole.index]. If the
///        loop of a face passes a vertex twice, the vertex has two sub-cells
/// \cost O(edges and faces at the vertex)
ESPALIER_API std::vector<Entity> mlcaSubCell(const far::CellComplex& complex, Entity whole,
                                             std::size_t corner);

}  // namespace espalier::stencils
