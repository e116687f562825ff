// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/marks.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <vector>

#include <espalier/cages/collar.h>

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

    /// The plane that the vertex must stay in, by its unit normal; the zero vector if there is
    /// none: the vertex is at an open side.
    Point3 planeNormal = {0, 0, 0};
};

/// New vertices are numbered from the number of vertices of the lattice on.
struct CollarCells {
    std::vector<CollarVertex> vertices;
    std::vector<CollarPrism> prisms;
    far::Marks marks = {};  ///< for edges and vertices of the outer boundary
    bool isGrid = false;
};

/// Returns the part of the thickness of a collar that its layers up to layer k take, for k = 0 to
/// the number of layers; 0 and 1 at the ends. The thickness of the layers grows by a constant
/// factor of at least 1.
/// \param first desired thickness of the first layer
std::vector<double> layerParts(int layers, double reach, double first);

/// The unit vector of each of kSideWords.
Point3 sideDirection(std::size_t side);

}  // namespace espalier::cages
