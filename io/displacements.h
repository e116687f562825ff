// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <filesystem>
#include <string_view>
#include <vector>

/// \file
/// Reads how far the vertices of a lattice move, as a loop in any language writes it.

namespace espalier::io {

/// Reads the displacement of each vertex of a lattice; (0, 0, 0) for vertices that the file does
/// not name. The extension of the path tells the format:
///
/// - `.csv`: a line `vertex,dx,dy,dz` for each vertex that moves, in any order. The first line may
///   be the header `vertex,dx,dy,dz`. Empty lines and lines that begin with # are skipped. The
///   number of a vertex may be a real without a fraction: 3.0.
/// - `.npy`: an array of NumPy with a row for each vertex that moves, in any order: its number and
///   the vector, n × 4; or with the vectors of all vertices in their order, n × 3. Integers, and
///   reals of 4 or 8 bytes, in C or Fortran order.
///
/// \param vertexCount number of vertices of the lattice
/// \return vertexCount displacements
/// \throws FileError with the line (or the row, from 0) for a number that is malformed or not
///         finite, for a vertex that the lattice does not have, and for a vertex that comes twice;
///         FileError if the file has another extension, another shape, or no row
ESPALIER_API std::vector<Point3> readDisplacements(const std::filesystem::path& path,
                                                   Index vertexCount);

/// The same for a file that is in memory already.
/// \param path for messages, and for the format
/// \param bytes the whole file
ESPALIER_API std::vector<Point3> readDisplacements(const std::filesystem::path& path,
                                                   Index vertexCount, std::string_view bytes);

}  // namespace espalier::io
