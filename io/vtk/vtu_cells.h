// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vtk_cells.h"
#include "vtk_xml.h"

namespace espalier::io {

/// Reads the cells of all pieces of an unstructured grid, with polyhedra in the layout since VTK
/// 9.4 or in the older one.
///
/// \throws FileError with the line, or TopologyError with the path in its message
void readVtuCells(const VtkXmlFile& file, VtkCellReader& cells);

}  // namespace espalier::io
