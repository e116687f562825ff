// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>

#include <span>
#include <string>
#include <vector>

namespace espalier::shapes {

struct MergeOptions {
    /// Vertices at most this far apart become one, as a fraction of the diagonal of the box around
    /// all lattices: 0 or more, below 1. The default is a million times the rounding of double
    /// arithmetic, so that the same point reached by two computations is one vertex, and far below
    /// the spacing of vertices that are meant to differ. Positions that went through a file of
    /// floats need about 1e-6.
    double tolerance = 1e-9;
    /// Names of the lattices in messages: one a lattice, for example the paths of their files.
    /// Empty for "lattice 0", "lattice 1" and so on.
    std::vector<std::string> names = {};
};

/// Joins lattices (or meshes, or curves) by welding vertices that coincide. Faces whose vertices
/// are all welded are then shared, and cells are neighbours across them. Merging a single lattice
/// welds its own vertices.
///
/// Vertices, edges, faces and cells are numbered in the order of their first appearance, lattice by
/// lattice. A welded vertex takes its position, its attributes and its integers from the first
/// lattice that has it. Marks are carried over; of two on one edge or vertex the later one counts,
/// as ever.
///
/// Only whole faces are shared: lattices that touch in faces of different shape stay apart there,
/// joined at the vertices that they have in common.
///
/// \param lattices at least one, all of one dimension and with the same attributes
/// \throws Error for no lattice, a tolerance out of range, another number of names than of
///         lattices, or an attribute that one lattice lacks or has with another number of
///         components or, of integers, another type; far::TopologyError for a cell of which two
///         vertices would become one, a cell that is in two lattices, or a face of three cells.
///         These messages name the lattices, and number cells and faces as their own lattice does
/// \cost O(n log n) in the number of entries of the result; the search for coincident vertices is
///       linear while the vertices are spread out, as those of a lattice are
/// \cite MacCracken & Joy 1996, section 5
ESPALIER_API Lattice merge(std::span<const Lattice> lattices, const MergeOptions& options = {});

/// The same for two.
ESPALIER_API Lattice merge(const Lattice& first, const Lattice& second,
                           const MergeOptions& options = {});

}  // namespace espalier::shapes
