// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

// Numbers and names as texts for a report. Not installed.
namespace espalier::compare {

/// Escapes a text for the content or an attribute of an element. Control characters, which are not
/// allowed in a page, and bytes that are not UTF-8 become U+FFFD.
std::string escaped(std::string_view text);

/// "3.1e-16"; "0", "infinite" and "not a number" for these values.
std::string scientific(double value);

/// "12,345".
std::string grouped(std::size_t count);

/// "1 face", "2 faces", "12,345 faces".
std::string counted(std::size_t count, std::string_view one, std::string_view many);

}  // namespace espalier::compare
