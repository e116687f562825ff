// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>

namespace espalier::io {

/// Reads an STL, ASCII or binary. Its points are the three corners of each facet in turn: a vertex
/// of the surface is there once a facet.
///
/// A file is binary if its size is that of the facets that it claims, 84 + 50 · n bytes, even where
/// its header begins with "solid". A binary file holds floats.
///
/// On writing, a facet of which a corner moved gets the normal of its new corners, or 0 0 0 where
/// they are on a line; any other keeps its normal. Headers, names and attribute bytes are kept.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError as readModel(); if the size is not that of a binary file and the file does not
/// begin with "solid"; if a position is not finite
/// \cost   one pass; the file is kept, with 24 bytes a point (binary) or 88 (ASCII)
ESPALIER_API std::unique_ptr<Model> readStl(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io
