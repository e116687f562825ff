// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "../meshes/cell_visitor.h"
#include "cgns_conditions.h"
#include "cgns_file.h"

namespace espalier::io {

/// Passes the elements of a zone to a visitor. Their sections are groups, but not the sections of
/// faces that polyhedra name, nor sections with the name of a boundary condition. The boundary
/// conditions are groups, too.
///
/// \param conditions of the zone
/// \param names of the conditions of all zones
/// \return the number of elements that conditions name, and that the zone does not have
/// \throws FileError if an element or a condition is malformed, or names a point that does not
/// exist
Index visitElements(const ZoneFile& file, const Zone& zone,
                    const std::vector<CgnsCondition>& conditions,
                    const std::set<std::string>& names, CellVisitor& visitor);

}  // namespace espalier::io
