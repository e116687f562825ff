// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>

#include <span>
#include <string>
#include <vector>

/// \file
/// Joins lattices by welding vertices that coincide.

namespace espalier::shapes {

/// Options of merge().
struct MergeOptions {
    /// Vertices at most this far apart are welded, as a fraction of the diagonal of the box around
    /// all lattices: 0 or more, below 1. The default is a million times the rounding of double
    /// arithmetic, so that one point computed in two ways gives one vertex; it is far below the
    /// distance of vertices that should differ. Positions from a file of floats need about 1e-6.
    double tolerance = 1e-9;
    /// Names of the lattices in messages, one per lattice, for example the paths of their files. If
    /// empty, the names are "lattice 0", "lattice 1" and so on.
    std::vector<std::string> names = {};
};

/// Joins lattices (or meshes, or curves) by welding vertices that coincide. Faces whose vertices
/// are all welded are then shared, and cells are neighbours across them. Merging a single lattice
/// welds its own vertices.
///
/// Vertices, edges, faces and cells are numbered in the order of their first appearance, lattice by
/// lattice. A welded vertex takes its position, its attributes and its integers from the first
/// lattice that has it. Marks are kept; if two marks name the same edge or vertex, the later one
/// wins.
///
/// Only whole faces are shared. Lattices that touch in faces of different shape share the vertices
/// that coincide there, but no faces.
///
/// \param lattices at least one, all of one dimension and with the same attributes
/// \throws ArgumentError for a tolerance out of range; Error for no lattice, a wrong number of
///         names, or an attribute that one lattice lacks, or that has different numbers of
///         components or different integer types in two lattices; far::TopologyError for a cell
///         that would lose a vertex, a cell that is in two lattices, or a face of three cells.
///         These messages name the lattices, and number cells and faces as in their own lattice
/// \cost O(n log n) in the number of entries of all lattices
/// \cite MacCracken & Joy 1996, section 5
ESPALIER_API Lattice merge(std::span<const Lattice> lattices, const MergeOptions& options = {});

/// The same for two lattices.
ESPALIER_API Lattice merge(const Lattice& first, const Lattice& second,
                           const MergeOptions& options = {});

/// How merge() has joined lattices.
struct MergeJoints {
    Index weldedVertices = 0;  ///< how many vertices the result has fewer than the lattices
    Index sharedFaces = 0;     ///< faces (of meshes edges, of curves vertices) between two lattices
    /// Per lattice: the lowest number of a lattice that it is joined to by shared faces, directly
    /// or through other lattices. 0 for all if the result is in one piece.
    std::vector<std::size_t> groups = {};
};

/// Finds how merge() has joined lattices. Parts that were meant to match, and do not, have no
/// shared faces.
///
/// \param lattices the arguments of merge()
/// \param merged its result
/// \cost linear in the number of faces, plus the square of the number of lattices
ESPALIER_API MergeJoints findJoints(std::span<const Lattice> lattices, const Lattice& merged);

}  // namespace espalier::shapes
