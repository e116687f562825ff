// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/directions.h>

#include <filesystem>
#include <iosfwd>
#include <span>
#include <string_view>

#include "coordinates.h"

namespace espalier::io {

/// Writes an OBJ with its points moved and its normals carried, as readObj() says.
///
/// \param path of the file that was read
/// \param points of the `v` statements
/// \param gradients one a point
/// \cost as readObj() says
void writeWithNormals(std::ostream& out, const std::filesystem::path& path, std::string_view text,
                      const VectorChange& points, std::span<const DeformationGradient> gradients);

}  // namespace espalier::io
