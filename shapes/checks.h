// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>

#include <initializer_list>
#include <string>

// Checks of what callers pass to the functions of this folder; not installed. Each throws an Error
// of one line: who refuses, which field, its value, and what is allowed.
namespace espalier::shapes {

/// The shortest text that reads back as `value`.
std::string textOf(double value);
std::string textOf(const Point3& point);

[[noreturn]] void refuseField(const std::string& shape, const std::string& field,
                              const std::string& value, const std::string& allowed);

void requireAtLeast(const std::string& shape, const std::string& field, int value, int least);
void requireFinite(const std::string& shape, const std::string& field, double value);
void requireFinite(const std::string& shape, const std::string& field, const Point3& value);
void requirePositive(const std::string& shape, const std::string& field, double value);

/// "field[index]": how messages name an entry of a list.
std::string indexed(const std::string& field, std::size_t index);

/// That min[index] and max[index] are finite and in this order.
void requireInterval(const std::string& shape, std::size_t index, double min, double max);

/// That a number of entities, or of entries in their loops, given by its factors (each above 0),
/// can be counted by an Index. Asked before memory is taken for them.
/// \throws far::TopologyError (TooManyEntities)
void requireCountable(const std::string& shape, std::initializer_list<Offset> factors);

/// That a lattice has the dimension that `who` works on, one finite position a vertex and
/// `components` values a vertex in each attribute, and marks on vertices that exist.
/// \param name how the message calls the lattice: "the mesh", "lattice 2"
void requireConsistent(const std::string& who, const std::string& name, const Lattice& lattice,
                       int dimension);

}  // namespace espalier::shapes
