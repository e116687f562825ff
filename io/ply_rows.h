// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/point.h>
#include <espalier/io/coordinates.h>
#include <espalier/io/ply_header.h>

#include <filesystem>
#include <string_view>
#include <vector>

namespace espalier::io {

/// The points of a PLY file, and where in its bytes they are; one entry each a vertex.
struct PlyPoints {
    std::vector<Point3> positions;
    std::vector<CoordinatePlaces> places;
};

/// Walks through all rows of a PLY file.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line (ASCII) or the byte (binary) if there are fewer rows than the
/// header claims, if one is malformed, or if a position is not finite
/// \cost   takes memory for as many points as there are bytes for, whatever the header claims
PlyPoints readPlyRows(const std::filesystem::path& path, std::string_view bytes,
                      const PlyHeader& header);

}  // namespace espalier::io
