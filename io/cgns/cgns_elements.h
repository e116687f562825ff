// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../meshes/cell_visitor.h"
#include "cgns_file.h"

namespace espalier::io {

/// Passes the elements of a zone to a visitor. Their sections are groups, but not the sections of
/// faces that polyhedra name.
/// \throws FileError if an element is malformed, or names a point that does not exist
void visitElements(const ZoneFile& file, const Zone& zone, CellVisitor& visitor);

}  // namespace espalier::io
