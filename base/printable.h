// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <cstddef>
#include <string>
#include <string_view>

namespace espalier {

/// The number of bytes of a name or a path that messages and reports show.
inline constexpr std::size_t kMaxShownBytes = 256;

/// A text from outside (a path, a name or a word of a file) as messages and reports show it: on one
/// line, and without anything that a terminal obeys.
///
/// Control characters, marks that turn the direction of writing, invisible characters, and code
/// points that stand for no character are escaped: "\x1B", "\u202E". So are bytes that are not
/// UTF-8. Everything else stays, backslashes too, so that a text that was escaped stays as it is.
///
/// A text of more than `maxBytes` bytes keeps its beginning and its end, with "..." between them.
ESPALIER_API std::string printable(std::string_view text, std::size_t maxBytes = kMaxShownBytes);

}  // namespace espalier
