// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <cstddef>
#include <string>
#include <string_view>

namespace espalier {

/// The largest number of bytes of a name or a path that messages and reports show.
inline constexpr std::size_t kMaxShownBytes = 256;

/// Returns a text from outside (a path, a name or a word of a file) as messages and reports show
/// it: on one line, and without anything that controls a terminal.
///
/// Control characters, marks that change the writing direction, invisible characters, code points
/// without a character, and bytes that are not UTF-8 are escaped: "\x1B", "\u202E". Everything else
/// stays, including backslashes, so that escaping twice changes nothing.
///
/// A text of more than `maxBytes` bytes is shortened to its beginning, "..." and its end.
ESPALIER_API std::string printable(std::string_view text, std::size_t maxBytes = kMaxShownBytes);

}  // namespace espalier
