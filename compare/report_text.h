// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

// How a report words numbers and names; not installed.
namespace espalier::compare {

/// A text as content or attribute of an element. Control characters, which no page may hold, and
/// bytes that are not UTF-8 become U+FFFD.
std::string escaped(std::string_view text);

/// "3.1e-16"; "0", "infinite" and "not a number" for these.
std::string scientific(double value);

/// "12,345".
std::string grouped(std::size_t count);

/// "1 face", "2 faces", "12,345 faces".
std::string counted(std::size_t count, std::string_view one, std::string_view many);

}  // namespace espalier::compare
