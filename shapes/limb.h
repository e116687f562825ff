// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/shapes/cell_selection.h>

#include <span>
#include <vector>

/// \file
/// Finds the limbs of a lattice: the part beyond a narrow section, such as an arm with its hand,
/// a leg, an ear.
///
/// All functions throw Error if the complex is not a lattice, and for positions that do not fit it,
/// are not finite or are more than 1e90 apart.

namespace espalier::shapes {

/// A part of a lattice, and the section that joins it to the rest.
struct Limb {
    std::vector<Index> cells;     ///< ascending
    std::vector<Index> vertices;  ///< all vertices of these cells; ascending
    Section section;              ///< the faces between these cells and the rest

    /// The opening of the section: see selectLimb(). 1 in selectBeyond().
    double opening = 1;
};

/// Selects the limb at a point: the part of the lattice beyond the narrowest section between the
/// point and the body.
///
/// The cell at the point (that of the nearest face) comes first; the cells follow in the order of
/// their distance from the point along the cells (cell_selection.h; the distance of a cell is the
/// mean of the distances of its vertices). Cells that no way reaches are left out. The first k
/// cells are a part of the lattice with a volume V(k). A(k) is the area of the faces between them
/// and the rest. Parts that end between cells of equal distances do not count, and neither do parts
/// that only vertices or edges join to the rest.
///
/// The width of the section of k is A(k) / V(k)^(2/3). It falls along a limb, because the volume
/// grows and the area does not; it stays about the same for a ball that grows in a body; it rises
/// where a limb opens into a body. The *opening* of the section of k is the largest ratio of the
/// width of a later section to its own, among the sections before the next narrower one with at
/// most half of the volume. The limb
/// is the part with the largest opening among the parts of at most a third of the volume, if this
/// opening is 1.5 or more: so a foot selects the leg, not all up to the waist. Otherwise it is the
/// part with the largest opening among those of at most a half, if this opening is 2 or more. Of
/// equal openings, the smaller part counts.
///
/// \param point in the coordinates of the positions; finite; inside or outside the lattice
/// \throws Error also if no section opens so far: boxes, balls, rods and tubes have no limbs
/// \cost O(faces + n log n) for n = Σ (vertices of a cell)², and O(cells²) for the openings
ESPALIER_API Limb selectLimb(const far::CellComplex& complex, std::span<const Point3> positions,
                             const Point3& point);

/// Selects the part of the lattice beyond a face between two cells: one of the cells, and all cells
/// that are joined to it by faces between cells whose middle is on the same side of the plane of
/// the face. The plane goes through the mean of the vertices of the face, across its area vector.
/// Of the two cells, the one counts whose part has the smaller volume; of equal volumes, the cell
/// with the lower number. Other limbs on the same side of the plane are not selected, unless they
/// are joined to the part there.
/// \throws ArgumentError for a face that does not exist or is not between two cells
/// \cost O(cells)
ESPALIER_API Limb selectBeyond(const far::CellComplex& complex, std::span<const Point3> positions,
                               Index face);

/// Returns the face between two cells that is nearest to a point. A face consists of the triangles
/// between its edges and the mean of its vertices. Of equal distances, the lower number counts.
/// \throws Error also if no face is between two cells
/// \cost O(faces)
ESPALIER_API Index nearestInnerFace(const far::CellComplex& complex,
                                    std::span<const Point3> positions, const Point3& point);

}  // namespace espalier::shapes
