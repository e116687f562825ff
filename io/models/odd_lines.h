// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace espalier::io {

/// Counts the lines of a file that a reader keeps or skips without understanding them, for a note
/// (Model::notes()).
class OddLines {
public:
    /// \param word the word of the line that the note shows
    void add(std::string_view word, std::size_t line) {
        if (count_++ == 0) first_ = concat("(", inQuotes(word), " in line ", line, ")");
    }

    bool empty() const { return count_ == 0; }

    /// Returns "3 lines whose first word no OBJ has ('foo' in line 7)".
    /// \param what the words after the number and "lines"
    std::string phrase(std::string_view what) const {
        return concat(count_, count_ == 1 ? " line " : " lines ", what, " ", first_);
    }

private:
    std::size_t count_ = 0;
    std::string first_;
};

/// Returns true if a reader may keep a line that begins with this word although it does not know
/// the word: the word is no number, and the line is text. Binary data and lines of numbers are
/// signs of a damaged file. \param line without its line end
inline bool canBeOdd(std::string_view word, std::string_view line) {
    const auto isPrintable = [](char c) { return c > ' ' && c <= '~'; };
    const auto isText = [](char c) { return c < 0 || c >= ' ' || (c >= '\t' && c <= '\r'); };
    constexpr std::string_view kBeginsNumber = "0123456789+-.";
    return !word.empty() && std::ranges::all_of(word, isPrintable) &&
           kBeginsNumber.find(word.front()) == std::string_view::npos &&
           std::ranges::all_of(line, isText);
}

}  // namespace espalier::io
