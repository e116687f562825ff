// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/topology_refiner.h>

#include <array>

namespace espalier::stencils {

/// The new point of an entity as an affine combination of averages: entry j is the weight of the
/// average of the centroids of the incident entities of dimension j (itself, where j is its own
/// dimension; P, M̄, Ā and C̄ in the papers' letters for j = 0, 1, 2, 3). Entries sum to 1; those
/// below the entity's dimension or above its stratum are 0.
using Mask = std::array<double, kMaxDimension + 1>;

/// The refinement rule of an entity of dimension `dimension` on stratum `stratum`. Of
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
/// Weights may be negative: that of M where two faces meet in an interior edge (−1/2), and that of
/// P where two edges meet in a surface vertex (−1/2). The convex-hull property fails there.
///
/// Of RATS: the average of dimension `stratum`, of which its new points are made (rats.h).
///
/// MLCA has no masks: its averages have weights (mlca.h).
///
/// \param rules not Rules::Mlca
/// \param dimension 0 to 3, at most `stratum`
/// \param stratum 0 to 3
/// \param valence n: of an edge on stratum 3 the number of its faces, of a vertex on stratum 2 the
///        number of its edges on the surface; at least 1; not used otherwise
/// \cite MacCracken & Joy 1996, sections 2.2 and 3; Joy, bicubic refinement, "face", "edge" and
///       "vertex" points (stratum 2); CSE-96-1, section 2 (stratum 1)
ESPALIER_API Mask refinementMask(far::Rules rules, int dimension, int stratum, Index valence);

/// The rule of an edge on stratum 2 under TriangleSubdivision::Smooth: M (1 − 2w) + 2w Ā, where w
/// is the mean of 0.47 for each triangle and 1/4 for each other face at the edge.
///
/// \param triangles how many of the two faces at the edge are triangles: 0 to 2
/// \cite OpenSubdiv 3.5, Sdc::Scheme<SCHEME_CATMARK>, after Stam
ESPALIER_API Mask smoothTriangleMask(int triangles);

}  // namespace espalier::stencils
