// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/transform.h>

#include <span>
#include <vector>

namespace espalier::shapes {

/// Whether the last layer of a sweep is joined to the first by one more row of cells.
enum class SweepEnds { Open, Closed };

/// Joins copies of a mesh, one a layer, by prisms: a face of n vertices and its copy in the next
/// layer bound a cell of n + 2 faces. Open meshes, holes and separate pieces are fine.
///
/// Vertex v of the mesh in layer k is vertex k · V + v, and the cell over face f from layer k to
/// layer k + 1 is cell k · F + f. The faces of a cell are: the one in layer k, the one in layer
/// k + 1, then one an edge, in loop order.
///
/// The faces of the mesh must run anticlockwise seen from the next layer; cells come out with
/// negative volume otherwise. (Faces wound against their neighbours are turned.) The topology
/// depends on the mesh and the number of layers alone, so that sweeping one mesh through two sets
/// of layers gives two poses of one lattice.
///
/// Attributes are copied to each layer. The marks of the mesh go to its copies in the first and the
/// last layer, if the ends are open; besides, a mark on a vertex goes to the edges which that
/// vertex sweeps, so that a corner of the mesh becomes a sharp edge of the lattice.
///
/// \param mesh of dimension 2 (far::buildMesh makes its complex from loops), each edge in one or
///             two faces; its positions are not used
/// \param layers positions, one a vertex in each; at least 2 layers, or 3 if the ends are closed
/// \throws Error naming what does not fit; far::TopologyError for a mesh that cannot be oriented,
///         or too many entities
/// \cost O(n log n) in the number of entries of the result
/// \cite MacCracken & Joy 1996, section 5
ESPALIER_API Lattice sweep(const Lattice& mesh, std::span<const std::vector<Point3>> layers,
                           SweepEnds ends = SweepEnds::Open);

/// The same with layers that are images of the mesh under affine maps.
ESPALIER_API Lattice sweep(const Lattice& mesh, std::span<const Affine> stations,
                           SweepEnds ends = SweepEnds::Open);

/// Translations to layers + 1 places at equal distances on a line: by `from` first, by `to` last,
/// both exactly.
/// \param layers 1 or more
ESPALIER_API std::vector<Affine> stationsBetween(const Point3& from, const Point3& to, int layers);

struct ExtrudeOptions {
    Point3 direction = {0, 0, 1};  ///< from the first layer to the last
    int layers = 1;                ///< layers of cells: 1 or more
};

/// Sweeps a mesh straight along a vector, in layers of equal thickness. The faces may be wound
/// either way.
///
/// \throws Error as sweep() does; and for a face that lies along the direction, or that looks
///         against it where its neighbours look with it: its cells would have no volume, or a
///         negative one
ESPALIER_API Lattice extrude(const Lattice& mesh, const ExtrudeOptions& options = {});

}  // namespace espalier::shapes
