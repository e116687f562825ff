// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/shapes/selection.h>

#include <span>
#include <vector>

/// \file
/// Selects vertices of a lattice along its cells, where selection.h uses positions alone: a hand
/// beside a hip is near the hip in space, but far from it along the cells.
///
/// The *distance along the cells* is the length of the shortest way of straight lines, each between
/// two vertices of one cell. It is the distance in space or more: along the diagonals of cubes at
/// most 9 % more.
///
/// Positions are one per vertex. Numbers of vertices may be in any order and repeated; results are
/// ascending. All functions throw Error if the complex is not a lattice, and for positions that do
/// not fit it or are not finite; ArgumentError for a number out of range.

namespace espalier::shapes {

/// Adds the vertices that an edge joins to a selected vertex, `steps` times.
/// \param steps 0 or more
/// \cost O(vertices · min(steps, vertices))
ESPALIER_API std::vector<Index> growSelection(const far::CellComplex& complex,
                                              std::span<const Index> vertices, int steps = 1);

/// Removes the vertices that an edge joins to a vertex that is not selected, `steps` times.
/// \param steps 0 or more
/// \cost O(vertices · min(steps, vertices))
ESPALIER_API std::vector<Index> shrinkSelection(const far::CellComplex& complex,
                                                std::span<const Index> vertices, int steps = 1);

/// Gives vertices the weight 1. The falloff uses the distance along the cells from the nearest of
/// them.
/// \cost O(n log n) for n = Σ (vertices of a cell)²
ESPALIER_API std::vector<double> selectAlongCells(const far::CellComplex& complex,
                                                  std::span<const Point3> positions,
                                                  std::span<const Index> vertices,
                                                  const Falloff& falloff = {});

/// Selects the vertices within a distance of a point along the cells. Ways begin at the point, and
/// go on from the vertices of the cell at the nearest face.
/// \param radius 0 or more; the falloff measures the distance beyond it
/// \cost O(faces) + O(n log n) for n = Σ (vertices of a cell)²
ESPALIER_API std::vector<double> selectNear(const far::CellComplex& complex,
                                            std::span<const Point3> positions, const Point3& point,
                                            double radius, const Falloff& falloff = {});

/// Faces across a lattice, and their middle.
struct Section {
    std::vector<Index> faces;   ///< ascending
    double area = 0;            ///< the sum of their areas
    Point3 center = {0, 0, 0};  ///< the mean of their middles, weighted by their areas
};

/// Returns the border of a selection: the faces between the cells of which all vertices are
/// selected and the other cells. If there are no such faces, as for a layer of vertices, the border
/// has the faces of which all vertices are selected, and which are in a cell that has others.
///
/// The middle of the border is the place about which a selected limb turns: its joint.
/// \throws Error also if there are no such faces, or they have no area
/// \cost O(faces)
ESPALIER_API Section selectionBorder(const far::CellComplex& complex,
                                     std::span<const Point3> positions,
                                     std::span<const Index> vertices);

}  // namespace espalier::shapes
