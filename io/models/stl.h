// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>

namespace espalier::io {

/// Reads an STL, ASCII or binary, as a model. Its points are the three corners of each facet, facet
/// after facet; so a vertex of the surface is repeated for each facet around it.
///
/// A file is binary if it has exactly the 84 + 50 · n bytes of the n facets that it claims, even if
/// its header begins with "solid". A binary file holds floats.
///
/// On writing, a facet with a corner that moved gets the normal of its new corners, or 0 0 0 if
/// they lie on a line. All other facets keep their normals. Headers, names and attribute bytes are
/// kept.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError as readModel(); if the file neither has the size of a binary file nor begins
///         with "solid"; if a position is not finite
/// \cost one pass; the file is kept, with 24 bytes per point (binary) or 88 (ASCII)
ESPALIER_API std::unique_ptr<Model> readStl(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io
