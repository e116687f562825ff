// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/argument_error.h>
#include <espalier/base/index.h>
#include <espalier/base/number_text.h>
#include <espalier/base/point.h>
#include <espalier/base/vector3.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>

#include <initializer_list>
#include <span>
#include <string>

// Checks of the arguments of this folder's functions; not installed. Each check throws an
// ArgumentError, unless it says otherwise.
namespace espalier::shapes {

void requireAtLeast(const std::string& shape, const std::string& field, int value, int least);
void requireFinite(const std::string& shape, const std::string& field, double value);
void requireFinite(const std::string& shape, const std::string& field, const Point3& value);
void requirePositive(const std::string& shape, const std::string& field, double value);

/// Returns the unit vector of a direction.
/// \throws ArgumentError unless the vector is finite and not zero
Point3 unitVector(const std::string& shape, const std::string& field, const Point3& vector);

/// Throws an Error that names the first position that is not finite, "positions[3]".
/// \param name of the positions: "positions"
void requireFinite(const std::string& name, std::span<const Point3> positions);

/// Returns "field[index]", the name of a list entry in messages.
std::string indexed(const std::string& field, std::size_t index);

/// Throws unless the two ends of an interval are finite and in this order.
void requireInterval(const std::string& shape, const std::string& minField, double min,
                     const std::string& maxField, double max);

/// Throws if the product of the factors (each above 0) is too large for an Index. It is the number
/// of entities, or of entries in their loops; call this before allocating memory for them.
/// \throws far::TopologyError (TooManyEntities)
void requireCountable(const std::string& shape, std::initializer_list<Offset> factors);

/// Throws unless a lattice has the dimension that `who` works on, one finite position per vertex,
/// `components` values per vertex in each attribute, and marks on vertices that exist.
/// \param name name of the lattice in the message: "the mesh", "lattice 2"
void requireConsistent(const std::string& who, const std::string& name, const Lattice& lattice,
                       int dimension);

}  // namespace espalier::shapes
