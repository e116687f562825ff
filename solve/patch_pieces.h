// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/simulation_mesh.h>

#include <span>
#include <vector>

// The smooth pieces of a patch; not installed.
namespace espalier::solve {

/// Faces or lines of a patch that are joined where they turn little.
struct PatchPiece {
    bool isOfLines = false;
    std::vector<Index> points = {};  ///< ascending
};

/// Divides a patch into pieces: faces that share an edge, or lines that share an end, are in one
/// piece if they turn there by at most 50 degrees. A face or a line without size joins all of its
/// neighbours. A patch without faces and lines is one piece of its points.
///
/// \return the pieces with the most points first. Points in no face and no line, such as those in
///         the middle of the edges of second order, are in none of several pieces
/// \cost O(n log n) in the corners of the patch
std::vector<PatchPiece> piecesOf(const far::MeshPatch& patch, std::span<const Point3> places);

}  // namespace espalier::solve
