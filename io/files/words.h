// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
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

}  // namespace espalier::io
