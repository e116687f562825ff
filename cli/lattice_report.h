// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <map>
#include <string>
#include <vector>

namespace espalier::cli {

/// How many there are of each value.
using Histogram = std::map<Index, Index>;

/// One level of a lattice.
struct LevelReport {
    std::array<Index, 4> counts;  ///< vertices, edges, faces, cells
    Index eulerCharacteristic;
    std::array<std::array<Index, 4>, 4> strata;  ///< [dimension][stratum]
    Histogram vertexValences;                    ///< edges at a vertex
    Histogram edgeValences;                      ///< faces at an interior edge
    Histogram cellTypes;                   ///< level 0: edges of its cell at a vertex, for each
                                           ///< pair of vertex and cell; above: n of a type-n cell
    double smallestVolume, largestVolume;  ///< of a cell, signed
    Index invertedCells;                   ///< of a volume that is not positive
    double smallestScaledJacobian;         ///< at the corners of hexahedra: 1 for a cube, 0 for a
                                           ///< flat corner, below for a folded one; 1 without any
};

struct LatticeReport {
    Point3 boundsMin, boundsMax;
    std::size_t marks;
    std::vector<std::string> attributes;
    std::vector<LevelReport> levels;

    /// Interior edges of two faces: by the rules `siggraph96` their midpoint has a negative weight,
    /// and the refined lattice may leave the convex hull of the lattice near them (MacCracken & Joy
    /// 1996, section 2.2, n = 2).
    Index edgesOfTwoFaces;
};

/// \param positions one list a level of `refiner`
LatticeReport reportLattice(const Lattice& lattice, const far::TopologyRefiner& refiner,
                            const std::vector<std::vector<Point3>>& positions);

}  // namespace espalier::cli
