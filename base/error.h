// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace espalier {

/// Base of every exception that Espalier throws on purpose, except Cancelled (progress.h), which is
/// not an error. what() is one line that names the offender. The library never prints and never
/// aborts.
class ESPALIER_API Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Returns a word or a name from outside as messages show it: printable (printable.h) and in
/// quotes. A text of more than 40 bytes is shortened to its beginning and its end.
ESPALIER_API std::string inQuotes(std::string_view text);

/// Returns the shortest text that reads back as `value`: "0.1", "1e+300".
ESPALIER_API std::string textOf(double value);

/// Joins texts and numbers to one text, for messages.
template <class... Parts>
std::string concat(const Parts&... parts) {
    std::string text;
    const auto append = [&]<class Part>(const Part& part) {
        if constexpr (std::is_floating_point_v<Part>)
            text += textOf(part);
        else if constexpr (std::is_arithmetic_v<Part>)
            text += std::to_string(part);
        else
            text += part;
    };
    (append(parts), ...);
    return text;
}

/// Returns the first items of a range, for messages: "4, 7, 9", or "4, 7, 9, ..." if the range has
/// more than `maximum` items.
template <class Range>
std::string listed(const Range& items, std::size_t maximum = 5) {
    std::string text;
    std::size_t count = 0;
    for (const auto& item : items) {
        if (count == maximum) return text + ", ...";
        text += concat(count++ == 0 ? "" : ", ", item);
    }
    return text;
}

}  // namespace espalier
