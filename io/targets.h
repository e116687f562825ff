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

/// The wanted position of one point of a model.
struct Target {
    Index point;  ///< number of the point in the model, from 0
    Point3 position;
    std::size_t line;  ///< line of the file, for messages
};

/// Reads targets from text, one per line: the number of a point and three coordinates, separated by
/// white space. A # begins a comment, which ends with the line.
///
/// \param pointCount number of points of the model
/// \throws FileError with the line, if a word is no number or not finite, if the model has no such
///         point, or if a point comes twice; FileError if there are no targets
ESPALIER_API std::vector<Target> readTargets(const std::filesystem::path& path, Index pointCount);

/// The same for a file that is in memory already.
/// \param path for messages
/// \param bytes the whole file
ESPALIER_API std::vector<Target> readTargets(const std::filesystem::path& path, Index pointCount,
                                             std::string_view bytes);

}  // namespace espalier::io
