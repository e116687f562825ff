// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "coordinates.h"
#include "ply_header.h"

namespace espalier::io {

/// Three numbers of each vertex, and where in the bytes of the file they are.
struct PlyVectors {
    std::array<Precision, 3> precisions;
    std::vector<Point3> values;
    std::vector<CoordinatePlaces> places;
};

struct PlyPoints {
    PlyVectors positions;
    /// Of the header's directions, in their order. What cannot be read as a number is NaN.
    std::vector<PlyVectors> directions;
};

/// Walks through all rows of a PLY file.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line (ASCII) or the byte (binary) if there are fewer or more rows
/// than the header claims, if one is malformed, or if a position is not finite
/// \cost   takes memory for as many points as there are bytes for, whatever the header claims
PlyPoints readPlyRows(const std::filesystem::path& path, std::string_view bytes,
                      const PlyHeader& header);

}  // namespace espalier::io
