// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/printable.h>

#include <algorithm>
#include <cstdint>

namespace espalier {
namespace {

/// A code point of a text, or a byte that is no part of one.
struct Unit {
    std::uint32_t value;
    std::size_t size;  ///< in bytes
    bool isCharacter;  ///< false for a byte that is not UTF-8
};

bool isContinuation(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0) == 0x80;
}

/// Decodes the first code point of a text that is not empty (Unicode 15, table 3-7).
Unit firstUnit(std::string_view text) {
    const std::uint32_t lead = static_cast<unsigned char>(text[0]);
    if (lead < 0x80) return {lead, 1, true};
    const std::size_t size = lead < 0xC2 || lead > 0xF4 ? 0 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
    const Unit stray{lead, 1, false};
    if (size == 0 || text.size() < size) return stray;
    std::uint32_t value = lead & (0x7FU >> size);
    for (std::size_t i = 1; i < size; ++i) {
        if (!isContinuation(text[i])) return stray;
        value = value << 6 | (static_cast<unsigned char>(text[i]) & 0x3FU);
    }
    constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool isSurrogate = value >= 0xD800 && value <= 0xDFFF;
    if (value < kLeast[size] || value > 0x10FFFF || isSurrogate) return stray;
    return {value, size, true};
}

struct Range {
    std::uint32_t first, last;
};

// Code points that a terminal obeys, or does not show.
constexpr Range kEscaped[] = {
    {0x00, 0x1F},        // C0
    {0x7F, 0x9F},        // DEL and C1
    {0x61C, 0x61C},      // direction of writing
    {0x200B, 0x200B},    // without width
    {0x200E, 0x200F},    // direction of writing
    {0x2028, 0x202E},    // ends of lines and paragraphs, direction of writing
    {0x2060, 0x206F},    // invisible, direction of writing
    {0xFDD0, 0xFDEF},    // no characters
    {0xFEFF, 0xFEFF},    // byte order mark
    {0xFFF0, 0xFFFB},    // annotations, and not assigned
    {0xFFFE, 0xFFFF},    // no characters
    {0xE0000, 0xE0FFF},  // tags
};

bool isEscaped(std::uint32_t value) {
    const bool isNoCharacter = (value & 0xFFFE) == 0xFFFE;  // the last two of each plane
    return isNoCharacter || std::ranges::any_of(kEscaped, [&](const Range& range) {
               return value >= range.first && value <= range.last;
           });
}

std::string hexadecimal(std::uint32_t value, std::size_t digits) {
    std::string result(digits, '0');
    for (auto digit = result.rbegin(); digit != result.rend(); ++digit, value >>= 4)
        *digit = "0123456789ABCDEF"[value & 0xF];
    return result;
}

std::string escaped(std::string_view text) {
    std::string result;
    while (!text.empty()) {
        const Unit unit = firstUnit(text);
        if (unit.isCharacter && !isEscaped(unit.value))
            result += text.substr(0, unit.size);
        else if (unit.size == 1)
            result += "\\x" + hexadecimal(unit.value, 2);
        else if (unit.value <= 0xFFFF)
            result += "\\u" + hexadecimal(unit.value, 4);
        else
            result += "\\U" + hexadecimal(unit.value, 8);
        text.remove_prefix(unit.size);
    }
    return result;
}

/// The largest place that is not after `at`, and not within a code point.
std::size_t placeBetweenCharacters(std::string_view text, std::size_t at) {
    for (std::size_t back = 0; back < 4 && back <= at; ++back) {
        const std::size_t begin = at - back;
        if (begin == text.size() || !isContinuation(text[begin])) return begin;
    }
    return at;  // that is no UTF-8
}

}  // namespace

std::string printable(std::string_view text, std::size_t maxBytes) {
    if (text.size() <= maxBytes) return escaped(text);
    const std::size_t begin = placeBetweenCharacters(text, maxBytes - maxBytes / 2);
    const std::size_t end = placeBetweenCharacters(text, text.size() - maxBytes / 2);
    return escaped(text.substr(0, begin)) + "..." + escaped(text.substr(end));
}

}  // namespace espalier
