// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <filesystem>

namespace espalier::io {

/// Returns the name of the file for pose `number` when `count` poses are written to `pattern`.
///
/// The number replaces `%d` in the pattern, or `%0Nd` with N from 1 to 99, which pads it with zeros
/// to N digits. If the pattern has no such place, a single pose gets the pattern itself, and
/// several poses get their number, of at least four digits, before the extension: out.obj becomes
/// out.0000.obj, and the folder out/ becomes out.0000/.
///
/// \param number from 0
/// \throws Error if the pattern has more than one % or a % that begins neither form, if it names no
///         file, or if the number is negative
ESPALIER_API std::filesystem::path numberedPath(const std::filesystem::path& pattern, int number,
                                                int count);

}  // namespace espalier::io
