// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/limit/vertex_ring.h>
#include <espalier/stencils/masks.h>

#include <array>
#include <complex>
#include <vector>

namespace espalier::cli {

/// What refining does around an irregular vertex or edge of a lattice, for ever.
struct Smoothness {
    Entity entity;  ///< of level 0: a vertex or an edge
    int stratum;
    Index ringPoints;  ///< points of the ring, the point itself among them
    /// False for rings of more than kMaxRingPoints: they have no eigenvalues and no mask here.
    bool isKnown = false;
    /// Of the matrix from ring to ring, without the first one, 1; by descending modulus, six at
    /// most. Where the lattice is regular inside they are 1/2 three times, then 1/4.
    std::vector<std::complex<double>> eigenvalues = {};
    /// The limit: shares of the point itself, and of all points across edges, faces and cells, in
    /// the ring. Where the lattice is regular inside 8/27, 12/27, 6/27 and 1/27.
    std::array<double, 4> mask = {};
};

/// Largest ring whose eigenvalues are computed: they take seconds there, and eight times as long
/// for twice the points.
inline constexpr Index kMaxRingPoints = limit::kMaxEigenvalues;

/// One for each vertex and each edge of level 0 whose ring is not regular, in their order. An edge
/// is judged by the ring of its new point: those of the further ones on it are the same.
/// \cost O(n³) in the points of a ring, for each of up to kMaxRingPoints points
std::vector<Smoothness> reportSmoothness(const far::TopologyRefiner& lattice,
                                         stencils::Rules rules);

}  // namespace espalier::cli
