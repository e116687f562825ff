// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iosfwd>

#include "../models/surface_writers.h"

namespace espalier::io {

// The writers below write a new file, with points of type double (Float64), polygons, and the
// normals of the points, if the surface has any, as the active normals "Normals".

/// Writes a .vtp (PolyData), compressed.
void writeVtpSurface(std::ostream& out, const SurfaceView& surface);

/// Writes a .vtu (UnstructuredGrid), compressed, with cells of the types 5 (triangle), 9
/// (quadrilateral) and 7 (polygon).
void writeVtuSurface(std::ostream& out, const SurfaceView& surface);

/// Writes a legacy .vtk (POLYDATA), ASCII, version 3.0. Numbers are the shortest that read back as
/// the same double.
void writeVtkLegacySurface(std::ostream& out, const SurfaceView& surface);

}  // namespace espalier::io
