// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>

#include <span>
#include <vector>

// Measures lattices: distances along their cells, areas and volumes; not installed.
namespace espalier::shapes {

/// A vertex where ways begin, and the length of the way before it.
struct WayStart {
    Index vertex = 0;
    double length = 0;  ///< 0 or more
};

/// Returns the distance of each vertex from the nearest start along the cells: the length of the
/// shortest way of straight lines, each between two vertices of one cell. A vertex that no way
/// reaches has an infinite distance.
/// \param positions one per vertex, finite
/// \cost O(n log n) for n = Σ (vertices of a cell)²
ESPALIER_API std::vector<double> distancesAlongCells(const far::CellComplex& complex,
                                                     std::span<const Point3> positions,
                                                     std::span<const WayStart> starts);

/// Returns the vertices of a cell, with their distances from a point, as starts of ways.
std::vector<WayStart> waysFrom(const Point3& point, const far::CellComplex& complex,
                               std::span<const Point3> positions, Index cell);

/// Returns the face of which a point is nearest to a given point, the first one of several. A face
/// consists of the triangles between its edges and the mean of its vertices.
/// \param betweenCells look at the faces between two cells only
/// \returns −1 if there is no such face
Index nearestFace(const far::CellComplex& complex, std::span<const Point3> positions,
                  const Point3& point, bool betweenCells = false);

/// Returns the cell at the face that is nearest to a point. If the face is between two cells, it is
/// the cell on the side of the point.
Index nearestCell(const far::CellComplex& complex, std::span<const Point3> positions,
                  const Point3& point);

/// Returns the vertices of a face in their loop.
std::vector<Point3> loopOf(const far::CellComplex& complex, std::span<const Point3> positions,
                           Index face);

/// Returns the volume of a cell: the sum of the volumes, without sign, of the tetrahedra that join
/// the mean of its vertices to the triangles of its faces.
double cellVolume(const far::CellComplex& complex, std::span<const Point3> positions, Index cell);

/// Returns the mean of the vertices of a cell.
Point3 cellMiddle(const far::CellComplex& complex, std::span<const Point3> positions, Index cell);

}  // namespace espalier::shapes
