// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/base/utf8.h>

#include <algorithm>
#include <cstdint>

namespace espalier {
namespace {

struct Range {
    std::uint32_t first, last;
};

// Code points that control a terminal, or that it does not show.
constexpr Range kEscaped[] = {
    {0x00, 0x1F},        // C0
    {0x7F, 0x9F},        // DEL and C1
    {0x61C, 0x61C},      // direction of writing
    {0x200B, 0x200B},    // no width
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
        const CodePoint unit = firstCodePoint(text);
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

/// Returns the largest place up to `at` that is not within a code point.
std::size_t placeBetweenCharacters(std::string_view text, std::size_t at) {
    for (std::size_t back = 0; back < 4 && back <= at; ++back) {
        const std::size_t begin = at - back;
        if (begin == text.size() || !isContinuation(text[begin])) return begin;
    }
    return at;  // not UTF-8
}

}  // namespace

std::string printable(std::string_view text, std::size_t maxBytes) {
    if (text.size() <= maxBytes) return escaped(text);
    const std::size_t begin = placeBetweenCharacters(text, maxBytes - maxBytes / 2);
    const std::size_t end = placeBetweenCharacters(text, text.size() - maxBytes / 2);
    return escaped(text.substr(0, begin)) + "..." + escaped(text.substr(end));
}

std::string inQuotes(std::string_view text) {
    constexpr std::size_t kMaxBytes = 40;
    std::string result = "'";
    return result.append(printable(text, kMaxBytes)).append("'");
}

}  // namespace espalier
