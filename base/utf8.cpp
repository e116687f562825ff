// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/utf8.h>

namespace espalier {

CodePoint firstCodePoint(std::string_view text) {
    const std::uint32_t lead = static_cast<unsigned char>(text[0]);
    if (lead < 0x80) return {lead, 1, true};
    const std::size_t size = lead < 0xC2 || lead > 0xF4 ? 0 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
    const CodePoint stray{lead, 1, false};
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

}  // namespace espalier
