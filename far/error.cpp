// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>

namespace espalier {

std::string inQuotes(std::string_view text) {
    constexpr std::size_t kLongest = 40;
    constexpr char kDigits[] = "0123456789ABCDEF";
    std::string result = "'";
    for (const char c : text.substr(0, kLongest)) {
        const auto code = static_cast<unsigned char>(c);
        if (code >= ' ' && code != 0x7F)
            result += c;
        else
            result.append("\\x").append(1, kDigits[code / 16]).append(1, kDigits[code % 16]);
    }
    return result + (text.size() > kLongest ? "...'" : "'");
}

}  // namespace espalier
