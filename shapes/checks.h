// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/number_text.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>

#include <initializer_list>
#include <string>

// Checks of the arguments of this folder's functions; not installed. Each check throws an Error of
// one line that names the function, the field, its value, and the allowed values.
namespace espalier::shapes {

bool isFinite(const Point3& point);

[[noreturn]] void refuseField(const std::string& shape, const std::string& field,
                              const std::string& value, const std::string& allowed);

void requireAtLeast(const std::string& shape, const std::string& field, int value, int least);
void requireFinite(const std::string& shape, const std::string& field, double value);
void requireFinite(const std::string& shape, const std::string& field, const Point3& value);
void requirePositive(const std::string& shape, const std::string& field, double value);

/// Returns the unit vector of a direction.
/// \throws Error unless the vector is finite and not zero
Point3 unitVector(const std::string& shape, const std::string& field, const Point3& vector);

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
