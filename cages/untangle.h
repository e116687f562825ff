// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>

#include <span>
#include <vector>

#include "plane_normals.h"

// Moves vertices of a lattice until no corner of a refined cell is folded.
namespace espalier::cages {

/// How a vertex may move.
struct VertexFreedom {
    bool isFree = false;
    PlaneNormals planes = {};

    /// Above 0: the energy grows by the fourth power of the distance from `home`, divided by this
    /// length. 0: the vertex may go far away.
    double tether = 0;
    Point3 home = {};
};

/// The cells to untangle.
struct TangledCells {
    const far::TopologyRefiner& base;         ///< a lattice at level 0
    std::span<const VertexFreedom> freedoms;  ///< one per vertex
    std::span<const double> lengths;          ///< the desired length of each edge, above 0
    std::span<const double> weights;          ///< of the energy of each cell; 0: it may fold
};

/// Moves the free vertices so that all corners of the hexahedra of level 1 have a positive volume,
/// and shapes that are near right angles with the desired lengths.
///
/// Let J be the matrix of the three edges of a corner, each divided by half of the desired length,
/// and d its determinant. The energy is the sum of (|J|² + |cof J|² / χ²)² with χ = (d + √(ε² +
/// d²)) / 2: the square of the symmetric Dirichlet energy |J|² + |J⁻¹|² for ε = 0. It is finite for
/// folded corners, and grows without bound for ε → 0. ε follows the smallest determinant until
/// there is no fold.
///
/// \param positions are changed
/// \return true if all corners have a positive volume
/// \cite Garanzha, Kaporin, Kudryavtseva, Protais, Ray & Sokolov 2021, Foldover-free maps in 50
///       lines of code
/// \cost O(corners of level 1) for each of at most a few thousand iterations
bool untangle(std::vector<Point3>& positions, const TangledCells& cells);

}  // namespace espalier::cages
