// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/shapes/lattice.h>

#include <span>
#include <vector>

/// \file
/// The vertices of a lattice that poses and fits keep in place, such as the outer vertices of a
/// collar (cages/collar.h). The lattice and its files have them as integers with the name "held".
namespace espalier::shapes {

/// The name of the integers, one for each vertex: a vertex with a 1 is held, and one with a 0 is
/// not. Vertices of refined and merged lattices that have no integers (noInteger()) are not held.
/// Data of this name with several components, with other numbers or with floating-point numbers
/// mean something else, and hold no vertex.
inline constexpr const char* kHeld = "held";

/// Returns the vertices that are held, ascending.
ESPALIER_API std::vector<Index> heldVertices(const Lattice& lattice);

/// Throws if the lattice has data with the name "held" that mean something else, because
/// setHeldVertices() would replace them.
/// \throws Error
ESPALIER_API void requireHeldIsFree(const Lattice& lattice);

/// Makes the given vertices the held ones, and no others.
/// \param vertices in any order; repeated numbers count once
/// \throws ArgumentError for a vertex that does not exist; as requireHeldIsFree()
ESPALIER_API void setHeldVertices(Lattice& lattice, std::span<const Index> vertices);

/// Returns weights for the operations of pose.h: 0 for held vertices, and 1 for the others.
ESPALIER_API std::vector<double> weightsWithHeld(const Lattice& lattice);

/// Returns the weights with 0 for held vertices.
/// \throws Error unless there is one weight per vertex, from 0 to 1
ESPALIER_API std::vector<double> weightsWithHeld(const Lattice& lattice,
                                                 std::span<const double> weights);

/// Returns the vertices that a fit keeps: the given ones and the held ones, ascending.
/// \param frozen in any order; numbers of vertices that do not exist are kept, too
ESPALIER_API std::vector<Index> frozenWithHeld(const Lattice& lattice,
                                               std::span<const Index> frozen = {});

}  // namespace espalier::shapes
