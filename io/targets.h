// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

namespace espalier::io {

/// Where a point of a model is wanted.
struct Target {
    Index point;  ///< its number in the model, from 0
    Point3 position;
    std::size_t line;  ///< of the file
};

/// Reads targets from text, one a line: the number of a point and three coordinates, with white
/// space between. What follows a # is a comment, to the end of its line.
///
/// \param pointCount of the model
/// \throws FileError with the line for what is no number, not finite, or no point of the model, and
///         for a point that comes twice; if there are no targets
ESPALIER_API std::vector<Target> readTargets(const std::filesystem::path& path, Index pointCount);

/// The same for a file that is in memory already.
/// \param path for messages
/// \param bytes the whole file
ESPALIER_API std::vector<Target> readTargets(const std::filesystem::path& path, Index pointCount,
                                             std::string_view bytes);

}  // namespace espalier::io
