// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <filesystem>

namespace espalier::io {

/// The name of the file of pose `number` when `count` poses are written to `pattern`.
///
/// `%d` in the pattern, or `%0Nd` with N from 1 to 99, gives the number its place, and zeros up to
/// N digits. In a pattern without, one pose has the pattern itself; of several, each has its number
/// of at least four digits before the extension: out.obj gives out.0000.obj.
///
/// \param number from 0
/// \throws Error if the pattern has more than one place for the number or a % that is none, if it
/// names no file, or if the number is negative
ESPALIER_API std::filesystem::path numberedPath(const std::filesystem::path& pattern, int number,
                                                int count);

}  // namespace espalier::io
