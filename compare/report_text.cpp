// SPDX-License-Identifier: Apache-2.0
#include "report_text.h"
#include <espalier/base/utf8.h>

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace espalier::compare {

std::string escaped(std::string_view text) {
    std::string result;
    while (!text.empty()) {
        const CodePoint point = firstCodePoint(text);
        const std::uint32_t c = point.value;
        if (!point.isCharacter || c == 0x7F || (c < ' ' && c != '\n' && c != '\t')) {
            result += "\uFFFD";
        } else if (c == '&') {
            result += "&amp;";
        } else if (c == '<') {
            result += "&lt;";
        } else if (c == '>') {
            result += "&gt;";
        } else if (c == '"') {
            result += "&quot;";
        } else if (c == '\'') {
            result += "&#39;";
        } else {
            result += text.substr(0, point.size);
        }
        text.remove_prefix(point.size);
    }
    return result;
}

std::string scientific(double value) {
    if (std::isnan(value)) return "not a number";
    if (std::isinf(value)) return "infinite";
    if (value == 0) return "0";
    return fmt::format("{:.1e}", value);
}

std::string grouped(std::size_t count) {
    const std::string digits = std::to_string(count);
    std::string result;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        if (i > 0 && (digits.size() - i) % 3 == 0) result += ',';
        result += digits[i];
    }
    return result;
}

std::string counted(std::size_t count, std::string_view one, std::string_view many) {
    return fmt::format("{} {}", grouped(count), count == 1 ? one : many);
}

}  // namespace espalier::compare
