// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/box_tree.h>
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/length_unit.h>

#include <span>

namespace espalier::embed {

/// Finds the cell of a refined lattice that contains a point.
///
/// A point belongs to the cell of lowest number that contains it. (If Newton's method from the
/// centre of a twisted cell misses the point, the point belongs to that cell only if no other cell
/// contains it.) Faces that are not flat leave small gaps: a hexahedron has a bilinear face, and
/// its type-n neighbour a folded one. A point in a gap belongs to the nearest cell, by continuing
/// that cell's map along its tangent. Any number of threads may use it at once; results depend on
/// the point only.
///
/// \cite MacCracken & Joy 1996, sections 4 to 6
class ESPALIER_API PointLocator {
public:
    /// \param complex a lattice of level 1 or above; kept (a cheap copy)
    /// \param positions one per vertex; copied
    /// \param tolerance distance within which a point outside still counts as inside, as a fraction
    ///        of the diagonal of the lattice's bounding box, 0 or more
    /// \throws Error if `complex` is not a lattice of quadrilaterals, `positions` do not fit it or
    ///         are not finite, or `tolerance` is out of range
    /// \cost O(cells log cells)
    PointLocator(const far::CellComplex& complex, std::span<const Point3> positions,
                 double tolerance);

    /// The same, measured by the scale of the base lattice, of which `complex` is a level.
    PointLocator(const far::CellComplex& complex, std::span<const Point3> positions,
                 CellSolver::Scale scale);

    /// \param seekNearest whether to find a place for a point outside
    LocatedPoint locate(const Point3& point, bool seekNearest) const;

private:
    LocatedPoint locateInUnits(const Point3& position, bool seekNearest) const;

    LengthUnit unit_;
    CellSolver solver_;  ///< the solver works on positions in units
    BoxTree tree_;
    Point3 vertex_;  ///< any vertex of the lattice
    double size_;    ///< the size of the lattice
};

}  // namespace espalier::embed
