// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/transform.h>

#include <span>
#include <vector>

/// \file
/// Makes lattices by sweeping and extruding meshes.

namespace espalier::shapes {

/// Tells whether one more row of cells joins the last layer of a sweep to the first.
enum class SweepEnds { Open, Closed };

/// Makes a lattice from copies of a mesh, one per layer, joined by prisms: a face of n vertices and
/// its copy in the next layer bound a cell of n + 2 faces. The mesh may be open, and may have holes
/// and separate pieces.
///
/// With V vertices and F faces in the mesh, vertex v in layer k is vertex k · V + v of the lattice,
/// and the cell over face f from layer k to layer k + 1 is cell k · F + f. The faces of a cell are:
/// the face in layer k, the face in layer k + 1, then one face per edge, in loop order.
///
/// The faces of the mesh must run anticlockwise seen from the next layer; otherwise cells have
/// negative volume. (Faces wound against their neighbours are reversed.) The topology depends only
/// on the mesh and the number of layers, so that sweeping one mesh through two sets of layers gives
/// two poses of one lattice.
///
/// Attributes are copied to each layer. If the ends are open, the copies of the mesh in the first
/// and the last layer get its marks. A mark on a vertex also goes to the edges that the vertex
/// sweeps, so that a corner of the mesh becomes a sharp edge of the lattice.
///
/// \param mesh a mesh of dimension 2 (far::buildMesh makes its complex from loops), with each edge
///        in one or two faces; its positions are not used
/// \param layers positions of each layer, one per vertex; at least 2 layers, or 3 if the ends are
///        closed
/// \throws Error naming the argument that does not fit; far::TopologyError for a mesh that cannot
///         be oriented, or too many entities
/// \cost O(n log n) in the number of entries of the result
/// \cite MacCracken & Joy 1996, section 5
ESPALIER_API Lattice sweep(const Lattice& mesh, std::span<const std::vector<Point3>> layers,
                           SweepEnds ends = SweepEnds::Open);

/// The same with layers that are images of the mesh under affine maps.
ESPALIER_API Lattice sweep(const Lattice& mesh, std::span<const Affine> stations,
                           SweepEnds ends = SweepEnds::Open);

/// Returns translations to layers + 1 places at equal distances on a line: the first by `from` and
/// the last by `to`, both exactly.
/// \param layers 1 or more
ESPALIER_API std::vector<Affine> stationsBetween(const Point3& from, const Point3& to, int layers);

/// Options of extrude().
struct ExtrudeOptions {
    Point3 direction = {0, 0, 1};  ///< vector from the first layer to the last
    int layers = 1;                ///< layers of cells: 1 or more
};

/// Makes a lattice by sweeping a mesh straight along a vector, in layers of equal thickness. The
/// faces may be wound either way.
///
/// \throws Error as sweep(); also for a face that is parallel to the direction, or that faces the
///         other way than its neighbours: its cells would have zero or negative volume
ESPALIER_API Lattice extrude(const Lattice& mesh, const ExtrudeOptions& options = {});

}  // namespace espalier::shapes
