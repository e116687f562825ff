// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace espalier::io {

/// Takes the next word, a longest run without white space, off a line; empty when there is none.
inline std::string_view takeWord(std::string_view& line) {
    constexpr std::string_view kSpace = " \t\r\v\f";
    line.remove_prefix(std::min(line.find_first_not_of(kSpace), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(kSpace));
    line.remove_prefix(word.size());
    return word;
}

/// How messages show a piece of a file: in quotes, and never longer than a line.
inline std::string inQuotes(std::string_view text) {
    constexpr std::size_t kLongest = 40;
    std::string result;
    result += '\'';
    result += text.substr(0, kLongest);
    result += text.size() > kLongest ? "...'" : "'";
    return result;
}

}  // namespace espalier::io
