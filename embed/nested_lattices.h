// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>

namespace espalier::embed {

/// Composes two bindings: points bound to a lattice (the child), which is bound to another lattice
/// (the parent). Returns one table D = D_child · D_parent, points × vertices of the parent, so that
/// x' = D · p'.
///
/// D_parent binds the vertices of the posed child, with the parent at rest. So the child deforms
/// the model first, and the parent then deforms the result. A parent that rotates also rotates the
/// child's displacements. If both lattices are at rest, the points keep their places.
///
/// Any depth of nesting is possible: the result can be the child's table for the parent's parent.
///
/// \param child D_child, points × vertices of the child; empty rows (points kept in place) stay
///        empty
/// \param childPose one position per vertex of the child, in the space where the parent is at rest
/// \param options of binding to the parent; a vertex of the child outside the parent is carried
///        under OutsidePolicy::Nearest, and is an error under any other policy
/// \throws Error if the number of positions differs from the number of columns of D_child; if a
///         vertex of the child is not finite, outside the parent, or in a degenerate cell of the
///         parent (names the vertex); and as bindPoints()
/// \cost as bindPoints() for the vertices of the child, and the product
/// \cite MacCracken & Joy 1996, section 5: x' = D · p', twice
ESPALIER_API stencils::StencilTable<double> nestTables(const stencils::StencilTable<double>& child,
                                                       std::span<const Point3> childPose,
                                                       const RestLattice& parent,
                                                       const BindingOptions& options = {});

}  // namespace espalier::embed
