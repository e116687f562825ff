// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>

#include <filesystem>
#include <string_view>
#include <vector>

#include "file_model.h"
#include "ply_header.h"

// Reads the rows of PLY files.

namespace espalier::io {

/// Returns true for the elements of faces and of strips of triangles.
bool isFaces(const PlyElement& element);

/// Returns true if a list of an element of faces has their corners.
bool isCornerList(const PlyProperty& property);

/// Returns true if a list of an element of faces has the texture coordinates of their corners.
bool isTextureList(const PlyProperty& property);

/// A property of the vertices, and its numbers.
struct PlyColumn {
    std::size_t column;
    std::vector<double> values;
};

/// Reads all rows of a PLY file. Memory is allocated only for points that the file has bytes for,
/// whatever the header claims.
///
/// \param path for messages
/// \param bytes the whole file
/// \param surface receives the faces with their texture coordinates; may be null
/// \param wanted receives a property of the points; may be null
/// \throws FileError with the line (ASCII) or the byte (binary) if there are fewer or more rows
///         than the header claims, if a row is malformed, or if a position is not finite
FileNumbers readPlyRows(const std::filesystem::path& path, std::string_view bytes,
                        const PlyHeader& header, ModelSurface* surface = nullptr,
                        PlyColumn* wanted = nullptr);

}  // namespace espalier::io
