// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

/// \file
/// Reads CGNS files (.cgns) as models, by CGNS's own library: an optional component, since only it
/// needs that library. Files may be of either storage, HDF5 or ADF.
///
/// The points of a model are the coordinates of all zones of all bases: zone after zone, the arrays
/// CoordinateX, CoordinateY and CoordinateZ of GridCoordinates. New coordinates are written into
/// these arrays in place; all other bytes of the file stay. Points that zones share are points of
/// each.
///
/// The cells are the elements of unstructured zones (TETRA_4, PYRA_5, PENTA_6, HEXA_8, MIXED, and
/// NFACE_n with NGON_n), and the hexahedra of structured zones. TRI_3, QUAD_4, and NGON_n without
/// NFACE_n are faces.
///
/// CGNS's library is not made for hostile files: read files of strangers in a process of their own.
/// Any number of threads may read files; they wait for each other, as the library is not
/// thread-safe.
///
/// The bytes are read from a temporary file. Reading throws FileError if the library refuses the
/// file, if a zone has no Cartesian coordinates of single or double precision, or if a coordinate
/// is not finite.

namespace espalier::io {

/// Makes readModel() know the extension .cgns. To be called once, by a program that is linked with
/// this component, before other threads read files.
ESPALIER_API void addCgnsModels();

}  // namespace espalier::io
