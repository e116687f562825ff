// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/marks.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <span>
#include <vector>

#include <espalier/cages/collar.h>

#include "plane_normals.h"

// The cells of a collar, before they are added to the lattice.
namespace espalier::cages {

/// A prism between a face and its copy in the next layer.
struct CollarPrism {
    std::vector<Index> bottom;  ///< anticlockwise seen from the top
    std::vector<Index> top;     ///< in the same order
};

/// A vertex of a collar.
struct CollarVertex {
    Index over = 0;  ///< the vertex of the lattice that it is over
    int layer = 1;   ///< 1 next to the lattice; the number of layers at the outer boundary
    Point3 position = {};
    bool isStraight = true;  ///< it is over a face, not at the edge or corner of a box

    PlaneNormals planes = {};  ///< of the open sides that it is at
};

/// The boundary faces of a lattice that get no cells.
struct OpenFaces {
    std::vector<char> isOpen;            ///< per face
    std::vector<PlaneNormals> planesAt;  ///< per vertex, of the open sides that it is at
};

/// New vertices are numbered from the number of vertices of the lattice on.
struct CollarCells {
    std::vector<CollarVertex> vertices;
    std::vector<CollarPrism> prisms;
    far::Marks marks = {};  ///< for edges and vertices of the outer boundary
    bool isGrid = false;
};

/// Returns, for k = 0 to the number of layers, the thickness of the layers 1 to k together as a
/// fraction of the thickness of the collar: 0 for the first k, and 1 for the last. From layer to
/// layer, the thickness grows by a constant factor of at least 1.
/// \param first desired thickness of the first layer
std::vector<double> layerParts(int layers, double reach, double first);

/// The unit vector of each of kSideWords.
Point3 sideDirection(std::size_t side);

/// Returns the vertex of the lattice that a vertex with the collar is or is over.
/// \param count number of vertices of the lattice
inline Index overOf(const CollarCells& cells, Index count, Index vertex) {
    return vertex < count ? vertex : cells.vertices[std::size_t(vertex - count)].over;
}

/// Adds the cells to the lattice.
Lattice joined(const Lattice& lattice, const CollarCells& cells);

/// Removes folds from the cells by moving their vertices, as far as it can (untangle.h).
/// \param weights of the cells of the lattice with the collar; cells of the weight 0 may fold
/// \param homes CollarCells::vertices where the outer ones shall not move far from
/// \param tether length of a move of an outer vertex that is costly, as a fraction of the distance
///        of its home from the vertex that it is over
void removeFolds(const Lattice& lattice, std::span<const double> weights,
                 std::span<const CollarVertex> homes, double tether, CollarCells& cells);

}  // namespace espalier::cages
