// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

/// \file
/// Decodes UTF-8.

namespace espalier {

/// A code point of a text, or a byte that is not UTF-8.
struct CodePoint {
    std::uint32_t value;
    std::size_t size;  ///< number of bytes
    bool isCharacter;  ///< false for a byte that is not UTF-8
};

/// Decodes the first code point of a text that is not empty (Unicode 15, table 3-7).
ESPALIER_API CodePoint firstCodePoint(std::string_view text);

/// True for the second, third and fourth byte of a code point.
inline bool isContinuation(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0) == 0x80;
}

}  // namespace espalier
