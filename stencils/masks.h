// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/topology_refiner.h>

#include <array>

namespace espalier::stencils {

/// The new point of an entity as an affine combination of averages. Entry j is the weight of the
/// average of the centroids of the incident entities of dimension j; if j is the entity's own
/// dimension, the entity itself. In the papers' letters, the averages are P, M̄, Ā and C̄ for j =
/// 0, 1, 2, 3. Entries sum to 1; entries below the entity's dimension or above its stratum are 0.
using Mask = std::array<double, kMaxDimension + 1>;

/// Returns the refinement rule of an entity of dimension `dimension` on stratum `stratum`. For
/// Catmull-Clark:
///
///     stratum  cell   face           edge                     vertex
///     3        C      (C̄ + A)/2      see Rules                (C̄ + 3Ā + 3M̄ + P)/8
///     2               A              (Ā + M)/2                (Ā + 2M̄ + (n − 3)P)/n
///     1                              M                        (M̄ + P)/2
///     0                                                       P
///
/// With two cells at a face, (C̄ + A)/2 is the paper's (C₀ + 2A + C₁)/4; with two faces at an edge
/// of the surface, (Ā + M)/2 is (A₀ + A₁ + P₀ + P₁)/4; with two edges at a vertex of a curve, (M̄ +
/// P)/2 is (P₋ + 6P + P₊)/8.
///
/// Weights may be negative: the weight of M if two faces meet in an interior edge (−1/2), and the
/// weight of P if two edges meet in a surface vertex (−1/2). The convex-hull property fails there.
///
/// For RATS, the average of dimension `stratum`, from which its new points are made (rats.h).
///
/// MLCA has no masks, since its averages have unequal weights (mlca.h).
///
/// \param rules not Rules::Mlca
/// \param dimension 0 to 3, at most `stratum`
/// \param stratum 0 to 3
/// \param valence n: for an edge on stratum 3, its number of faces; for a vertex on stratum 2, its
///        number of edges on the surface; at least 1; otherwise not used
/// \cite MacCracken & Joy 1996, sections 2.2 and 3; Joy, bicubic refinement, "face", "edge" and
///       "vertex" points (stratum 2); CSE-96-1, section 2 (stratum 1)
ESPALIER_API Mask refinementMask(far::Rules rules, int dimension, int stratum, Index valence);

/// Returns the rule of an edge on stratum 2 under TriangleSubdivision::Smooth: M (1 − 2w) + 2w Ā,
/// where w is the mean, over the faces at the edge, of 0.47 for a triangle and 1/4 for any other
/// face.
///
/// \param triangles number of triangles among the two faces at the edge: 0 to 2
/// \cite OpenSubdiv 3.5, Sdc::Scheme<SCHEME_CATMARK>, after Stam
ESPALIER_API Mask smoothTriangleMask(int triangles);

}  // namespace espalier::stencils
