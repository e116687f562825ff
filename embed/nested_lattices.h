// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>

namespace espalier::embed {

/// Carries points by a lattice, the child, that lies in another, the parent: x' = D · p', with
/// D = D_child · D_parent one table, points × vertices of the parent.
///
/// D_parent binds the vertices of the child where they are in its pose, with the parent at rest. So
/// the child's own displacements are not added to what the parent does, but are made in the frame
/// that the parent deforms: pose the child, then the parent, and the model goes along as if it had
/// been deformed by the child alone, and all of that by the parent. A parent that turns turns the
/// child's displacements with it. With the child at rest too, the points keep their places.
///
/// Nests go as deep as wanted: the result is the table of a child in the parent's parent.
///
/// \param child D_child, points × vertices of the child; the rows of points that it keeps in place
///        stay empty
/// \param childPose of each of its vertices, in the space where the parent is at rest
/// \param options of binding to the parent; where a vertex of the child is outside of the parent,
/// OutsidePolicy::Nearest
///        takes it along; any other policy refuses it
/// \throws Error if there are not as many positions as columns of D_child; naming a vertex of the
///         child that is not finite, that lies outside of the parent, or in a degenerate cell of
///         it; and as bindPoints()
/// \cost as bindPoints() for the vertices of the child, and the product
/// \cite MacCracken & Joy 1996, section 5: x' = D · p', twice
ESPALIER_API stencils::StencilTable<double> nestTables(const stencils::StencilTable<double>& child,
                                                       std::span<const Point3> childPose,
                                                       const RestLattice& parent,
                                                       const BindingOptions& options = {});

}  // namespace espalier::embed
