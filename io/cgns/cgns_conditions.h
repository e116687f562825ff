// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../meshes/cell_visitor.h"
#include "cgns_file.h"

namespace espalier::io {

/// A boundary condition of a zone (BC_t). Its family is its patch, if it has one: the patch then
/// has the conditions of all zones with this family.
struct CgnsCondition {
    std::string name;      ///< of the patch
    std::string type;      ///< "BCWall"; empty if neither the condition nor its family has one
    int dimension = 2;     ///< of the patch
    bool isRange = false;  ///< two numbers, or two triples of a structured zone, are its ends

    /// Vertices; or elements of an unstructured zone; or faces of a structured one.
    enum class Place { Vertices, Elements, Faces } place = Place::Vertices;

    /// Of faces of a structured zone: the axis across them. Nothing if the range tells: one of its
    /// axes has one layer.
    std::optional<std::size_t> axis = {};

    /// Numbers from 1 on; in a structured zone, as many for each point as the zone has axes.
    std::vector<cgsize_t> numbers = {};
};

/// Reads the boundary conditions of a zone. Conditions at cells of a structured zone are left out.
/// \throws FileError if CGNS's library refuses one, or if it has numbers below 1
std::vector<CgnsCondition> readConditions(const ZoneFile& file, const Zone& zone);

/// Passes the points and faces of the conditions of a structured zone to a visitor.
/// \throws FileError if one is outside of the zone
void visitGridConditions(const ZoneFile& file, const Zone& zone,
                         const std::vector<CgnsCondition>& conditions, CellVisitor& visitor);

/// The conditions of an unstructured zone at each of its elements.
class ElementConditions {
public:
    /// \throws FileError if an element has more than 100 conditions
    ElementConditions(const ZoneFile& file, const std::vector<CgnsCondition>& conditions);

    /// Goes to an element.
    /// \return true if its conditions are others than those of the element before
    bool goTo(cgsize_t element);

    /// The names of the conditions of the current element.
    const std::vector<std::string>& names() const { return names_; }

    /// Returns the number of elements of all conditions to which nobody went.
    Index missing() const;

private:
    /// The first element with other conditions than the one before it.
    struct Change {
        cgsize_t element;
        std::vector<std::size_t> conditions;
    };

    const std::vector<CgnsCondition>& conditions_;
    std::vector<Change> changes_;
    std::size_t current_ = 0;
    std::vector<std::string> names_;
    std::uint64_t total_ = 0, visited_ = 0;
};

}  // namespace espalier::io
